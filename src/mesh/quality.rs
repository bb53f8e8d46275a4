//! Quality of a mesh: shape of cells, unused points, unnamed parts.
//!
//! Invalid meshes (degenerate or overlapping cells, coordinates that are not finite) are rejected
//! by [`Mesh::new`].

use super::{Mesh, NONE, Point};
use crate::base::Warning;
use std::collections::HashMap;

/// Angle in degrees below which cells are reported: the condition number of the matrices grows with
/// its inverse.
const SMALL_ANGLE: f64 = 5.0;

/// The worst cell by some measure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extreme<const D: usize> {
    /// The value.
    pub value: f64,
    /// Number of the cell, counted from 0.
    pub cell: u32,
    /// Its centre.
    pub centre: Point<D>,
}

/// Measures of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Quality<const D: usize> {
    /// Smallest angle between two sides of a cell (in 3-D the dihedral angle), in degrees.
    pub smallest_angle: Extreme<D>,
    /// Smallest `D` x radius of the inscribed / radius of the circumscribed sphere: 1 for an
    /// equilateral cell.
    pub smallest_radius_ratio: Extreme<D>,
    /// Smallest longest edge of a cell.
    pub smallest_diameter: Extreme<D>,
    /// Greatest longest edge of a cell.
    pub greatest_diameter: Extreme<D>,
    /// Number of parts that are connected through facets.
    pub parts: usize,
}

/// Measures a mesh and reports defects.
pub fn check<const D: usize>(mesh: &Mesh<D>) -> (Quality<D>, Vec<Warning>) {
    let (parts, smallest_part) = connected_parts(mesh);
    let least = |value: &dyn Fn(usize) -> f64| extreme(mesh, value);
    let negative = least(&|c| -mesh.diameter(c));
    let quality = Quality {
        smallest_angle: least(&|c| smallest_angle(mesh, c)),
        smallest_radius_ratio: least(&|c| radius_ratio(mesh, c)),
        smallest_diameter: least(&|c| mesh.diameter(c)),
        greatest_diameter: Extreme { value: -negative.value, ..negative },
        parts,
    };
    let found = [
        small_angles(mesh, &quality.smallest_angle),
        reoriented(mesh),
        unused_points(mesh),
        slit(mesh),
        unnamed_facets(mesh),
        (parts > 1).then(|| {
            let place = place(mesh, smallest_part);
            Warning::new(
                format!(
                    "the mesh has {parts} parts that are not connected; {place} belongs to the \
                     smallest"
                ),
                "if they should be one, make the surfaces share their boundary (gmsh: \
                 BooleanFragments or Coherence)",
            )
        }),
    ];
    (quality, found.into_iter().flatten().collect())
}

fn extreme<const D: usize>(mesh: &Mesh<D>, value: &dyn Fn(usize) -> f64) -> Extreme<D> {
    let mut least = (f64::INFINITY, 0);
    for c in 0..mesh.cell_count() {
        let v = value(c);
        if v < least.0 {
            least = (v, c);
        }
    }
    Extreme { value: least.0, cell: least.1 as u32, centre: centre(mesh, least.1) }
}

fn centre<const D: usize>(mesh: &Mesh<D>, c: usize) -> Point<D> {
    mesh.cell(c).iter().fold(Point::<D>::zeros(), |s, &v| s + mesh.points()[v as usize])
        / (D + 1) as f64
}

fn place<const D: usize>(mesh: &Mesh<D>, c: usize) -> String {
    format!("cell {c} (counted from 0, centre {:?})", centre(mesh, c).as_slice())
}

/// Smallest angle of cell `c`; the gradients of the barycentric coordinates are normal to the
/// sides.
fn smallest_angle<const D: usize>(mesh: &Mesh<D>, c: usize) -> f64 {
    let map = mesh.map(c);
    let mut greatest = -1.0f64;
    for i in 0..=D {
        for j in 0..i {
            let (a, b) = (map.gradient(i), map.gradient(j));
            greatest = greatest.max(-a.dot(&b) / (a.norm() * b.norm()));
        }
    }
    greatest.clamp(-1.0, 1.0).acos().to_degrees()
}

/// Ratio of inscribed to circumscribed radius, times `D`. With g_k = grad lambda_k, 1/|g_k| is a
/// height, so the inscribed radius is 1 / sum |g_k|. The circumcentre x relative to vertex 0
/// satisfies e_k . x = |e_k|^2 / 2 for the edges e_k, which are dual to the gradients.
fn radius_ratio<const D: usize>(mesh: &Mesh<D>, c: usize) -> f64 {
    let (map, cell) = (mesh.map(c), mesh.cell(c));
    let point = |k: usize| mesh.points()[cell[k] as usize];
    let inverse_radius: f64 = (0..=D).map(|k| map.gradient(k).norm()).sum();
    let circumcentre = (1..=D).fold(Point::<D>::zeros(), |x, k| {
        x + map.gradient(k) * (0.5 * (point(k) - point(0)).norm_squared())
    });
    D as f64 / (inverse_radius * circumcentre.norm())
}

/// Number of parts connected through facets, and a cell of the smallest.
fn connected_parts<const D: usize>(mesh: &Mesh<D>) -> (usize, usize) {
    let mut seen = vec![false; mesh.cell_count()];
    let mut parts = 0;
    let mut smallest = (usize::MAX, 0);
    for start in 0..mesh.cell_count() {
        if seen[start] {
            continue;
        }
        parts += 1;
        seen[start] = true;
        let mut todo = vec![start];
        let mut size = 0;
        while let Some(c) = todo.pop() {
            size += 1;
            for &n in mesh.neighbours(c) {
                if n != NONE && !seen[n as usize] {
                    seen[n as usize] = true;
                    todo.push(n as usize);
                }
            }
        }
        smallest = smallest.min((size, start));
    }
    (parts, smallest.1)
}

fn small_angles<const D: usize>(mesh: &Mesh<D>, worst: &Extreme<D>) -> Option<Warning> {
    if worst.value >= SMALL_ANGLE {
        return None;
    }
    let count = (0..mesh.cell_count()).filter(|&c| smallest_angle(mesh, c) < SMALL_ANGLE).count();
    Some(Warning::new(
        format!(
            "{count} cell(s) have an angle below {SMALL_ANGLE} degrees; the smallest is {:.3} in \
             {}",
            worst.value,
            place(mesh, worst.cell as usize)
        ),
        "such cells spoil accuracy and condition: let sizes change slowly, or optimise the mesh \
         (3-D: gmsh -optimize_threshold 0.5)",
    ))
}

fn reoriented<const D: usize>(mesh: &Mesh<D>) -> Option<Warning> {
    let cells = mesh.reoriented();
    let first = *cells.first()? as usize;
    Some(Warning::new(
        format!(
            "{} cell(s) were inverted and have been turned round; the first is {}",
            cells.len(),
            place(mesh, first)
        ),
        "no harm is done; if only some are inverted, check the program that wrote the mesh",
    ))
}

fn unused_points<const D: usize>(mesh: &Mesh<D>) -> Option<Warning> {
    let mut unused = vec![true; mesh.points().len()];
    for &v in (0..mesh.cell_count()).flat_map(|c| mesh.cell(c)) {
        unused[v as usize] = false;
    }
    let first = unused.iter().position(|&u| u)?;
    let count = unused.iter().filter(|&&u| u).count();
    Some(Warning::new(
        format!(
            "{count} point(s) belong to no cell; the first is point {first} (counted from 0) at \
             {:?}",
            mesh.points()[first].as_slice()
        ),
        "remove them: no equation determines a value there",
    ))
}

/// A warning if points stand at the place of others: the mesh has a slit there.
pub fn slit<const D: usize>(mesh: &Mesh<D>) -> Option<Warning> {
    let mut first_at = HashMap::with_capacity(mesh.points().len());
    let mut pairs = Vec::new();
    for (i, p) in mesh.points().iter().enumerate() {
        // Adding 0 makes 0 of -0, which has other bits.
        let bits: [u64; D] = std::array::from_fn(|k| (p[k] + 0.0).to_bits());
        let first = *first_at.entry(bits).or_insert(i);
        if first != i {
            pairs.push((first, i));
        }
    }
    let &(a, b) = pairs.first()?;
    Some(Warning::new(
        format!(
            "{} point(s) stand at the place of another; the first pair is {a} and {b} (counted \
             from 0) at {:?}",
            pairs.len(),
            mesh.points()[a].as_slice()
        ),
        "the mesh has a slit there unless that is meant: merge the points (gmsh: Coherence Mesh)",
    ))
}

fn unnamed_facets<const D: usize>(mesh: &Mesh<D>) -> Option<Warning> {
    let mut named = vec![false; mesh.facets().len()];
    for &f in mesh.boundaries().values().flatten() {
        if let Some(n) = named.get_mut(f as usize) {
            *n = true;
        }
    }
    let facet = mesh.facets()[named.iter().position(|n| !n)?];
    let count = named.iter().filter(|n| !**n).count();
    let corners: Vec<_> =
        mesh.facet_points(&facet).map(|v| mesh.points()[v as usize].as_slice().to_vec()).collect();
    Some(Warning::new(
        format!(
            "{count} of {} sides on the boundary have no name; the first has the corners \
             {corners:?} and belongs to {}",
            named.len(),
            place(mesh, facet.cell as usize)
        ),
        "a condition can be given there only through a name: add a Physical Curve (2-D) or \
         Physical Surface (3-D)",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Diagonals, box_mesh, rectangle};

    fn triangles(points: &[[f64; 2]], cells: &[u32]) -> Mesh<2> {
        Mesh::new(points.iter().map(|&p| p.into()).collect(), cells.to_vec()).unwrap()
    }

    /// The warning that contains `words`, all of them.
    fn has(warnings: &[Warning], words: &[&str]) -> bool {
        warnings.iter().any(|w| words.iter().all(|s| w.what.contains(s)) && !w.remedy.is_empty())
    }

    #[test]
    fn known_shapes_have_their_known_measures() {
        let h = 0.75f64.sqrt();
        let (q, _) = check(&triangles(&[[0.0, 0.0], [1.0, 0.0], [0.5, h]], &[0, 1, 2]));
        assert!((q.smallest_angle.value - 60.0).abs() < 1e-12);
        assert!((q.smallest_radius_ratio.value - 1.0).abs() < 1e-14);
        // Right isosceles triangle: r = (2 - sqrt 2)/2, R = 1/sqrt 2.
        let (q, w) = check(&rectangle([0.0; 2], [3.0, 3.0], [3, 3], Diagonals::Right).unwrap());
        assert!((q.smallest_angle.value - 45.0).abs() < 1e-12);
        assert!((q.smallest_radius_ratio.value - (2.0 - 2f64.sqrt()) * 2f64.sqrt()).abs() < 1e-14);
        assert!(
            (q.greatest_diameter.value - 2f64.sqrt()).abs() < 1e-14 && q.parts == 1 && w.is_empty()
        );
        // Regular tetrahedron: dihedral angle acos(1/3).
        let regular = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
        let (q, _) =
            check(&Mesh::<3>::new(regular.map(|p| p.into()).to_vec(), vec![0, 1, 2, 3]).unwrap());
        assert!((q.smallest_angle.value - (1.0f64 / 3.0).acos().to_degrees()).abs() < 1e-12);
        assert!((q.smallest_radius_ratio.value - 1.0).abs() < 1e-14);
        // Kuhn's tetrahedra have dihedral angles of 45, 60 and 90 degrees.
        let (q, w) = check(&box_mesh([0.0; 3], [1.0; 3], [2, 2, 2]).unwrap());
        assert!((q.smallest_angle.value - 45.0).abs() < 1e-12 && w.is_empty());
    }

    #[test]
    fn every_defect_is_reported_with_its_place() {
        // A flat cell, an inverted one, a second part, an unused point and one that stands twice;
        // no names.
        let points = [
            [0.0, 0.0],
            [1.0, 0.0],
            [1.0, 1.0],
            [0.5, -0.01],
            [7.0, 7.0],
            [5.0, 0.0],
            [6.0, 0.0],
            [5.0, 1.0],
            [1.0, 1.0],
        ];
        let (q, w) = check(&triangles(&points, &[0, 1, 2, 3, 0, 1, 5, 6, 7]));
        assert!(q.smallest_angle.cell == 1 && q.parts == 2 && w.len() == 6, "{w:?}");
        assert!(has(&w, &["1 cell(s) have", "cell 1", "1.14", "0.5, -0.003"]), "{w:?}");
        assert!(has(&w, &["2 point(s) belong to no cell", "point 4", "[7.0, 7.0]"]), "{w:?}");
        assert!(has(&w, &["pair is 2 and 8", "[1.0, 1.0]"]), "{w:?}");
        assert!(has(&w, &["2 parts", "cell 2"]), "{w:?}");
        assert!(has(&w, &["7 of 7 sides", "no name"]), "{w:?}");
        let (_, w) = check(&triangles(&points[..3], &[0, 2, 1]));
        assert!(has(&w, &["1 cell(s) were inverted", "cell 0"]), "{w:?}");
    }
}
