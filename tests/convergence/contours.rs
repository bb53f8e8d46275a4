//! Where active contours fail: too much noise, a length that weighs too much or too little, a start
//! that misses objects. The page of `examples/active-contours` tells the numbers.

use immersa::base::{Error, Kind};
use immersa::output::write_file;
use immersa::scene::{Problem, Scene, Segmented};
use std::path::Path;
use tempfile::TempDir;

#[path = "../../examples/shapes.rs"]
mod shapes;

/// Connected parts, relative error of the area and pixels on the wrong side when the example ends,
/// its image under noise of this deviation.
fn ended(noise: f64, set: &[&str]) -> Result<[f64; 3], Error> {
    let folder = TempDir::new().unwrap();
    for (image, name) in
        shapes::draw(noise, shapes::SEED)?.iter().zip(["shapes.png", "shapes-mask.png"])
    {
        write_file(&folder.path().join(name), &image.png()?)?;
    }
    let text = include_str!("../../examples/active-contours/scene.toml");
    let set: Vec<String> = set.iter().map(ToString::to_string).collect();
    let scene = Scene::parse_with(text, &Path::new(folder.path()).join("scene.toml"), &set)?;
    let mut model = Segmented::<2>::new(&scene)?;
    for _ in 0..scene.time.steps() {
        model.step()?;
    }
    let row = model.row()?;
    let found = ["components", "area_error", "misclassified"].map(|c| row.get(c).unwrap());
    println!("noise {noise} {set:?}: {found:?}");
    Ok(found)
}

#[test]
fn noise_up_to_the_difference_of_the_levels_is_borne_and_more_is_not() {
    let [parts, area, wrong] = ended(0.3, &["time.step=400", "time.end=72000"]).unwrap();
    assert!(parts == 4.0 && area.abs() < 0.02 && wrong < 320.0);
    // Twice the difference of the levels, clipped to black and white: the circle stays one piece.
    let [parts, _, wrong] = ended(0.5, &["time.step=800", "time.end=72000"]).unwrap();
    assert!(parts == 1.0 && wrong > 2000.0);
}

#[test]
fn a_length_without_weight_keeps_the_noise_and_one_too_heavy_loses_everything() {
    let [parts, ..] = ended(shapes::NOISE, &["image.length=0"]).unwrap();
    assert!(parts > 100.0);
    let error =
        ended(shapes::NOISE, &["image.length=1", "time.step=1600", "time.end=240000"]).unwrap_err();
    assert!(
        error.kind() == Kind::Computation && error.to_string().contains("the contour is gone"),
        "{error}"
    );
}

#[test]
fn objects_that_the_contour_does_not_come_by_are_not_found() {
    // Inside the ellipse.
    let [parts, area, _] =
        ended(shapes::NOISE, &["level_set.0.shape={ circle = { centre = [90, 94], radius = 8 } }"])
            .unwrap();
    assert!(parts == 1.0 && (area + 0.77).abs() < 0.01);
    // On a spot, which is too small to hold it.
    let start = "level_set.0.shape={ circle = { centre = [64, 64], radius = 8 } }";
    assert!(
        ended(shapes::NOISE, &[start]).unwrap_err().to_string().contains("the contour is gone")
    );
}
