//! What a run writes for other programs: fields, interfaces, boundaries, pictures, coefficients.

use super::case::{self, Case};
use super::program::*;
use flate2::read::ZlibDecoder;
use immersa::output::{Series, read_pvd, read_vtu};
use std::fs;
use std::io::Read;
use std::path::Path;

/// Words that are refused with all of these.
fn refused(changes: &[&str], words: &[&str]) {
    let said = case::refused(SCENE, changes);
    words.iter().for_each(|word| assert!(said.contains(word), "`{word}` is missing in {said}"));
}

/// An array of a VTK file with appended data, as numbers of eight bytes.
fn array(path: &Path, name: &str) -> Option<Vec<[u8; 8]>> {
    let bytes = fs::read(path).unwrap();
    let start = bytes.windows(22).position(|w| w == b"<AppendedData encoding").unwrap();
    let head = String::from_utf8(bytes[..start].to_vec()).unwrap();
    let data = &bytes[start + bytes[start..].iter().position(|b| *b == b'_').unwrap() + 1..];
    let tag = head.split("<DataArray").find(|t| t.contains(&format!("Name=\"{name}\"")))?;
    let offset = tag.split("offset=\"").nth(1)?.split('"').next()?.parse::<usize>().unwrap();
    let word =
        |k: usize| u64::from_le_bytes(data[offset + 8 * k..][..8].try_into().unwrap()) as usize;
    let (mut out, mut at) = (Vec::new(), offset + 8 * (3 + word(0)));
    for k in 0..word(0) {
        ZlibDecoder::new(&data[at..at + word(3 + k)]).read_to_end(&mut out).unwrap();
        at += word(3 + k);
    }
    if tag.contains("UInt8") {
        return Some(out.iter().map(|b| u64::from(*b).to_le_bytes()).collect());
    }
    Some(out.chunks_exact(8).map(|b| b.try_into().unwrap()).collect())
}

fn numbers(path: &Path, name: &str) -> Vec<f64> {
    array(path, name)
        .unwrap_or_else(|| panic!("no {name}"))
        .into_iter()
        .map(f64::from_le_bytes)
        .collect()
}

fn integers(path: &Path, name: &str) -> Vec<u64> {
    array(path, name)
        .unwrap_or_else(|| panic!("no {name}"))
        .into_iter()
        .map(u64::from_le_bytes)
        .collect()
}

#[test]
fn the_pressure_is_absent_until_there_is_one() {
    let folder = folder_with(SCENE);
    let more = [
        "time.end=0.02",
        "output.pictures=0.01",
        "output.picture={ field = 'pressure' }",
        "output.probes.p={ at = [1, 1], of = 'pressure' }",
    ];
    let mut arguments = vec!["run", "scene.toml", "--out", "run"];
    more.iter().for_each(|set| arguments.extend(["--set", set]));
    immersa(folder.path(), &arguments).expect(0, &[]);
    let run = folder.path().join("run");
    let pressure = |k: usize| {
        let snapshot = read_vtu::<2>(&run.join(format!("fields/{k:06}.vtu"))).unwrap();
        snapshot.scalar("pressure").unwrap().to_vec()
    };
    assert!(pressure(0).iter().all(|p| p.is_nan()), "no step, no pressure");
    assert!(pressure(1).iter().all(|p| p.is_finite()));
    let series = Series::read(&run.join("series.csv")).unwrap();
    for column in ["p", "lid_stress_x"] {
        let values = series.column(column).unwrap();
        assert!(values[0].is_nan() && values[1].is_finite(), "{column}: {values:?}");
    }
    immersa(folder.path(), &["render", "run"]).expect(0, &[]);
    let drawn = |k: usize| run.join(format!("pictures/{k:06}.png")).is_file();
    assert!(!drawn(0) && drawn(1) && drawn(2), "the start has nothing to be shown");
    let speed = ["render", "run", "--set", "output.picture.field=speed"];
    immersa(folder.path(), &speed).expect(0, &[]);
    assert!(drawn(0));
}

#[test]
fn interfaces_have_their_stretch_and_tension_and_the_boundary_its_names() {
    let folder = folder_with(SCENE);
    immersa(folder.path(), &["run", "scene.toml", "--out", "run", "--set", "time.end=0.02"])
        .expect(0, &[]);
    let run = folder.path().join("run");
    let list = read_pvd(&run.join("interfaces.pvd")).unwrap();
    assert_eq!(
        list.iter().map(|e| e.1.as_str()).collect::<Vec<_>>(),
        ["fields/000000.vtp", "fields/000001.vtp", "fields/000002.vtp"]
    );
    let start = run.join("fields/000000.vtp");
    let (points, stretch) = (numbers(&start, "Points"), numbers(&start, "stretch"));
    assert_eq!(points.len(), 3 * stretch.len());
    for (x, r) in points.chunks_exact(3).zip(&stretch) {
        let on = ((x[0] - 1.0) / 0.55).powi(2) + ((x[1] - 1.0) / 0.4).powi(2);
        assert!((on - 1.0).abs() < 0.02 && x[2] == 0.0, "{x:?}");
        assert!((r - 1.2).abs() < 0.03, "{r}");
    }
    // E' = r - 1.
    for (t, r) in numbers(&start, "tension").iter().zip(&stretch) {
        assert!((t - (r - 1.0)).abs() < 1e-14);
    }
    let corners = integers(&start, "connectivity");
    assert_eq!(corners.len(), 2 * stretch.len(), "a closed line has as many pieces as points");
    let moved = numbers(&run.join("fields/000002.vtp"), "velocity");
    assert!(moved.iter().any(|v| *v != 0.0));
    assert!(integers(&start, "interface membrane").iter().all(|m| *m == 1));

    let boundary = run.join("boundaries.vtp");
    let points = numbers(&boundary, "Points");
    let ends = integers(&boundary, "connectivity");
    let top = integers(&boundary, "boundary top");
    assert_eq!((ends.len(), top.iter().sum::<u64>()), (2 * 64, 16));
    for (piece, is_top) in ends.chunks_exact(2).zip(&top) {
        let is_above = piece.iter().all(|&v| points[3 * v as usize + 1] == 2.0);
        assert_eq!(is_above, *is_top == 1);
    }
}

#[test]
fn field_files_hold_what_is_asked_for() {
    let folder = folder_with(
        &SCENE.replace("viscosity = 0.01", "viscosity = { inside = 0.1, outside = 0.01 }"),
    );
    let run = |name: &str, set: &[&str]| {
        let mut arguments = vec!["run", "scene.toml", "--out", name, "--set", "time.end=0.02"];
        set.iter().for_each(|s| arguments.extend(["--set", s]));
        immersa(folder.path(), &arguments).expect(0, &[]);
        folder.path().join(name)
    };
    let all = run("all", &[]);
    let snapshot = read_vtu::<2>(&all.join("fields/000002.vtu")).unwrap();
    let viscosity = snapshot.scalar("viscosity").unwrap();
    let phi = snapshot.scalar("membrane.level_set").unwrap();
    for (mu, phi) in viscosity.iter().zip(phi) {
        if phi.abs() > 0.3 {
            assert!((mu - if *phi < 0.0 { 0.1 } else { 0.01 }).abs() < 1e-12);
        }
        assert!((0.0099..=0.1001).contains(mu));
    }
    assert!(snapshot.scalar("density").is_err(), "it is the same everywhere");
    let vorticity = snapshot.scalar("vorticity").unwrap();
    let u = snapshot.vector("velocity").unwrap();
    assert_eq!(vorticity, snapshot.space.vorticity(u));
    let few = run("few", &["output.store=[]"]);
    let snapshot = read_vtu::<2>(&few.join("fields/000002.vtu")).unwrap();
    let names: Vec<&str> = snapshot.fields.iter().map(|f| f.0.as_str()).collect();
    // The stretch is a field that the membrane carries.
    assert_eq!(names, ["velocity", "pressure", "membrane.level_set", "membrane.stretch"]);
    for name in ["interfaces.pvd", "boundaries.vtp", "fields.vtkhdf", "fields/000000.vtp"] {
        assert!(!few.join(name).exists(), "{name}");
    }
    refused(&["output.store=['vorticities']"], &["output.store", "vorticity"]);
}

#[test]
fn one_file_holds_all_times_also_of_a_run_that_goes_on() {
    let folder = folder_with(SCENE);
    let run = |end: &str, more: &[&str]| {
        let end = format!("time.end={end}");
        let first =
            ["run", "scene.toml", "--out", "run", "--set", &end, "--set", "output.vtkhdf=true"];
        immersa(folder.path(), &[&first[..], more].concat()).expect(0, &[]);
        hdf5_pure::File::open(folder.path().join("run/fields.vtkhdf")).unwrap()
    };
    let times =
        |file: &hdf5_pure::File| file.dataset("VTKHDF/Steps/Values").unwrap().read_f64().unwrap();
    assert_eq!(times(&run("0.02", &[])).len(), 3);
    let file = run("0.04", &["--resume"]);
    let times = times(&file);
    assert_eq!(times.len(), 5);
    assert!((times[4] - 0.04).abs() < 1e-12);
    let last = read_vtu::<2>(&folder.path().join("run/fields/000004.vtu")).unwrap();
    let phi = last.scalar("membrane.level_set").unwrap();
    let all = file.dataset("VTKHDF/PointData/membrane.level_set").unwrap().read_f64().unwrap();
    assert_eq!(&all[4 * phi.len()..], phi, "bit by bit");
    assert_eq!(
        file.dataset("VTKHDF/NumberOfPoints").unwrap().read_i64().unwrap(),
        [phi.len() as i64]
    );
}

#[test]
fn a_window_a_range_and_colours_change_the_picture_and_wrong_ones_are_refused() {
    let folder = folder_with(SCENE);
    let set = ["--set", "output.pictures=0.1"];
    let run = [&["run", "scene.toml", "--out", "run", "--set", "time.end=0.1"][..], &set].concat();
    immersa(folder.path(), &run).expect(0, &[]);
    let draw = |picture: &str| -> Picture {
        let picture = format!("output.picture={{ size = 300, {picture} }}");
        let arguments = [&["render", "run"][..], &set, &["--set", &picture]].concat();
        immersa(folder.path(), &arguments).expect(0, &[]);
        Picture::read(&folder.path().join("run/pictures/000010.png"))
    };
    let plain = draw("mesh = false");
    let middle = |p: &Picture| p.pixel(p.size[0] / 2 - 30, p.size[1] / 3);
    // All speeds are far below a range that ends at 1e3: the colour of its lower end.
    let dark = draw("range = [0, 1e3], colours = 'magma'");
    assert_eq!(middle(&dark), [0, 0, 4]);
    assert!(dark != plain);
    // Half as wide as high: the drawing has more height.
    let part = draw("window = { min = [0.5, 0], max = [1.5, 2] }");
    assert!(part.size[1] > plain.size[1]);
    refused(&["output.picture={ range = [1, 1] }"], &["output.picture.range", "lower value first"]);
    refused(&["output.picture={ range = [0, nan] }"], &["output.picture.range"]);
    refused(&["output.picture={ colours = 'jet' }"], &["output.picture.colours", "viridis"]);
    refused(
        &["output.picture={ window = { min = [0, 0], max = [0, 1] } }"],
        &["window", "no area"],
    );
    refused(
        &["output.picture={ window = { min = [3, 0], max = [4, 1] } }"],
        &["output.picture.window", "misses the domain", "spans"],
    );
    refused(&["output.picture={ window = { min = [0, 0, 0], max = [4, 1, 1] } }"], &["needs 2"]);
}

/// A picture read back.
#[derive(PartialEq, Debug)]
struct Picture {
    size: [usize; 2],
    rgb: Vec<u8>,
}

impl Picture {
    fn read(path: &Path) -> Picture {
        let file = std::io::BufReader::new(fs::File::open(path).unwrap());
        let mut reader = png::Decoder::new(file).read_info().unwrap();
        let mut rgb = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut rgb).unwrap();
        Picture { size: [info.width as usize, info.height as usize], rgb }
    }
    fn pixel(&self, x: usize, y: usize) -> [u8; 3] {
        let at = 3 * (x + y * self.size[0]);
        [self.rgb[at], self.rgb[at + 1], self.rgb[at + 2]]
    }
}

/// The force on the lid of a box, as coefficients.
#[test]
fn drag_and_lift_are_forces_over_the_dynamic_pressure() {
    let reference = "output.forces.lid={ boundary = 'top', reference = { speed = 0.2, length = 2, \
        density = 4, stream = [0, 3] } }";
    let mut case = Case::<immersa::scene::ImmersedFlow>::with(SCENE, &[reference]);
    case.steps(2);
    // Along y is the drag; to its left, along -x, the lift.
    let pressure = 0.5 * 4.0 * 0.2 * 0.2 * 2.0;
    let (drag, lift) = (case.get("lid_y") / pressure, -case.get("lid_x") / pressure);
    assert!((case.get("lid_drag") - drag).abs() < 1e-12 * drag.abs(), "{drag}");
    assert!((case.get("lid_lift") - lift).abs() < 1e-12 * lift.abs(), "{lift}");
    let wrong = |inner: &str, words: &[&str]| {
        let set = format!("output.forces.lid={{ boundary = 'top', reference = {{ {inner} }} }}");
        refused(&[&set], words);
    };
    wrong("speed = 1", &["reference", "length"]);
    wrong("speed = 0, length = 1", &["speed"]);
    wrong("speed = 1, length = 1, stream = [0, 0]", &["stream", "no length"]);
    wrong("speed = 1, length = 1, area = 1", &["area", "the mesh is plane"]);
    refused(
        &[
            "fluid.density=0",
            "output.forces.lid={ boundary = 'top', reference = { speed = 1, length = 1 } }",
        ],
        &["output.forces.lid.reference", "density"],
    );
}

/// A lid that swings takes the fluid with it: its force has the frequency of the lid.
#[test]
fn an_oscillating_lift_has_a_strouhal_number_in_the_summary() {
    let scene = SCENE
        .replace("0.2 * t * sin(pi * x / 2)", "0.2 * sin(20 * pi * t) * sin(pi * x / 2)^2")
        .replace("end = 0.4\nstep = 0.01", "end = 1\nstep = 0.005")
        .replace("every = 0.01\nfields = 0.01", "every = 0.005\nfields = false")
        .replace("checkpoint = 0", "checkpoint = false")
        .replace("times = [0.05, 0.2, 0.4]", "times = [0.05]")
        .replace("[[membrane]]", "[[level_set]]")
        .replace("stretch = 1.2\narea.linear = { modulus = 1 }\n", "")
        .replace("[membrane.chords]\nhorizontal = { through = [1, 1], direction = [1, 0] }\n", "")
        .replace("[numerics]\nthickness = 0.2\n", "")
        .replace(
            "{ boundary = \"top\" }",
            "{ boundary = \"top\", reference = { speed = 0.4, length = 2, stream = [0, 1] } }",
        );
    let folder = folder_with(&scene);
    immersa(folder.path(), &["run", "scene.toml", "--out", "run"]).expect(0, &[]);
    let text = fs::read_to_string(folder.path().join("run/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&text).unwrap();
    let found = &summary["strouhal"]["lid"];
    // f L / U = 10 * 2 / 0.4.
    assert!((found["strouhal"].as_f64().unwrap() / 50.0 - 1.0).abs() < 0.01, "{found}");
    assert!(found["periods"].as_u64().unwrap() >= 3, "{found}");
    immersa(folder.path(), &["render", "run"]).expect(0, &[]);
    let page = fs::read_to_string(folder.path().join("run/report.html")).unwrap();
    assert!(page.contains("Strouhal number of lid") && page.contains("Coefficients of lid"));
}
