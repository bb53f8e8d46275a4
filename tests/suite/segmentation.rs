//! Scenes whose level set segments an image.

use super::case::Case;
use super::program::immersa;
use immersa::output::{GreyImage, Series};
use immersa::scene::{Scene, Segmented, problem};
use std::fs;
use std::path::Path;
use tempfile::TempDir;

#[path = "../../examples/shapes.rs"]
mod shapes;

const SCENE: &str = r#"
[image]
file = "discs.png"
mask = "mask.png"
length = 0.15
[[level_set]]
name = "discs"
shape.circle = { centre = [24, 24], radius = 14 }
[time]
end = 2400
step = 40
[output]
every = 400
fields = 1200
pictures = 1200
"#;

const SIZE: usize = 48;
/// Pixels of the mask, counted when the folder is made.
struct Images {
    folder: TempDir,
    inside: usize,
}

/// Two discs with a stripe of alternating grey for noise, their mask, and the scene.
fn images() -> Images {
    let folder = TempDir::new().unwrap();
    let at = |k: usize| [(k % SIZE) as f64 + 0.5, (SIZE - k / SIZE) as f64 - 0.5];
    let inside = |k: usize| {
        [[12.5, 26.0], [36.0, 21.0]].iter().any(|c| (at(k)[0] - c[0]).hypot(at(k)[1] - c[1]) < 8.0)
    };
    let ripple = |k: usize| 0.1 * (((7 * k) % 5) as f64 - 2.0);
    let levels = |level: &dyn Fn(usize) -> f64| (0..SIZE * SIZE).map(level).collect::<Vec<f64>>();
    let write = |name: &str, levels| {
        fs::write(folder.path().join(name), GreyImage::new(SIZE, levels).unwrap().png().unwrap())
            .unwrap();
    };
    write("discs.png", levels(&|k| if inside(k) { 0.7 } else { 0.3 } + ripple(k)));
    write("mask.png", levels(&|k| f64::from(u8::from(inside(k)))));
    fs::write(folder.path().join("scene.toml"), SCENE).unwrap();
    Images { inside: (0..SIZE * SIZE).filter(|k| inside(*k)).count(), folder }
}

impl Images {
    fn scene(&self, set: &[&str]) -> immersa::base::Result<Scene> {
        let set: Vec<String> = set.iter().map(ToString::to_string).collect();
        Scene::parse_with(SCENE, &self.folder.path().join("scene.toml"), &set)
    }
    fn case(&self, set: &[&str]) -> Case<Segmented> {
        let scene = self.scene(set).unwrap_or_else(|e| panic!("{e}"));
        let model = Segmented::new(&scene).unwrap_or_else(|e| panic!("{e}"));
        Case { scene, model }
    }
    fn refused(&self, set: &[&str]) -> String {
        let made = self.scene(set).and_then(|s| problem(&s).map(drop));
        match made {
            Ok(()) => panic!("{set:?} was not refused"),
            Err(e) => {
                assert!(
                    !e.place().is_empty() && !e.wrong_value().is_empty() && !e.advice().is_empty(),
                    "{set:?}: {e}"
                );
                e.to_string()
            }
        }
    }
}

#[test]
fn one_circle_falls_apart_into_two_discs_and_the_energy_falls() {
    let images = images();
    for mesh in ["title=plain", "mesh.rectangle={ min = [0, 0], max = [48, 48], cells = [32, 32] }"]
    {
        let mut case = images.case(&[mesh]);
        let first = case.get("energy");
        let mut before = first;
        for _ in 0..case.scene.time.steps() {
            case.steps(1);
            let energy = case.get("energy");
            assert!(
                energy <= before * (1.0 + 1e-12),
                "{mesh}, t = {}: {before} {energy}",
                case.time()
            );
            before = energy;
        }
        assert_eq!(case.get("components"), 2.0, "{mesh}");
        let area = case.get("discs.area") / images.inside as f64 - 1.0;
        // The length takes a little of a disc; the pixels do not see it.
        assert!(area.abs() < 0.03 && case.get("area_error").abs() < 0.01, "{mesh}: {area}");
        assert!(case.get("misclassified") <= 2.0, "{mesh}: {}", case.get("misclassified"));
        assert!(before < 0.75 * first, "{mesh}: {first} {before}");
        // The band of four pixels mixes the levels near the contour.
        assert!((case.get("c1") - 0.7).abs() < 0.08 && (case.get("c2") - 0.3).abs() < 0.03);
        let parts = case.get("energy_fidelity") + case.get("energy_length");
        assert!((parts / before - 1.0).abs() < 1e-14);
    }
}

/// Lengths scale with the side of a pixel, the weight of the length too, and times with its square.
#[test]
fn the_side_of_a_pixel_is_a_unit_of_length() {
    let images = images();
    let pixels = images.case(&["time.end=400"]).run();
    let halves = [
        "image.pixel=0.5",
        "image.length=0.075",
        "level_set.0.shape={ circle = { centre = [12, 12], radius = 7 } }",
        "time.end=100",
        "time.step=10",
    ];
    let halves = images.case(&halves).run();
    for (column, power) in
        [("discs.area", 2), ("discs.perimeter", 1), ("energy", 2), ("c1", 0), ("misclassified", 0)]
    {
        let [a, b] = [pixels.get(column) * 0.5f64.powi(power), halves.get(column)];
        assert!((a / b - 1.0).abs() < 1e-9, "{column}: {a} {b}");
    }
}

#[test]
fn a_segmentation_goes_on_bit_by_bit() {
    let images = images();
    let set = ["image.rebuild=3"];
    let mut whole = images.case(&set);
    whole.steps(10);
    let bytes = whole.bytes();
    let mut resumed = images.case(&set);
    resumed.resume(&bytes);
    whole.steps(10);
    resumed.steps(10);
    assert_eq!(whole.bytes(), resumed.bytes());
}

/// The contour is measured as other level sets are; its scene reads back whatever stands in it.
#[test]
fn delta_functions_and_curvatures_measure_the_contour() {
    let images = images();
    let set =
        ["output.deltas=['smeared', 'smereka1', 'smereka2', 'towers']", "output.curvature=true"];
    let case = images.case(&[&set[..], &["time.end=800"]].concat()).run();
    let written = Scene::parse(&case.scene.to_toml(), Path::new("scene.toml")).unwrap();
    assert_eq!(written.to_toml(), case.scene.to_toml());
    for (measure, deltas) in [
        ("perimeter", &["smeared", "smereka1", "smereka2", "towers"][..]),
        ("area", &["smeared", "towers"]),
    ] {
        for delta in deltas {
            let [a, b] = [
                case.get(&format!("discs.{measure}_{delta}")),
                case.get(&format!("discs.{measure}")),
            ];
            assert!((a / b - 1.0).abs() < 0.02, "{measure}_{delta}: {a} {b}");
        }
    }
    // The mean curvature of closed curves is 2 pi over their length, one for each.
    let [least, most] = ["min", "max"].map(|end| case.get(&format!("discs.curvature_{end}")));
    let mean = case.get("discs.curvature_mean");
    let curves = mean * case.get("discs.perimeter") / std::f64::consts::TAU;
    assert!(
        least < mean && mean < most && (curves - case.get("components")).abs() < 0.02,
        "{least} {mean} {most}"
    );
}

#[test]
fn what_means_nothing_beside_an_image_is_refused() {
    let images = images();
    for (set, part) in [
        ("fluid.viscosity=1", "`fluid` means nothing beside `image`"),
        ("boundary.walls={ no_slip = true }", "`boundary` means nothing"),
        (
            "membrane=[{ shape.circle = { centre = [20, 20], radius = 5 }, area.linear = { modulus = 1 } }]",
            "`membrane` means",
        ),
        (
            "drop=[{ shape.circle = { centre = [20, 20], radius = 5 }, tension = 1 }]",
            "`drop` means nothing",
        ),
        ("exact.velocity=[0, 0]", "`exact` means"),
        ("level_set=[]", "one level set segments the image, and the scene has 0"),
        ("level_set.0.markers=10", "markers are carried by a flow"),
        ("mesh.box={ min = [0, 0, 0], max = [9, 9, 9], cells = [2, 2, 2] }", "an image is plane"),
        (
            "mesh.rectangle={ min = [0, 0], max = [49, 48], cells = [4, 4] }",
            "the mesh reaches beyond the image",
        ),
        ("time.tolerance=0.01", "`time.tolerance` means nothing"),
        ("numerics.transport=composed", "`numerics.transport` means nothing"),
        ("numerics.surface_tension=baensch2001", "`numerics.surface_tension` means nothing"),
        ("numerics.pressure='P1+P0'", "`numerics.pressure` means nothing"),
        (
            "numerics.redistance={ method = 'exact' }",
            "leave numerics.redistance out, or give image.rebuild",
        ),
        ("output.backward_map=true", "`output.backward_map` means nothing"),
        ("output.fluxes.f={ boundary = 'left' }", "`output.fluxes` means nothing"),
        ("output.probes.p={ at = [1, 1], of = 'speed' }", "nothing flows"),
        ("output.picture={ field = 'vorticity' }", "there is no `vorticity`"),
        ("output.curves.c={ of = ['discs', 'discs'] }", "of the plane meet in points"),
        ("output.picture={ field = 'speed' }", "ask for level_set"),
        ("image.file=other.png", "the image cannot be read"),
        ("image.file=scene.toml", "not a PNG file"),
        ("image.mask=scene.toml", "not a PNG file"),
        ("image.file=''", "the name of the image is empty"),
        ("image.length=-1", "positive or zero"),
        ("image.fidelity=0", "must be positive"),
        ("image.lenght=1", "did you mean `length`?"),
        (
            "level_set.0.shape={ circle = { centre = [24, 24], radius = 30 } }",
            "does not lie inside",
        ),
    ] {
        let shown = images.refused(&[set]);
        assert!(shown.contains(part), "{set}: {shown}");
    }
    let without = SCENE.replace(
        "[[level_set]]\nname = \"discs\"\nshape.circle = { centre = [24, 24], radius = 14 }\n",
        "",
    );
    let e = Scene::parse_with(&without, &images.folder.path().join("scene.toml"), &[]).unwrap_err();
    assert!(e.to_string().contains("no contour to start from"), "{e}");
    let small = GreyImage::new(8, vec![1.0; 64]).unwrap().png().unwrap();
    fs::write(images.folder.path().join("mask.png"), small).unwrap();
    assert!(images.refused(&[]).contains("the mask and the image differ in size"));
    let flow = "[mesh]\n\
        rectangle = { min = [0, 0], max = [1, 1], cells = [4, 4] }\n\
        [fluid]\nviscosity = 1\n[time]\nend = 1\nstep = 1\n\
        [output]\npicture = { field = \"image\" }\n";
    let e = Scene::parse_with(flow, Path::new("scene.toml"), &[]).unwrap_err();
    assert!(e.to_string().contains("no [image]"), "{e}");
}

#[test]
fn a_run_leaves_contours_and_images_and_is_drawn_again_without_them() {
    let images = images();
    let folder = images.folder.path();
    immersa(folder, &["run", "scene.toml", "--quiet", "--out", "run"]).expect(0, &[]);
    let run = folder.join("run");
    let series = Series::read(&run.join("series.csv")).unwrap();
    let last = |column: &str| *series.column(column).unwrap().last().unwrap();
    // The polygons enclose the area; rows grow downwards, so that what is counter-clockwise is so
    // in the scene.
    let contours = Series::read(&run.join("contours.csv")).unwrap();
    let column = |name: &str| contours.column(name).unwrap();
    let (id, x, y) = (column("contour"), column("column"), column("row"));
    let pairs = (1..contours.rows()).filter(|&k| id[k] == id[k - 1]);
    let area: f64 = pairs.map(|k| 0.5 * (x[k] * y[k - 1] - x[k - 1] * y[k])).sum();
    assert!((area / last("discs.area") - 1.0).abs() < 2e-3, "{area}");
    assert_eq!((id.last(), column("hole").contains(&1.0)), (Some(&1.0), false));
    // The mask of the run differs from the right one in as many pixels as the series says.
    let read = |path: &Path| GreyImage::read(path).unwrap();
    let (found, known) = (read(&run.join("mask.png")), read(&folder.join("mask.png")));
    let wrong = found.levels().iter().zip(known.levels()).filter(|(a, b)| a != b).count();
    assert_eq!(wrong as f64, last("misclassified"));
    let segmented = read(&run.join("segmented.png"));
    for (level, inside) in segmented.levels().iter().zip(found.levels()) {
        let exact = if *inside == 1.0 { last("c1") } else { last("c2") };
        assert!((level - exact).abs() < 0.5 / 255.0 + 1e-9, "{level} {exact}");
    }
    let page = fs::read_to_string(run.join("report.html")).unwrap();
    for text in [
        "Connected parts",
        "Pixels on the wrong side",
        "segmented.png",
        "the red line is the contour",
        "Mean grey levels",
    ] {
        assert!(page.contains(text), "{text} is missing");
    }
    assert!(
        !page.contains("Largest speed")
            && !page.contains("no fluid crosses")
            && !page.contains("Enclosed area")
    );
    // Without the image the run can still be drawn.
    fs::remove_file(folder.join("discs.png")).unwrap();
    immersa(folder, &["render", "run"]).expect(0, &[]);
    immersa(folder, &["explain", "run/scene.toml"])
        .expect(3, &["the image cannot be read", "discs.png"]);
}

#[test]
fn the_image_of_the_example_is_what_its_program_draws() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/active-contours");
    let drawn = shapes::draw(shapes::NOISE, shapes::SEED).unwrap();
    for (image, name) in drawn.iter().zip(["shapes.png", "shapes-mask.png"]) {
        let kept = GreyImage::read(&folder.join(name)).unwrap();
        let far = kept
            .levels()
            .iter()
            .zip(image.levels())
            .filter(|(a, b)| (*a - b.clamp(0.0, 1.0)).abs() > 0.51 / 255.0);
        assert_eq!(
            (kept.width(), kept.height(), far.count()),
            (shapes::SIZE, shapes::SIZE, 0),
            "{name}"
        );
    }
}
