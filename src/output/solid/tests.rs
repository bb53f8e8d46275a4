//! Tests of whole pictures.

use super::*;
use crate::fem::Element;
use crate::mesh::box_mesh;
use crate::output::FieldData;
use std::f64::consts::PI;
use std::sync::Arc;

fn cube(n: usize) -> Space<3> {
    Space::new(&Arc::new(box_mesh([-1.0; 3], [1.0; 3], [n; 3]).unwrap()), Element::P2)
}

/// An ellipsoid around the origin, by longitude and latitude.
fn ellipsoid(half: [f64; 3], n: usize, paint: impl Fn(&[Point<3>]) -> Paint) -> Surface {
    let columns = 2 * n;
    let mut points = Vec::new();
    for i in 0..=n {
        for j in 0..columns {
            let (a, b) = (PI * j as f64 / n as f64, PI * (i as f64 / n as f64 - 0.5));
            points.push(Point::<3>::new(
                half[0] * b.cos() * a.cos(),
                half[1] * b.cos() * a.sin(),
                half[2] * b.sin(),
            ));
        }
    }
    let normals =
        points.iter().map(|x| Point::<3>::from_fn(|k, _| x[k] / (half[k] * half[k]))).collect();
    let mut triangles = Vec::new();
    for i in 0..n {
        for j in 0..columns {
            let at = |i: usize, j: usize| (i * columns + j % columns) as u32;
            triangles.push([at(i, j), at(i, j + 1), at(i + 1, j)]);
            triangles.push([at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)]);
        }
    }
    let paint = paint(&points);
    Surface { points, normals, triangles, paint }
}

fn sphere(radius: f64, paint: Paint) -> Surface {
    ellipsoid([radius; 3], 48, move |_| paint.clone())
}

/// Column and row of the pixel that a point is in.
fn at(picture: &SolidPicture, x: [f64; 3]) -> [usize; 2] {
    let (camera, _) = picture.place(picture.shown().unwrap()).unwrap();
    camera.project(&Point::<3>::from(x)).at.map(|v| v as usize)
}

fn close(a: [u8; 3], b: [u8; 3], by: u8) -> bool {
    a.iter().zip(b).all(|(a, b)| a.abs_diff(b) <= by)
}

#[test]
fn a_surface_hides_what_is_behind_it_and_is_hidden_by_what_is_before() {
    let space = cube(2);
    let front = View { azimuth: -90.0, elevation: 0.0, projection: Projection::Orthographic };
    let base = SolidPicture { view: front, ..SolidPicture::new(&space, "") };
    let [red, green] = [Paint::Plain([220, 0, 0]), Paint::Plain([0, 220, 0])];
    let (small, large) = (sphere(0.3, red), sphere(0.6, green));
    let moved = |y: f64| {
        let mut small = small.clone();
        small.points.iter_mut().for_each(|p| p[1] += y);
        small
    };
    let middle = |surfaces| {
        let picture = SolidPicture { surfaces, ..base.clone() };
        let (image, [x, y]) = (picture.draw().unwrap(), at(&picture, [0.05, 0.0, 0.05]));
        image.pixel(x, y)
    };
    let is_red = |p: [u8; 3]| p[0] > 100 && p[1] < 100;
    assert!(is_red(middle(vec![large.clone(), moved(-0.7)])), "the small one before the large one");
    assert!(is_red(middle(vec![moved(-0.7), large.clone()])), "the order does not matter");
    assert!(!is_red(middle(vec![large.clone(), moved(0.7)])), "the small one behind it");
    assert!(!is_red(middle(vec![moved(0.0), large])), "the small one inside");
}

#[test]
fn a_slice_has_the_colours_of_its_field_and_the_line_of_the_interface() {
    let space = cube(3);
    let f = space.interpolate(|x| x[0] + 3.0 * x[1] * x[2] + 5.0);
    let phi = space.interpolate(|x| x.norm_squared() - 0.25);
    for (axis, position) in [(0, 0.1), (1, 0.0), (2, -0.4)] {
        let picture = SolidPicture {
            slices: vec![Slice { axis, position, field: FieldData::Scalar(&f) }],
            interfaces: vec![&phi],
            scale: Scale::new(1.0, 9.0),
            ..SolidPicture::new(&space, "")
        };
        let (image, colours) = (picture.draw().unwrap(), Colours::new(picture.scale, None));
        for (a, b) in [(0.8, 0.7), (-0.75, 0.6), (0.05, 0.0)] {
            let mut x = Point::<3>::zeros();
            (x[axis], x[(axis + 1) % 3], x[(axis + 2) % 3]) = (position, a, b);
            let [column, row] = at(&picture, x.into());
            let (seen, expected) =
                (image.pixel(column, row), colours.of(x[0] + 3.0 * x[1] * x[2] + 5.0));
            assert!(close(seen, expected, 12), "axis {axis} at {x}: {seen:?} {expected:?}");
        }
        let radius = (0.25f64 - position * position).sqrt();
        for k in 0..16 {
            let mut x = Point::<3>::zeros();
            let (s, c) = (PI * (f64::from(k) + 0.3) / 8.0).sin_cos();
            (x[axis], x[(axis + 1) % 3], x[(axis + 2) % 3]) = (position, radius * c, radius * s);
            let [column, row] = at(&picture, x.into());
            assert!(
                image.pixel(column, row).iter().all(|v| *v < 90),
                "axis {axis}: {:?}",
                image.pixel(column, row)
            );
        }
    }
}

#[test]
fn the_sheared_checkerboard_has_the_parity_of_the_material_at_each_pixel() {
    // (5.20) of the paper: each height of the sphere turned back by pi z.
    let y = |x: &Point<3>| {
        let (s, c) = (PI * x[2]).sin_cos();
        Point::<3>::new(x[0] * c + x[1] * s, -x[0] * s + x[1] * c, x[2])
    };
    let space = cube(2);
    let globe = Pattern::Globe { centre: Point::<3>::zeros(), around: 8, along: 6 };
    for pattern in [globe, Pattern::Cubes { origin: Point::<3>::zeros(), edge: 0.25 }] {
        let paint =
            |p: &[Point<3>]| Paint::Checkerboard { material: p.iter().map(y).collect(), pattern };
        let surface = ellipsoid([0.7; 3], 96, paint);
        let picture = SolidPicture { surfaces: vec![surface], ..SolidPicture::new(&space, "") };
        let (image, mut counts) = (picture.draw().unwrap(), [0; 2]);
        for (i, j) in (0..20).flat_map(|i| (0..20).map(move |j| (i, j))) {
            let (a, b) =
                (-PI / 3.0 + 1.2 * (f64::from(i) / 10.0 - 1.0), 0.9 * (f64::from(j) / 10.0 - 0.9));
            let on = |a: f64, b: f64| {
                Point::<3>::new(b.cos() * a.cos(), b.cos() * a.sin(), b.sin()) * 0.7
            };
            let odd = pattern.is_odd(&y(&on(a, b)));
            let seen =
                picture.place(picture.shown().unwrap()).unwrap().0.to_eye(&on(a, b)).dot(&on(a, b))
                    > 0.1;
            // Pixels at the lines of the pattern are mixed.
            let around = [(0.02, 0.0), (-0.02, 0.0), (0.0, 0.02), (0.0, -0.02)];
            if seen && around.iter().all(|(da, db)| pattern.is_odd(&y(&on(a + da, b + db))) == odd)
            {
                let [column, row] = at(&picture, on(a, b).into());
                let [red, _, blue] = image.pixel(column, row);
                assert_eq!(blue > red, odd, "{pattern:?} at {a} {b}");
                counts[usize::from(odd)] += 1;
            }
        }
        assert!(counts.iter().all(|c| *c > 40), "{counts:?}");
    }
}

#[test]
fn a_scalar_keeps_its_colour_under_the_light() {
    let space = cube(2);
    let paint = |p: &[Point<3>]| Paint::Scalar(p.iter().map(|x| x[0]).collect());
    let picture = SolidPicture {
        surfaces: vec![ellipsoid([0.9, 0.5, 0.5], 48, paint)],
        scale: Scale::new(-0.9, 0.9),
        ..SolidPicture::new(&space, "")
    };
    let image = picture.draw().unwrap();
    let pixel = |x| image.pixel(at(&picture, x)[0], at(&picture, x)[1]);
    let hue = |rgb: [u8; 3]| i32::from(rgb[0]) - i32::from(rgb[2]);
    assert!(hue(pixel([-0.6, -0.35, 0.1])) < -40 && hue(pixel([0.6, -0.35, 0.1])) > 40);
}

#[test]
fn the_picture_does_not_depend_on_the_number_of_threads() {
    let space = cube(3);
    let u = space.interpolate(|x| Point::<3>::new(-x[1], x[0], 0.2 * x[2]));
    let phi = space.interpolate(|x| x.norm() - 0.6);
    let draw = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let surface =
                Surface::of_level_set(&space, &phi, Coat::Field(FieldData::Vector(&u))).unwrap();
            let slices = vec![Slice { axis: 1, position: 0.2, field: FieldData::Vector(&u) }];
            let scale = Scale::of(FieldData::Vector(&u));
            let base = SolidPicture::new(&space, "Speed");
            SolidPicture { surfaces: vec![surface], slices, interfaces: vec![&phi], scale, ..base }
                .draw()
                .unwrap()
        })
    };
    assert_eq!(draw(1), draw(2));
}

#[test]
fn every_view_and_shape_of_box_gives_a_picture_within_its_size() {
    for high in [[50.0, 0.5, 1.0], [0.01, 4.0, 4.0], [1e-9, 1e-9, 1e-9]] {
        let space = Space::new(&Arc::new(box_mesh([0.0; 3], high, [2; 3]).unwrap()), Element::P2);
        let f = space.interpolate(|x| x[0] / high[0]);
        for (azimuth, elevation) in
            [(0.0, 0.0), (-90.0, 0.0), (45.0, 90.0), (200.0, -35.0), (-60.0, 24.0)]
        {
            for projection in [Projection::Orthographic, Projection::Perspective] {
                let picture = SolidPicture {
                    slices: vec![Slice { axis: 0, position: 0.0, field: FieldData::Scalar(&f) }],
                    time: Some(1.0 / 3.0),
                    view: View { azimuth, elevation, projection },
                    size: [420, 380],
                    ..SolidPicture::new(
                        &space,
                        "a title that is much longer than a narrow picture is wide",
                    )
                };
                let image = picture.draw().unwrap();
                assert!(
                    image.width() <= 420 && image.height() <= 380,
                    "{} x {}",
                    image.width(),
                    image.height()
                );
                assert!(image.width().is_multiple_of(2) && image.height().is_multiple_of(2));
            }
        }
    }
}

#[test]
fn what_cannot_be_drawn_is_refused() {
    let space = cube(1);
    let base = SolidPicture::new(&space, "");
    let view = View { azimuth: f64::NAN, ..View::default() };
    let refused = |p: &SolidPicture, what: &str| {
        let e = p.draw().unwrap_err();
        assert!(e.what().contains(what), "{e}");
    };
    refused(&SolidPicture { view, ..base.clone() }, "view");
    let window = Some([Point::<3>::repeat(0.5), Point::<3>::zeros()]);
    refused(&SolidPicture { window, ..base.clone() }, "volume");
    let mut surface = sphere(0.5, Paint::PLAIN);
    surface.normals.pop();
    refused(&SolidPicture { surfaces: vec![surface], ..base }, "fit together");
}
