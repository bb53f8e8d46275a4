//! Mesh files for FreeFEM, readable without a plugin: triangles in its own `.msh` (not gmsh's) by
//! `readmesh`, tetrahedra in Medit's `.mesh` by `readmesh3`.

use super::{Facet, Mesh};
use crate::base::{Error, Result};
use std::fmt::Write;

/// Sides of a rectangle and a box in the order of their labels in FreeFEM's `square` and `cube`,
/// from 1.
const SIDES: [&str; 6] = ["bottom", "right", "top", "left", "back", "front"];

/// Labels of the boundaries in [`text`]: `bottom`, `right`, `top`, `left`, in space also `back` and
/// `front`, are 1 to 4 or 6 as in FreeFEM's `square` and `cube`; the others follow in alphabetical
/// order. A facet of several boundaries has the label of the smallest of them, so that `walls`, the
/// union of all, has none; a facet of none has 0.
pub fn labels<const D: usize>(mesh: &Mesh<D>) -> Vec<(String, u32)> {
    let (owners, sides) = (owners(mesh), &SIDES[..2 * D]);
    let mut used: Vec<&str> = owners.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let others = used.iter().filter(|name| !sides.contains(name));
    let sides = sides.iter().zip(1..).filter(|(name, _)| used.contains(name));
    sides
        .map(|(name, k)| (name.to_string(), k))
        .chain(others.map(ToString::to_string).zip(2 * D as u32 + 1..))
        .collect()
}

/// The mesh in FreeFEM's format. Triangles: a line with the numbers of vertices, triangles and
/// boundary edges, then `x y label` per vertex, three vertices (from 1) and a region per triangle,
/// two vertices and a label per edge. Tetrahedra: the parts `Vertices`, `Tetrahedra` and
/// `Triangles` of a Medit file, each with its number of such lines. Coordinates are lossless.
///
/// # Errors
/// Of kind `Input`: a facet without a named boundary, on which no condition could be set.
pub fn text<const D: usize>(mesh: &Mesh<D>) -> Result<String> {
    let (labels, owners) = (labels(mesh), owners(mesh));
    let label = |name: &str| labels.iter().find(|l| l.0 == name).map_or(0, |l| l.1);
    let mut of_point = vec![0; mesh.points().len()];
    let mut facets = String::new();
    for (facet, owner) in mesh.facets().iter().zip(&owners) {
        let Some(owner) = owner else { return Err(nameless(mesh, facet)) };
        for v in seen_from_outside(mesh, facet) {
            of_point[v as usize] = label(owner);
            // Writing to a string cannot fail, here and below.
            let _ = write!(facets, "{} ", v + 1);
        }
        let _ = writeln!(facets, "{}", label(owner));
    }
    let mut vertices = String::new();
    for (p, label) in mesh.points().iter().zip(of_point) {
        for x in p.iter() {
            let _ = write!(vertices, "{x:?} ");
        }
        let _ = writeln!(vertices, "{label}");
    }
    let mut cells = String::new();
    for c in 0..mesh.cell_count() {
        for v in mesh.cell(c) {
            let _ = write!(cells, "{} ", v + 1);
        }
        cells.push_str("0\n");
    }
    let [points, count, sides] = [mesh.points().len(), mesh.cell_count(), mesh.facets().len()];
    Ok(if D == 2 {
        format!("{points} {count} {sides}\n{vertices}{cells}{facets}")
    } else {
        format!(
            "MeshVersionFormatted 2\nDimension 3\nVertices\n{points}\n{vertices}\
             Tetrahedra\n{count}\n{cells}Triangles\n{sides}\n{facets}End\n"
        )
    })
}

/// The corners of a facet, counter-clockwise from the outside of its cell, as FreeFEM's own meshes
/// have them.
fn seen_from_outside<const D: usize>(mesh: &Mesh<D>, facet: &Facet) -> impl Iterator<Item = u32> {
    let order: &[usize] = match (D, facet.opposite) {
        (2, 0) => &[1, 2],
        (2, 1) => &[2, 0],
        (2, _) => &[0, 1],
        (_, 0) => &[1, 2, 3],
        (_, 1) => &[0, 3, 2],
        (_, 2) => &[0, 1, 3],
        _ => &[0, 2, 1],
    };
    order.iter().map(|&k| mesh.cell(facet.cell as usize)[k])
}

fn nameless<const D: usize>(mesh: &Mesh<D>, facet: &Facet) -> Error {
    let at: Vec<_> =
        mesh.facet_points(facet).map(|v| mesh.points()[v as usize].as_slice().to_vec()).collect();
    let (what, part) = if D == 2 { ("an edge", "Curve") } else { ("a triangle", "Surface") };
    Error::input(format!("{what} of the boundary belongs to no named boundary"))
        .at(format!("the one with the corners {at:?}"))
        .remedy(format!("name all of the boundary in the mesh (gmsh: Physical {part})"))
}

/// The smallest boundary of every facet, the first in alphabetical order among equals.
fn owners<const D: usize>(mesh: &Mesh<D>) -> Vec<Option<&str>> {
    let mut owners: Vec<Option<(usize, &str)>> = vec![None; mesh.facets().len()];
    for (name, facets) in mesh.boundaries() {
        for &f in facets {
            let owner = &mut owners[f as usize];
            if owner.is_none_or(|(size, _)| facets.len() < size) {
                *owner = Some((facets.len(), name));
            }
        }
    }
    owners.into_iter().map(|o| o.map(|(_, name)| name)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Diagonals, Point, box_mesh, disc, rectangle};

    /// Output of `savemesh` of FreeFem++ 4.11 for `square(3, 2, [2*x, y], flags=1)`, with sorted
    /// edges.
    const SAVED: &str = "12 12 10
0 0 4|0.666666666667 0 1|1.33333333333 0 1|2 0 2|0 0.5 4|0.666666666667 0.5 0|1.33333333333 0.5 0|2 0.5 2|0 1 4|0.666666666667 1 3|1.33333333333 1 3|2 1 3
1 2 5|5 2 6|2 3 7|2 7 6|3 4 7|7 4 8|5 6 10|5 10 9|6 7 10|10 7 11|7 8 12|7 12 11
1 2 1|2 3 1|3 4 1|4 8 2|5 1 4|8 12 2|9 5 4|10 9 3|11 10 3|12 11 3";

    #[test]
    fn a_rectangle_is_that_of_freefem() {
        let mesh = rectangle([0.0; 2], [2.0, 1.0], [3, 2], Diagonals::UnionJack).unwrap();
        let ours = text(&mesh).unwrap();
        let lines: Vec<&str> = ours.lines().collect();
        let theirs: Vec<Vec<&str>> = SAVED.lines().map(|l| l.split('|').collect()).collect();
        assert_eq!(lines[0], theirs[0][0]);
        let numbers =
            |line: &str| line.split(' ').map(|w| w.parse::<f64>().unwrap()).collect::<Vec<_>>();
        for (ours, theirs) in lines[1..13].iter().zip(&theirs[1]) {
            // Where two sides meet, the label of the vertex may be that of either.
            let (a, b) = (numbers(ours), numbers(theirs));
            assert!(
                (a[0] - b[0]).abs() < 1e-11
                    && (a[1] - b[1]).abs() < 1e-11
                    && (a[2] > 0.0) == (b[2] > 0.0)
            );
        }
        let triangle = |line: &str| {
            let v: Vec<usize> = line.split(' ').take(3).map(|w| w.parse().unwrap()).collect();
            let first = (0..3).min_by_key(|&k| v[k]).unwrap();
            [v[first], v[(first + 1) % 3], v[(first + 2) % 3]]
        };
        for (ours, theirs) in lines[13..25].iter().zip(&theirs[2]) {
            assert_eq!(triangle(ours), triangle(theirs));
        }
        let mut edges = lines[25..].to_vec();
        edges.sort_by_key(|e| numbers(e)[0] as usize);
        assert_eq!(edges, theirs[3]);
    }

    #[test]
    fn labels_are_stable_and_a_nameless_boundary_is_refused() {
        let mut mesh = disc([0.0; 2], 1.0, 2).unwrap();
        assert_eq!(labels(&mesh), [("wall".to_string(), 5)]);
        mesh.set_boundary("inlet", vec![0, 1]);
        assert_eq!(labels(&mesh), [("inlet".to_string(), 5), ("wall".to_string(), 6)]);
        let text_of = text(&mesh).unwrap();
        assert_eq!(text_of.lines().rev().take(12).filter(|l| l.ends_with(" 5")).count(), 2);
        let mesh = Mesh::<2>::new(
            [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(Into::into).to_vec(),
            vec![0, 1, 2],
        )
        .unwrap();
        assert!(text(&mesh).unwrap_err().advice().contains("Physical Curve"));
    }

    #[test]
    fn tetrahedra_are_written_for_readmesh3() {
        let mesh = box_mesh([0.0; 3], [1.0, 2.0, 3.0], [1, 2, 3]).unwrap();
        let text_of = text(&mesh).unwrap();
        let lines: Vec<&str> = text_of.lines().collect();
        let part = |name: &str| {
            let at = lines.iter().position(|l| *l == name).unwrap();
            let count: usize = lines[at + 1].parse().unwrap();
            let numbers =
                |l: &&str| l.split(' ').map(|w| w.parse::<f64>().unwrap()).collect::<Vec<_>>();
            lines[at + 2..at + 2 + count].iter().map(numbers).collect::<Vec<_>>()
        };
        let (vertices, tetrahedra, triangles) =
            (part("Vertices"), part("Tetrahedra"), part("Triangles"));
        assert_eq!((vertices.len(), tetrahedra.len(), triangles.len()), (24, 36, 44));
        assert!(lines.len() == 3 + 6 + 24 + 36 + 44 && lines[lines.len() - 1] == "End");
        let point = |v: f64| Point::<3>::from_column_slice(&vertices[v as usize - 1][..3]);
        for t in &tetrahedra {
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| point(t[k]));
            assert!((b - a).cross(&(c - a)).dot(&(d - a)) > 0.0);
        }
        // The labels of FreeFEM's cube, and normals that point out of the box.
        for t in &triangles {
            let [a, b, c] = [0, 1, 2].map(|k| point(t[k]));
            let n = (b - a).cross(&(c - a)).normalize();
            let (axis, sign) =
                [(1, -1.0), (0, 1.0), (1, 1.0), (0, -1.0), (2, -1.0), (2, 1.0)][t[3] as usize - 1];
            assert!((n[axis] - sign).abs() < 1e-12, "{t:?}: {n:?}");
        }
    }
}
