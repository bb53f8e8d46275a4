use super::*;
use crate::fem::Element;
use crate::mesh::{Diagonals, Mesh, Point, rectangle};
use std::sync::Arc;

fn square() -> Space<2> {
    Space::new(
        &Arc::new(rectangle([0.0, 0.0], [2.0, 2.0], [10, 10], Diagonals::Right).unwrap()),
        Element::P2,
    )
}

/// Column and row of the pixel that a point of the domain is in.
fn at(picture: &Picture, x: [f64; 2]) -> (usize, usize) {
    let [a, b] = PlotArea::of(picture).pixel(&SVector::<f64, 2>::from(x));
    (a as usize, b as usize)
}

fn close(a: [u8; 3], b: [u8; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| a.abs_diff(b) <= 4)
}

#[test]
fn a_linear_field_has_the_colour_of_its_value_at_every_pixel() {
    let space = square();
    let f = space.interpolate(|x| x[0] + 10.0 * x[1]);
    let picture = Picture::new(&space, FieldData::Scalar(&f), "f");
    let image = picture.draw().unwrap();
    let viridis = |v: f64| {
        let c = colorous::VIRIDIS.eval_continuous(v / 22.0);
        [c.r, c.g, c.b]
    };
    for x in [[0.1, 0.1], [1.9, 0.1], [1.0, 1.0], [0.3, 1.7], [1.95, 1.95]] {
        let (a, b) = at(&picture, x);
        assert!(
            close(image.pixel(a, b), viridis(x[0] + 10.0 * x[1])),
            "{x:?}: {:?}",
            image.pixel(a, b)
        );
    }
    let vectors = space.interpolate(|x| SVector::<f64, 2>::new(0.0, -(x[0] + 10.0 * x[1])));
    let of_vectors = Picture::new(&space, FieldData::Vector(&vectors), "f").draw().unwrap();
    assert_eq!(of_vectors, image, "a vector field is shown by its length");
    let at_points: Vec<f64> = space.mesh().points().iter().map(|x| x[0] + 10.0 * x[1]).collect();
    assert_eq!(
        Picture::new(&space, FieldData::Scalar(&at_points), "f").draw().unwrap(),
        image,
        "a P1 field on a P2 space"
    );
    assert!(Picture::new(&space, FieldData::Scalar(&f[1..]), "f").draw().is_err());
}

#[test]
fn the_contour_of_a_circle_is_on_the_circle_and_nowhere_else() {
    let space = square();
    let (flat, radius) = (vec![0.0; space.len()], 0.6);
    // Quadratic, so that the zero line is a circle to rounding; its slope is not 1.
    let phi = space.interpolate(|x| (x[0] - 1.0).powi(2) + (x[1] - 1.0).powi(2) - radius * radius);
    let picture =
        Picture { interfaces: vec![&phi], ..Picture::new(&space, FieldData::Scalar(&flat), "") };
    let (image, area) = (picture.draw().unwrap(), PlotArea::of(&picture));
    let ground = Picture { interfaces: Vec::new(), ..picture.clone() }.draw().unwrap();
    let (mut ink, centre) = (0.0, area.pixel(&SVector::<f64, 2>::new(1.0, 1.0)));
    for y in 0..image.height() {
        for x in 0..image.width() {
            let d = ((x as f64 + 0.5 - centre[0]).hypot(y as f64 + 0.5 - centre[1])
                - radius * area.scale)
                .abs();
            if d < 0.5 {
                assert!(
                    close(image.pixel(x, y), LINE.rgb),
                    "({x}, {y}) at {d} is {:?}",
                    image.pixel(x, y)
                );
            } else if d > 3.2 {
                assert_eq!(image.pixel(x, y), ground.pixel(x, y), "({x}, {y}) at {d}");
            }
            ink += f64::from(u8::from(
                image.pixel(x, y)[1] < 100 && ground.pixel(x, y) != image.pixel(x, y),
            ));
        }
    }
    let length = std::f64::consts::TAU * radius * area.scale;
    assert!((ink / length - 2.2).abs() < 1.2, "width {}", ink / length);
}

#[test]
fn holes_are_white_and_values_that_are_no_numbers_grey() {
    let full = rectangle([0.0, 0.0], [3.0, 3.0], [3, 3], Diagonals::Right).unwrap();
    let keep = |c: &usize| !(8..10).contains(c);
    let cells = (0..full.cell_count()).filter(keep).flat_map(|c| full.cell(c).to_vec()).collect();
    let space =
        Space::new(&Arc::new(Mesh::new(full.points().to_vec(), cells).unwrap()), Element::P1);
    let mut f = space.interpolate(|x: &Point<2>| x[0]);
    f[0] = f64::NAN;
    let picture = Picture::new(&space, FieldData::Scalar(&f), "with a hole");
    let image = picture.draw().unwrap();
    let pixel = |x| image.pixel(at(&picture, x).0, at(&picture, x).1);
    assert_eq!(pixel([1.5, 1.5]), [255; 3]);
    assert_eq!(pixel([0.3, 0.2]), [128; 3]);
    assert_ne!(pixel([2.5, 2.5]), [255; 3]);
}

#[test]
fn every_shape_of_domain_and_option_gives_a_picture_within_its_size() {
    for (high, cells) in [([50.0, 0.5], [20, 2]), ([0.01, 4.0], [1, 9]), ([1e-9, 1e-9], [3, 3])] {
        let space = Space::new(
            &Arc::new(rectangle([0.0, 0.0], high, cells, Diagonals::Right).unwrap()),
            Element::P2,
        );
        let u = space.interpolate(|x| x / high[0]);
        let phi = space.interpolate(|x| x[0] - 0.5 * high[0]);
        let picture = Picture {
            time: Some(1.0 / 3.0),
            interfaces: vec![&phi],
            arrows: Some(Arrows { velocity: &u, fastest: 1.0 }),
            mesh: true,
            ..Picture::new(
                &space,
                FieldData::Vector(&u),
                "a title that is much longer than a narrow picture is wide",
            )
        };
        let image = picture.draw().unwrap();
        assert!(
            image.width() <= 760 && image.height() <= 680,
            "{} x {}",
            image.width(),
            image.height()
        );
        assert!(image.width().is_multiple_of(2) && image.height().is_multiple_of(2));
    }
}
