//! Uniform refinement of triangles, with new boundary points moved onto the geometry.

use super::{Mesh, Point};
use crate::base::{Error, Result};
use std::collections::HashMap;

/// The mesh with every triangle cut into four by the middles of its sides ("red" refinement; Bank, Sherman and Weiser 1983):
/// cell `c` becomes the cells `4 c` to `4 c + 3`, all similar to it. Points keep their numbers, names of boundaries and regions
/// are inherited.
///
/// The middle of a boundary facet is handed to `onto` with the names of its boundaries in turn; the first place that `onto`
/// gives is taken instead of it, so that a polygon tends to the curve it stands for.
///
/// # Errors
/// A triangle that is turned over or flattened by a point that was moved.
pub fn refine(mesh: &Mesh<2>, onto: impl Fn(&str, &Point<2>) -> Option<Point<2>>) -> Result<Mesh<2>> {
    let mut points = mesh.points().to_vec();
    let old = points.len();
    // By its ends, the point in the middle of an edge.
    let mut middles: HashMap<[u32; 2], u32> = HashMap::new();
    let mut cells = Vec::with_capacity(12 * mesh.cell_count());
    for c in 0..mesh.cell_count() {
        let mut middle = |a: u32, b: u32| {
            *middles.entry(ends(a, b)).or_insert_with(|| {
                points.push((points[a as usize] + points[b as usize]) * 0.5);
                (points.len() - 1) as u32
            })
        };
        let &[a, b, c] = mesh.cell(c) else { continue };
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        cells.extend([a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca]);
    }
    // By the point in its middle, the facet.
    let mut parents = HashMap::new();
    for (f, facet) in (0..).zip(mesh.facets()) {
        let mut corners = mesh.facet_points(facet);
        if let (Some(a), Some(b)) = (corners.next(), corners.next()) {
            parents.insert(middles[&ends(a, b)], f);
        }
    }
    let mut names = vec![Vec::new(); mesh.facets().len()];
    for (name, facets) in mesh.boundaries() {
        facets.iter().for_each(|&f| names[f as usize].push(name.as_str()));
    }
    for (&middle, &f) in &parents {
        let point = &mut points[middle as usize];
        if let Some(moved) = names[f as usize].iter().find_map(|name| onto(name, point)) {
            *point = moved;
        }
    }
    // Before the mesh is made, which would turn them round.
    let area = |v: &[Point<2>; 3]| (v[1] - v[0]).perp(&(v[2] - v[0]));
    let corners = |cell: &[u32]| [0, 1, 2].map(|k| points[cell[k] as usize]);
    if let Some(at) = cells.chunks_exact(3).map(corners).find(|v| area(v) <= 0.0) {
        return Err(Error::input(
            "a triangle is turned over when the boundary of the refined mesh is moved onto its curve",
        )
        .at(format!("the triangle with vertices {:?}", at.map(|p| [p[0], p[1]])))
        .remedy("make the mesh finer where the boundary is curved, or correct mesh.geometry"));
    }
    let mut fine = Mesh::new(points, cells)?;
    let parent: Vec<Option<u32>> = fine
        .facets()
        .iter()
        .map(|f| fine.facet_points(f).find(|&v| v as usize >= old).and_then(|v| parents.get(&v).copied()))
        .collect();
    for (name, facets) in mesh.boundaries() {
        let mut of_name = vec![false; mesh.facets().len()];
        facets.iter().for_each(|&f| of_name[f as usize] = true);
        let inherits = |p: &Option<u32>| p.is_some_and(|p| of_name[p as usize]);
        fine.set_boundary(name, (0..).zip(&parent).filter(|(_, p)| inherits(p)).map(|(f, _)| f).collect());
    }
    for (name, parts) in mesh.regions() {
        fine.set_region(name, parts.iter().flat_map(|&c| 4 * c..4 * c + 4).collect());
    }
    Ok(fine)
}

fn ends(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Diagonals, check, disc, rectangle};

    #[test]
    fn a_refined_rectangle_is_the_rectangle_of_twice_the_squares() {
        let mut coarse = rectangle([0.0, 0.0], [2.0, 1.0], [3, 2], Diagonals::Right).unwrap();
        coarse.set_region("first", vec![0, 3]);
        let fine = refine(&coarse, |_, _| None).unwrap();
        let direct = rectangle([0.0, 0.0], [2.0, 1.0], [6, 4], Diagonals::Right).unwrap();
        assert_eq!((fine.cell_count(), fine.points().len()), (direct.cell_count(), direct.points().len()));
        assert!((fine.volume() - 2.0).abs() < 1e-14);
        for (name, facets) in direct.boundaries() {
            let length =
                |m: &Mesh<2>, f: &[u32]| -> f64 { f.iter().map(|&f| m.facet_normal(&m.facets()[f as usize]).1).sum() };
            let inherited = fine.boundary(name).unwrap();
            assert_eq!(inherited.len(), facets.len(), "{name}");
            assert!((length(&fine, inherited) - length(&direct, facets)).abs() < 1e-14, "{name}");
        }
        let area: f64 = fine.regions()["first"].iter().map(|&c| fine.map(c as usize).volume).sum();
        assert!((area - 2.0 * coarse.map(0).volume).abs() < 1e-14);
        assert_eq!(check(&fine).0.parts, 1);
    }

    #[test]
    fn a_disc_tends_to_the_circle() {
        let mut mesh = disc([0.5, -0.5], 2.0, 2).unwrap();
        let centre = Point::<2>::new(0.5, -0.5);
        let onto = |name: &str, x: &Point<2>| (name == "wall").then(|| centre + (x - centre).normalize() * 2.0);
        let mut before = f64::INFINITY;
        for _ in 0..3 {
            mesh = refine(&mesh, onto).unwrap();
            let error = 4.0 * std::f64::consts::PI - mesh.volume();
            // The polygon converges with order two.
            assert!(error > 0.0 && error < 0.27 * before, "{error} after {before}");
            before = error;
        }
        assert!(check(&mesh).0.smallest_angle.value > 35.0);
    }

    #[test]
    fn a_boundary_that_is_moved_through_its_triangle_is_refused() {
        let mesh = rectangle([0.0; 2], [1.0; 2], [2, 2], Diagonals::Right).unwrap();
        let far = |name: &str, x: &Point<2>| (name == "left").then(|| x + Point::<2>::new(0.6, 0.0));
        assert!(refine(&mesh, far).unwrap_err().to_string().contains("turned over"));
    }
}
