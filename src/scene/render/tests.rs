use super::*;
use crate::base::Kind;
use crate::fem::{Element, Space};
use crate::mesh::{Diagonals, rectangle};
use crate::output::{FieldData, Series, SeriesWriter, write_pvd, write_vtu};
use nalgebra::SVector;
use std::collections::BTreeMap;
use std::fs;
use std::io::BufReader;
use std::sync::Arc;

/// A run with valid files and arbitrary numbers.
struct Case {
    membranes: &'static [&'static str],
    output: &'static str,
    columns: &'static [&'static str],
    summary: &'static str,
    frames: usize,
}

const CAVITY: Case = Case {
    membranes: &[],
    output: "picture = { field = \"speed\", size = 300 }
probes.middle = { at = [0.5, 0.5], of = \"velocity\" }
forces.lid = { boundary = \"top\" }
fluxes.left = { boundary = \"left\" }
profiles.line = { from = [0, 0.5], to = [1, 0.5], of = \"speed\" }",
    columns: &[
        "energy_kinetic",
        "dissipation",
        "energy_balance",
        "velocity_max",
        "middle_x",
        "middle_y",
        "lid_x",
        "lid_y",
        "lid_stress_x",
        "lid_stress_y",
        "left",
    ],
    summary: "{ \"status\": \"finished\" }",
    frames: 5,
};

const PAIR: Case = Case {
    membranes: &["one", "two"],
    output: "picture = { field = \"pressure\", size = 300 }",
    columns: &[
        "one.area",
        "one.perimeter",
        "one.axis_1",
        "one.axis_2",
        "two.area",
        "two.perimeter",
        "energy_kinetic",
    ],
    summary: "{ \"status\": \"failed\", \"error\": \"a <b> blow-up\", \"end_time\": 0.3, \"alarms\": [\"first & last\"] }",
    frames: 2,
};

fn scene(case: &Case) -> String {
    let membrane = |(k, name): (usize, &&str)| {
        let x = 0.25 + 0.5 * k as f64;
        format!(
            "[[membrane]]\nname = \"{name}\"\nshape.circle = {{ centre = [{x}, 0.5], radius = \
             0.15 }}\narea.linear = {{ modulus = 1 }}\n"
        )
    };
    format!(
        "[mesh]\nrectangle = {{ min = [0, 0], max = [1, 1], cells = [4, 4] }}\n[fluid]\nviscosity \
         = 1\n[boundary.walls]\nno_slip = true\n{}[time]\nend = 1\nstep = 0.1\n[output]\n{}\n",
        case.membranes.iter().enumerate().map(membrane).collect::<String>(),
        case.output
    )
}

/// Writes the folder of a run with circular membranes.
fn write(case: &Case, folder: &Path) {
    write_with(case, folder, |p, x| (p - SVector::<f64, 2>::new(x, 0.5)).norm() - 0.15);
}

/// Writes the folder of a run with level set `phi` of a membrane about `x = at`.
fn write_with(case: &Case, folder: &Path, phi: impl Fn(&SVector<f64, 2>, f64) -> f64 + Sync) {
    fs::create_dir_all(folder.join("fields")).unwrap();
    fs::write(folder.join("scene.toml"), scene(case)).unwrap();
    fs::write(folder.join("immersa.run"), "run folder of immersa").unwrap();
    fs::write(folder.join("summary.json"), case.summary).unwrap();
    let mut series = SeriesWriter::create(&folder.join("series.csv"), case.columns).unwrap();
    for k in 0..11 {
        let values: Vec<f64> =
            (0..case.columns.len()).map(|c| 1.0 + (f64::from(k) * 0.1 + c as f64).sin()).collect();
        series.append(0.1 * f64::from(k), &values).unwrap();
    }
    let mesh = rectangle([0.0, 0.0], [1.0, 1.0], [4, 4], Diagonals::Right).unwrap();
    let space = Space::new(&Arc::new(mesh), Element::P2);
    let (phi, names) = (
        [0.25, 0.75].map(|at| space.interpolate(|x| phi(x, at))),
        case.membranes.iter().map(|m| format!("{m}.level_set")),
    );
    let names: Vec<String> = names.collect();
    let list = (0..case.frames).map(|k| {
        let (t, name) = (k as f64 / 4.0, format!("fields/{k:06}.vtu"));
        let u = space.interpolate(|x| SVector::<f64, 2>::new(x[1] - 0.5, 0.5 - x[0]) * t);
        let p = space.interpolate(|x| x[0] * t);
        let mut fields =
            vec![("velocity", FieldData::Vector(&u)), ("pressure", FieldData::Scalar(&p))];
        fields.extend(names.iter().zip(&phi).map(|(n, f)| (n.as_str(), FieldData::Scalar(f))));
        write_vtu(&folder.join(&name), &space, t, &fields).unwrap();
        (t, name)
    });
    write_pvd(&folder.join("fields.pvd"), &list.collect::<Vec<_>>()).unwrap();
}

fn page(folder: &Path) -> String {
    fs::read_to_string(render(folder).unwrap().report).unwrap()
}

#[test]
fn a_flow_without_a_membrane_has_all_that_it_measured() {
    let dir = tempfile::tempdir().unwrap();
    write(&CAVITY, dir.path());
    fs::create_dir(dir.path().join("profiles")).unwrap();
    let x = [0.0, 0.5, 1.0];
    let columns = (0..20).map(|k| (format!("t=0.{k:02}"), x)).collect::<Vec<_>>();
    let mut table = vec![("distance", &x[..]), ("x", &x), ("y", &x)];
    table.extend(columns.iter().map(|(n, c)| (n.as_str(), &c[..])));
    Series::new(&table).write(&dir.path().join("profiles/line.csv")).unwrap();
    let made = render(dir.path()).unwrap();
    assert!(made.warnings.is_empty(), "{:?}", made.warnings);
    let name = |p: &PathBuf| p.strip_prefix(dir.path()).unwrap().to_string_lossy().into_owned();
    let names: Vec<String> = made.files.iter().map(name).collect();
    for wanted in [
        "pictures/000004.png",
        "film.gif",
        "charts/energy.svg",
        "charts/probe-middle.svg",
        "charts/force-lid.svg",
    ] {
        assert!(names.iter().any(|n| n == wanted), "{wanted} is not among {names:?}");
    }
    assert_eq!(names.last().unwrap(), "report.html");
    assert!(made.files.iter().all(|f| f.is_file()));
    let page = fs::read_to_string(&made.report).unwrap();
    for text in [
        "arrows show the velocity",
        "The speed along the line from (0, 0.5)",
        "One of 4 columns",
        "t=0.19",
        "by stress",
    ] {
        assert!(page.contains(text), "{text} is missing");
    }
    assert!(
        !page.contains("Semi-axes")
            && !page.contains("interfaces.pvd")
            && !page.contains("the interface")
            && !page.contains("elastic</text>")
    );
}

#[test]
fn a_failed_run_of_two_membranes_says_so_and_shows_what_there_is() {
    let dir = tempfile::tempdir().unwrap();
    write(&PAIR, dir.path());
    let page = page(dir.path());
    let alarms =
        ["The computation failed at t = 0.3 of 1: a &lt;b&gt; blow-up", "first &amp; last"];
    for text in alarms.iter().chain(&[
        "Semi-axes of one",
        "Area inside of two",
        "Half-chords",
        "Area inside of one",
    ]) {
        assert_eq!(page.contains(text), *text != "Half-chords", "{text}");
    }
    assert!(page.find("first &amp; last") < page.find("class=\"numbers\""));
}

#[test]
fn an_interrupted_run_without_fields_or_rows_has_a_page() {
    let dir = tempfile::tempdir().unwrap();
    let case = Case {
        summary: "{ \"status\": \"interrupted\", \"seconds\": { \"solve\": null } }",
        ..CAVITY
    };
    write(&case, dir.path());
    fs::remove_file(dir.path().join("fields.pvd")).unwrap();
    fs::write(dir.path().join("series.csv"), "time,energy_kinetic\n").unwrap();
    let made = render(dir.path()).unwrap();
    let warned: Vec<String> = made.warnings.iter().map(ToString::to_string).collect();
    assert!(warned[0].contains("profile `line`") && warned[1].contains("no fields"), "{warned:?}");
    let page = fs::read_to_string(&made.report).unwrap();
    assert!(
        page.contains("was interrupted;")
            && page.contains("--resume")
            && page.contains("no fields"),
        "{page}"
    );
}

#[test]
fn pictures_that_are_not_wanted_are_not_made() {
    let dir = tempfile::tempdir().unwrap();
    write(&PAIR, dir.path());
    let set = |text: &str| vec![text.to_string()];
    render_with(dir.path(), &[set("output.pictures=false"), set("output.film=false")].concat())
        .unwrap();
    assert!(!dir.path().join("pictures").exists() && !dir.path().join("film.gif").exists());
    render_with(dir.path(), &set("output.film=false")).unwrap();
    assert!(
        dir.path().join("pictures/000001.png").exists() && !dir.path().join("film.gif").exists()
    );
    let speed = fs::read(dir.path().join("pictures/000001.png")).unwrap();
    render_with(dir.path(), &set("output.picture.field=speed")).unwrap();
    assert_ne!(speed, fs::read(dir.path().join("pictures/000001.png")).unwrap());
    assert_eq!(
        render_with(dir.path(), &set("output.picture.field=sped")).unwrap_err().kind(),
        Kind::Scene
    );
}

#[test]
fn one_stored_field_gives_a_picture_and_no_film() {
    let dir = tempfile::tempdir().unwrap();
    write(&Case { frames: 1, ..PAIR }, dir.path());
    let made = render(dir.path()).unwrap();
    assert!(made.warnings[0].what.contains("no film"), "{:?}", made.warnings);
    assert!(
        dir.path().join("pictures/000000.png").exists() && !dir.path().join("film.gif").exists()
    );
}

/// Number of pixels of the most frequent colour of a picture, except its white background.
fn pixels_of_one_colour(picture: &Path) -> usize {
    let mut reader =
        png::Decoder::new(BufReader::new(fs::File::open(picture).unwrap())).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let frame = reader.next_frame(&mut pixels).unwrap();
    assert_eq!(frame.color_type, png::ColorType::Rgb);
    let mut count = BTreeMap::<&[u8], usize>::new();
    for colour in pixels[..frame.buffer_size()].chunks_exact(3).filter(|c| **c != [255; 3]) {
        *count.entry(colour).or_default() += 1;
    }
    count.into_values().max().unwrap()
}

/// The distance from a line has slope 1 everywhere; that from a circle does not on such a coarse
/// mesh.
#[test]
fn the_stretch_of_a_distance_is_one_in_one_colour() {
    let dir = tempfile::tempdir().unwrap();
    let case = Case {
        membranes: &["one"],
        output: "picture = { field = \"stretch\", size = 300 }",
        ..PAIR
    };
    let picture = dir.path().join("pictures/000001.png");
    write_with(&case, dir.path(), |x, at| x[0] - at);
    render(dir.path()).unwrap();
    // The square is 131 pixels wide, less axes, the two lines of the interface and the colour bar.
    assert!(pixels_of_one_colour(&picture) > 15000);
    write(&case, dir.path());
    render(dir.path()).unwrap();
    assert!(pixels_of_one_colour(&picture) < 1500);
}

/// A damage to the folder, and texts that the message must contain.
type Broken = (fn(&Path), &'static [&'static str]);

#[test]
fn what_is_missing_or_damaged_is_named() {
    let cases: [Broken; 8] = [
        (
            |f| fs::remove_file(f.join("scene.toml")).unwrap(),
            &["not the folder of a run", "scene.toml", "immersa run"],
        ),
        (
            |f| fs::remove_file(f.join("summary.json")).unwrap(),
            &["has not ended", "summary.json", "--resume"],
        ),
        (
            |f| fs::write(f.join("summary.json"), "{ \"status\":").unwrap(),
            &["summary.json:1:", "again"],
        ),
        (
            |f| fs::write(f.join("summary.json"), "{ \"steps\": \"ten\" }").unwrap(),
            &["summary.json:1:", "\"ten\""],
        ),
        (|f| fs::remove_file(f.join("series.csv")).unwrap(), &["series.csv"]),
        (
            |f| fs::write(f.join("series.csv"), "a,b\n1,2\n").unwrap(),
            &["series.csv", "time", "a, b"],
        ),
        (|f| fs::remove_file(f.join("fields/000001.vtu")).unwrap(), &["fields/000001.vtu"]),
        (|f| fs::write(f.join("fields.pvd"), "hello").unwrap(), &["fields.pvd", "not a PVD file"]),
    ];
    for (k, (damage, texts)) in cases.iter().enumerate() {
        let dir = tempfile::tempdir().unwrap();
        write(&PAIR, dir.path());
        damage(dir.path());
        let error = render(dir.path()).unwrap_err();
        assert_eq!(error.kind(), Kind::Input, "case {k}");
        for text in *texts {
            assert!(error.to_string().contains(text), "case {k}: {text} is missing in {error}");
        }
        assert!(!dir.path().join("report.html").exists());
    }
}

#[test]
fn a_scene_that_was_never_computed_is_told_from_a_run_that_was_stopped() {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("scene.toml"), scene(&PAIR)).unwrap();
    let error = render(dir.path()).unwrap_err();
    assert!(
        error.what().contains("holds a scene but no run") && error.advice().contains("immersa run"),
        "{error}"
    );
}

#[test]
fn a_level_set_that_the_fields_do_not_have_is_named() {
    let dir = tempfile::tempdir().unwrap();
    write(&Case { membranes: &[], ..PAIR }, dir.path());
    fs::write(dir.path().join("scene.toml"), scene(&PAIR)).unwrap();
    fs::write(dir.path().join("immersa.run"), "run folder of immersa").unwrap();
    let error = render(dir.path()).unwrap_err();
    assert_eq!(error.kind(), Kind::Input);
    assert!(
        error.to_string().contains("one.level_set") && error.place().contains("000000.vtu"),
        "{error}"
    );
}

const SESSIONS: &str = r#"{ "status": "finished", "sessions": [
    { "started": "2026-01-31T12:00:00Z", "ended": "2026-01-31T13:00:00Z", "version": "0.1.0 (abcdef)",
      "command": "immersa run <scene>.toml", "machine": "4 threads" },
    { "started": "2026-02-01T23:00:00Z", "ended": "2026-02-02T01:00:00Z", "version": "0.1.0 (abcdef)",
      "command": "immersa run scene.toml --resume", "machine": "4 threads" }] }"#;

#[test]
fn a_page_says_when_and_by_what_its_run_was_computed() {
    let dir = tempfile::tempdir().unwrap();
    write(&Case { summary: SESSIONS, frames: 1, ..PAIR }, dir.path());
    let page = page(dir.path());
    for text in [
        "2026-01-31 12:00:00 to 13:00:00 UTC\n2026-02-01 23:00:00 UTC to 2026-02-02 01:00:00 UTC<",
        "immersa run &lt;scene&gt;.toml\nimmersa run scene.toml --resume<",
        ">immersa 0.1.0 (abcdef)<",
        ">4 threads<",
    ] {
        assert!(page.contains(text), "{text} is missing");
    }
}

#[test]
fn units_are_on_axes_and_in_tables() {
    let dir = tempfile::tempdir().unwrap();
    write(&CAVITY, dir.path());
    let with = |units: &str| {
        let set = [format!("units={units}"), "output.pictures=false".into()];
        let report = render_with(dir.path(), &set).unwrap().report;
        let chart = |name: &str| fs::read_to_string(dir.path().join("charts").join(name)).unwrap();
        let charts =
            ["speed.svg", "energy.svg", "force-lid.svg", "fluxes.svg", "energy-balance.svg"];
        (fs::read_to_string(report).unwrap(), charts.map(chart).join(""))
    };
    let (page, charts) = with("{ length = \"mm\", time = \"ms\", mass = \"g\" }");
    for label in [
        ">time (ms)<",
        ">speed (mm/ms)<",
        ">energy (g·mm/ms²)<",
        ">force (g/ms²)<",
        ">volume per time (mm²/ms)<",
        ">residual (%)<",
    ] {
        assert!(charts.contains(label), "{label} is missing");
    }
    for (column, unit) in [
        ("velocity_max", "mm/ms"),
        ("middle_x", "mm/ms"),
        ("lid_stress_y", "g/ms²"),
        ("left", "mm²/ms"),
        ("energy_balance", ""),
    ] {
        let row = format!("<td>{column}</td><td>{unit}</td>");
        assert!(page.contains(&row), "{row} is missing");
    }
    assert!(page.contains("steps of 0.1 ms") || page.contains("units: mm, ms, g"));
    assert_eq!(with("\"mm, ms, g\"").1, charts, "the text names the same");
    // What is no unit is said once.
    let (page, charts) = with("\"diameters of the cell\"");
    assert_eq!(page.matches("diameters of the cell").count(), 2, "under the title, in the scene");
    assert!(charts.contains(">speed<") && !page.contains("<th>unit</th>"));
}

#[test]
fn a_scene_keeps_its_units() {
    let text = |units: &str| format!("units = {units}\n{}", scene(&CAVITY));
    let read = |text: &str| crate::scene::Scene::parse(text, Path::new("a/scene.toml"));
    for units in
        ["\"SI\"", "{ length = \"µm\" }", "{ length = \"mm\", time = \"s\", mass = \"g\" }"]
    {
        let first = read(&text(units)).unwrap();
        assert_eq!(read(&first.to_toml()).unwrap().units, first.units, "{units}");
    }
    for (wrong, said) in
        [("3", "units"), ("{ lenght = \"mm\" }", "length"), ("{ mass = 2 }", "mass")]
    {
        let error = read(&text(wrong)).unwrap_err();
        assert!(error.kind() == Kind::Scene && error.to_string().contains(said), "{error}");
    }
}

/// Two runs of one scene whose viscosities differ, and one of another scene.
fn three_runs(dir: &Path) -> [PathBuf; 3] {
    let folders = ["thin", "thick", "pair"].map(|name| dir.join("runs").join(name));
    write(&CAVITY, &folders[0]);
    write(&CAVITY, &folders[1]);
    write(&PAIR, &folders[2]);
    let thick = scene(&CAVITY).replace("viscosity = 1\n", "viscosity = 2\n");
    fs::write(folders[1].join("scene.toml"), thick).unwrap();
    folders
}

/// The names in the legend of the chart of this title.
fn curves(page: &str, title: &str) -> Vec<String> {
    let svg = page.split("<svg").find(|svg| svg.contains(&format!("aria-label=\"{title}\"")));
    let data = svg.unwrap_or_else(|| panic!("no chart {title}"));
    let data = data.split("data-chart=\"").nth(1).unwrap().split('"').next().unwrap();
    let data: serde_json::Value = serde_json::from_str(&data.replace("&quot;", "\"")).unwrap();
    let names = data["curves"].as_array().unwrap().iter();
    names.map(|c| c["name"].as_str().unwrap().to_string()).collect()
}

#[test]
fn runs_are_drawn_over_each_other_by_what_differs() {
    let dir = tempfile::tempdir().unwrap();
    let [thin, thick, pair] = three_runs(dir.path());
    let path = overlay(&[thin.clone(), thick.clone()], &[], None).unwrap();
    assert_eq!(path, dir.path().canonicalize().unwrap().join("runs/overlay.html"));
    let page = fs::read_to_string(&path).unwrap();
    assert_eq!(curves(&page, "Largest speed"), ["fluid.viscosity = 1", "fluid.viscosity = 2"]);
    // One line a run: of two components there are two charts; references are left out.
    for title in ["Force lid: x", "Force lid: y", "Energy: dissipated"] {
        assert_eq!(curves(&page, title).len(), 2, "{title}");
    }
    assert!(!page.contains("Force lid: x, by stress") && !page.contains("Not shown"));
    assert!(page.contains("<a href=\"thick/report.html\">"), "links from the page to the runs");

    let out = dir.path().join("all.html");
    overlay(&[thin, thick, pair], &[], Some(&out)).unwrap();
    let page = fs::read_to_string(&out).unwrap();
    assert_eq!(curves(&page, "Energy: kinetic"), ["thin", "thick"]);
    assert_eq!(curves(&page, "Largest speed"), ["thin", "thick"]);
    assert!(page.contains("Not in: pair.") && page.contains("Semi-axes of one: larger"));
    assert!(page.contains("pair: the run has failed\nfirst &amp; last"));
    assert!(page.contains("<a href=\"runs/pair/series.csv\">"));
}

#[test]
fn an_overlay_replaces_nothing_but_an_overlay() {
    let dir = tempfile::tempdir().unwrap();
    let [thin, thick, _] = three_runs(dir.path());
    let runs = [thin.clone(), thick.clone()];
    let out = dir.path().join("mine.html");
    fs::write(&out, "mine").unwrap();
    let refused = [
        overlay(&runs, &[], Some(&out)).unwrap_err(),
        overlay(&runs, &[], Some(&thin.join("scene.toml"))).unwrap_err(),
    ];
    for error in refused {
        assert!(error.what().contains("is not replaced") && error.kind() == Kind::Input, "{error}");
    }
    assert_eq!(fs::read(&out).unwrap(), b"mine");
    for (folders, said) in [
        (vec![thin.clone()], "nothing to be compared"),
        (vec![thin.clone(), dir.path().join("runs/../runs/thin")], "given twice"),
        (vec![thin.clone(), dir.path().join("none")], "cannot be opened"),
        (vec![thin, dir.path().join("runs")], "no scene.toml"),
    ] {
        let error = overlay(&folders, &[], None).unwrap_err();
        assert!(error.to_string().contains(said) && !error.advice().is_empty(), "{error}");
    }
    let first = overlay(&runs, &[], None).unwrap();
    assert_eq!(overlay(&runs, &[], None).unwrap(), first, "an overlay is made again");
}
