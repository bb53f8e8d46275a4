//! Tests of whole pictures.

use super::*;
use crate::fem::Element;
use crate::mesh::box_mesh;
use crate::output::FieldData;
use nalgebra::SVector;
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
            points.push(Point::<3>::new(half[0] * b.cos() * a.cos(), half[1] * b.cos() * a.sin(), half[2] * b.sin()));
        }
    }
    let normals = points.iter().map(|x| Point::<3>::from_fn(|k, _| x[k] / (half[k] * half[k]))).collect();
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

#[test]
fn gallery() {
    let dir = std::path::PathBuf::from(std::env::var("GALLERY").unwrap());
    let space = cube(12);
    let save = |name: &str, p: &SolidPicture| {
        let start = std::time::Instant::now();
        let image = p.draw().unwrap();
        eprintln!("{name}: {} x {} in {:?}", image.width(), image.height(), start.elapsed());
        std::fs::write(dir.join(format!("{name}.png")), image.png().unwrap()).unwrap();
    };
    let base = SolidPicture::new(&space, "A sphere");
    save("sphere", &SolidPicture { surfaces: vec![sphere(0.5, Paint::PLAIN)], time: Some(0.0), ..base.clone() });
    let stretch = |p: &[Point<3>]| Paint::Scalar(p.iter().map(|x| 1.0 + 0.4 * x[0] * x[0] + 0.2 * x[2]).collect());
    let surface = ellipsoid([0.9, 0.5, 0.4], 64, stretch);
    let Paint::Scalar(f) = &surface.paint else { unreachable!() };
    let scale = Scale::of::<3>(FieldData::Scalar(f));
    save(
        "ellipsoid",
        &SolidPicture {
            surfaces: vec![surface.clone()],
            scale,
            time: Some(0.25),
            title: "Stretch |grad φ|",
            ..base.clone()
        },
    );
    // Ripples.
    let mut ripples = surface.clone();
    for (x, n) in ripples.points.iter_mut().zip(&mut ripples.normals) {
        let k = 40.0;
        let bump = 0.006 * (k * x[0]).sin();
        let m = n.normalize();
        *n = m - Point::<3>::x() * (0.006 * k * (k * x[0]).cos());
        *x += m * bump;
    }
    save(
        "ripples",
        &SolidPicture { surfaces: vec![ripples], scale, time: Some(0.25), title: "Ripples", ..base.clone() },
    );
    let y = |x: &Point<3>| {
        let (s, c) = (PI * x[2]).sin_cos();
        Point::<3>::new(x[0] * c + x[1] * s, -x[0] * s + x[1] * c, x[2])
    };
    for (name, pattern) in [
        ("globe", Pattern::Globe { centre: Point::<3>::zeros(), around: 16, along: 8 }),
        ("cubes", Pattern::Cubes { origin: Point::<3>::zeros(), edge: 0.125 }),
    ] {
        let material = |p: &[Point<3>]| Paint::Checkerboard { material: p.iter().map(y).collect(), pattern };
        save(
            name,
            &SolidPicture {
                surfaces: vec![ellipsoid([0.5; 3], 96, material)],
                title: "The sheared sphere",
                time: Some(0.0),
                ..base.clone()
            },
        );
    }
    let vortex = |x: &Point<3>| {
        let r = (x[0] * x[0] + x[1] * x[1] + 0.3 * x[2] * x[2]) / 0.16;
        SVector::<f64, 3>::new(-x[1], x[0], 0.0) * (-r).exp()
    };
    let u = space.interpolate(vortex);
    let phi = space.interpolate(|x| (x[0] / 0.8).powi(2) + (x[1] / 0.5).powi(2) + (x[2] / 0.4).powi(2) - 1.0);
    let slice = |axis, position| Slice { axis, position, field: FieldData::Vector(&u) };
    let slices = SolidPicture {
        slices: vec![slice(2, 0.0)],
        interfaces: vec![&phi],
        scale: Scale::of(FieldData::Vector(&u)),
        time: Some(1.5),
        title: "Speed",
        ..base.clone()
    };
    save("slice", &slices);
    save(
        "slices",
        &SolidPicture {
            slices: vec![slice(2, -1.0), slice(0, -1.0), slice(1, 1.0)],
            surfaces: vec![surface.clone()],
            ..slices.clone()
        },
    );
    save("three", &SolidPicture { slices: vec![slice(2, 0.0), slice(0, 0.0), slice(1, 0.0)], ..slices.clone() });
    let p = space.interpolate(|x| x[0] * (x[1] + 1.2) * (1.0 - x[2] * x[2]));
    save(
        "signed",
        &SolidPicture {
            slices: vec![Slice { axis: 1, position: 0.0, field: FieldData::Scalar(&p) }],
            surfaces: vec![ellipsoid([0.8, 0.5, 0.4], 64, |_| Paint::PLAIN)],
            scale: Scale::of::<3>(FieldData::Scalar(&p)),
            view: View { azimuth: -75.0, elevation: 15.0, projection: Projection::Orthographic },
            title: "Pressure",
            ..slices.clone()
        },
    );
}
