//! Mesh generators: rectangles, boxes and discs.

use super::{Mesh, Point};
use crate::base::{Error, Result};

/// Diagonals of the squares of a rectangle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Diagonals {
    /// All from lower left to upper right: FreeFEM's `square(n, m, flags = 0)`.
    #[default]
    Right,
    /// All from lower right to upper left: `flags = 2`.
    Left,
    /// Square `(i, j)` to the left if `i + j` is even, else to the right: `flags = 1`. The mesh is
    /// symmetric about both middle lines if the numbers of squares are even.
    UnionJack,
}

/// A rectangle cut into `cells[0] x cells[1]` squares, each halved by a diagonal. Points and cells
/// are numbered as FreeFEM does.
///
/// Boundary names: `left`, `right`, `bottom`, `top`, and `walls` for all of them.
///
/// # Errors
/// A direction without cells, or corners that are not finite or not in order.
pub fn rectangle(
    min: [f64; 2],
    max: [f64; 2],
    cells: [usize; 2],
    diagonals: Diagonals,
) -> Result<Mesh<2>> {
    check_box(&min, &max, &cells)?;
    let [nx, ny] = cells;
    let coordinate =
        |i: usize, n: usize, a: usize| min[a] + (max[a] - min[a]) * i as f64 / n as f64;
    let mut points = Vec::with_capacity((nx + 1) * (ny + 1));
    for j in 0..=ny {
        for i in 0..=nx {
            points.push(Point::<2>::new(coordinate(i, nx, 0), coordinate(j, ny, 1)));
        }
    }
    let id = |i: usize, j: usize| (i + j * (nx + 1)) as u32;
    let mut tri = Vec::with_capacity(6 * nx * ny);
    for j in 0..ny {
        for i in 0..nx {
            let [a, b, c, d] = [id(i, j), id(i + 1, j), id(i, j + 1), id(i + 1, j + 1)];
            let left = match diagonals {
                Diagonals::Right => false,
                Diagonals::Left => true,
                Diagonals::UnionJack => (i + j) % 2 == 0,
            };
            tri.extend(if left { [a, b, c, c, b, d] } else { [a, b, d, a, d, c] });
        }
    }
    let mut mesh = Mesh::new(points, tri)?;
    name_box_sides(&mut mesh);
    Ok(mesh)
}

/// A box cut into `cells[0] x cells[1] x cells[2]` blocks of six tetrahedra each (Kuhn's
/// triangulation: all six share the diagonal from the lowest to the highest corner, so that
/// neighbouring blocks fit).
///
/// Boundary names: `left`, `right` (x), `bottom`, `top` (y), `back`, `front` (z), and `walls` for
/// all of them.
///
/// # Errors
/// A direction without cells, or corners that are not finite or not in order.
pub fn box_mesh(min: [f64; 3], max: [f64; 3], cells: [usize; 3]) -> Result<Mesh<3>> {
    check_box(&min, &max, &cells)?;
    let [nx, ny, nz] = cells;
    let coordinate = |i: usize, a: usize| min[a] + (max[a] - min[a]) * i as f64 / cells[a] as f64;
    let mut points = Vec::with_capacity((nx + 1) * (ny + 1) * (nz + 1));
    for k in 0..=nz {
        for j in 0..=ny {
            points
                .extend((0..=nx).map(|i| {
                    Point::<3>::new(coordinate(i, 0), coordinate(j, 1), coordinate(k, 2))
                }));
        }
    }
    let step = [1, nx + 1, (nx + 1) * (ny + 1)];
    let mut tetrahedra = Vec::with_capacity(24 * nx * ny * nz);
    for (k, j, i) in
        (0..nz).flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| (k, j, i))))
    {
        let corner = i * step[0] + j * step[1] + k * step[2];
        // Each order of the axes is a path along edges to the opposite corner; even orders are
        // positively oriented.
        for [a, b, c] in [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]] {
            let path = [0, step[a], step[a] + step[b], step[a] + step[b] + step[c]]
                .map(|s| (corner + s) as u32);
            let even = (b + 3 - a) % 3 == 1;
            tetrahedra.extend(if even { path } else { [path[0], path[2], path[1], path[3]] });
        }
    }
    let mut mesh = Mesh::new(points, tetrahedra)?;
    name_box_sides(&mut mesh);
    Ok(mesh)
}

/// A disc of `rings` concentric rings of triangles: a point in the middle and `6 k` on circle `k`,
/// so that all triangles have about the same size and angles between 42 and 97 degrees. The outer
/// points lie on the circle.
///
/// Boundary names: `wall`, and `walls` (the same).
///
/// # Errors
/// No rings, or a centre or radius that is not finite or not positive.
pub fn disc(centre: [f64; 2], radius: f64, rings: usize) -> Result<Mesh<2>> {
    if rings == 0
        || rings > MOST_ALONG_A_SIDE
        || !(radius > 0.0 && radius.is_finite() && centre.iter().all(|c| c.is_finite()))
    {
        return Err(Error::scene(
            "a disc needs a centre, a positive radius and at least one ring of cells",
        )
        .value(format!("centre = {centre:?}, radius = {radius}, rings = {rings}")));
    }
    let mut points = vec![Point::<2>::from(centre)];
    for k in 1..=rings {
        let r = radius * k as f64 / rings as f64;
        points.extend((0..6 * k).map(|i| {
            let (sin, cos) = (std::f64::consts::TAU * i as f64 / (6 * k) as f64).sin_cos();
            Point::<2>::new(centre[0] + r * cos, centre[1] + r * sin)
        }));
    }
    // Point i of circle k; circle 0 is the centre.
    let id =
        |k: usize, i: usize| if k == 0 { 0 } else { (1 + 3 * k * (k - 1) + i % (6 * k)) as u32 };
    let mut triangles = Vec::with_capacity(18 * rings * rings);
    for k in 1..=rings {
        for sector in 0..6 {
            let (outer, inner) = (sector * k, sector * (k - 1));
            for i in 0..k {
                triangles.extend([id(k - 1, inner + i), id(k, outer + i), id(k, outer + i + 1)]);
                if i + 1 < k {
                    triangles.extend([
                        id(k - 1, inner + i),
                        id(k, outer + i + 1),
                        id(k - 1, inner + i + 1),
                    ]);
                }
            }
        }
    }
    let mut mesh = Mesh::new(points, triangles)?;
    for name in ["wall", "walls"] {
        mesh.set_boundary(name, (0..mesh.facets().len() as u32).collect());
    }
    Ok(mesh)
}

/// Larger numbers of points would not fit into 32 bits.
const MOST_ALONG_A_SIDE: usize = 20_000;

fn check_box<const D: usize>(min: &[f64; D], max: &[f64; D], cells: &[usize; D]) -> Result<()> {
    let ordered = (0..D).all(|i| max[i] > min[i] && (max[i] - min[i]).is_finite());
    // Every block has up to six cells of four points.
    let fits = cells
        .iter()
        .try_fold(24usize, |n, &c| n.checked_mul(c))
        .is_some_and(|n| n < u32::MAX as usize);
    if ordered && fits && !cells.contains(&0) {
        return Ok(());
    }
    Err(Error::scene("the sizes of the mesh do not fit")
        .at(if D == 2 { "rectangle" } else { "box" })
        .value(format!("min = {min:?}, max = {max:?}, cells = {cells:?}"))
        .remedy(
            "give finite corners with max > min, and at least one cell in each direction but less \
             than 170 million in all",
        ))
}

/// Names the facets of an axis-aligned box `left`, `right`, `bottom`, `top` (3-D also `back`,
/// `front`) by their normals, and all of them `walls`.
pub(crate) fn name_box_sides<const D: usize>(mesh: &mut Mesh<D>) {
    let names = ["left", "right", "bottom", "top", "back", "front"];
    let mut parts = vec![Vec::new(); 2 * D];
    for (i, f) in mesh.facets().iter().enumerate() {
        let (n, _) = mesh.facet_normal(f);
        let axis = n.iamax();
        parts[2 * axis + usize::from(n[axis] > 0.0)].push(i as u32);
    }
    let all = (0..mesh.facets().len() as u32).collect();
    for (name, part) in names.iter().zip(parts) {
        mesh.set_boundary(*name, part);
    }
    mesh.set_boundary("walls", all);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rectangle_has_the_right_area_sides_and_neighbours() {
        let m = rectangle([0.0, 0.0], [2.0, 1.0], [4, 3], Diagonals::Right).unwrap();
        assert!((m.volume() - 2.0).abs() < 1e-14);
        assert_eq!(m.cell_count(), 24);
        assert_eq!(m.boundary("walls").unwrap().len(), 14);
        let right = m.boundary("right").unwrap();
        let length: f64 = right.iter().map(|&f| m.facet_normal(&m.facets()[f as usize]).1).sum();
        assert!((length - 1.0).abs() < 1e-14);
        assert!(m.boundary("inlet").unwrap_err().to_string().contains("bottom"));
    }

    #[test]
    fn diagonals_are_those_of_freefem() {
        // FreeFem++ 4.11: square(2, 2, flags = 0, 1, 2), its numbers less one.
        let rising = [0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4, 3, 4, 7, 3, 7, 6, 4, 5, 8, 4, 8, 7];
        let jack = [0, 1, 3, 3, 1, 4, 1, 2, 5, 1, 5, 4, 3, 4, 7, 3, 7, 6, 4, 5, 7, 7, 5, 8];
        let falling = [0, 1, 3, 3, 1, 4, 1, 2, 4, 4, 2, 5, 3, 4, 6, 6, 4, 7, 4, 5, 7, 7, 5, 8];
        for (d, expected) in
            [(Diagonals::Right, rising), (Diagonals::UnionJack, jack), (Diagonals::Left, falling)]
        {
            let m = rectangle([0.0; 2], [1.0; 2], [2, 2], d).unwrap();
            assert_eq!(
                (0..8).flat_map(|c| m.cell(c).to_vec()).collect::<Vec<_>>(),
                expected,
                "{d:?}"
            );
        }
    }

    #[test]
    fn a_disc_fills_its_polygon_with_well_shaped_triangles() {
        for rings in [1, 2, 7, 40] {
            let m = disc([1.0, -2.0], 3.0, rings).unwrap();
            assert_eq!(
                (m.cell_count(), m.facets().len(), m.reoriented().len()),
                (6 * rings * rings, 6 * rings, 0)
            );
            let n = (6 * rings) as f64;
            let polygon = 0.5 * n * 9.0 * (std::f64::consts::TAU / n).sin();
            assert!((m.volume() - polygon).abs() < 1e-12 * polygon);
            for f in m.facets() {
                assert!(m.facet_points(f).all(|v| {
                    ((m.points()[v as usize] - Point::<2>::new(1.0, -2.0)).norm() - 3.0).abs()
                        < 1e-14
                }));
            }
            for c in 0..m.cell_count() {
                let p = |k: usize| m.points()[m.cell(c)[k % 3] as usize];
                for k in 0..3 {
                    let angle = (p(k + 1) - p(k)).angle(&(p(k + 2) - p(k))).to_degrees();
                    assert!((42.0..97.0).contains(&angle), "{rings} rings, cell {c}: {angle}");
                }
            }
        }
    }

    #[test]
    fn sizes_that_make_no_mesh_are_refused() {
        assert!(rectangle([0.0; 2], [1.0; 2], [0, 3], Diagonals::Left).is_err());
        assert!(rectangle([0.0; 2], [1.0, f64::NAN], [3, 3], Diagonals::Left).is_err());
        assert!(rectangle([0.0; 2], [1.0; 2], [usize::MAX, usize::MAX], Diagonals::Left).is_err());
        assert!(box_mesh([0.0; 3], [1.0, 1.0, f64::INFINITY], [1; 3]).is_err());
        assert!(disc([0.0; 2], -1.0, 3).is_err());
        assert!(disc([0.0; 2], 1.0, usize::MAX).is_err());
    }

    #[test]
    fn a_box_has_the_right_volume_sides_and_orientation() {
        let m = box_mesh([0.0; 3], [2.0, 1.0, 3.0], [4, 3, 5]).unwrap();
        assert!((m.volume() - 6.0).abs() < 1e-13);
        assert_eq!((m.cell_count(), m.reoriented().len()), (360, 0));
        assert_eq!(m.boundary("walls").unwrap().len(), 2 * 2 * (4 * 3 + 3 * 5 + 5 * 4));
        for (name, area) in [("left", 3.0), ("top", 6.0), ("front", 2.0)] {
            let part = m.boundary(name).unwrap();
            let sum: f64 = part.iter().map(|&f| m.facet_normal(&m.facets()[f as usize]).1).sum();
            assert!((sum - area).abs() < 1e-13, "{name}: {sum}");
        }
    }
}
