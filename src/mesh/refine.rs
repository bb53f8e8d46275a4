//! Uniform refinement of triangles and tetrahedra, with new boundary points moved onto the
//! geometry.

use super::{Facet, Mesh, Point, determinant};
use crate::base::{Cause, Error, Result};
use nalgebra::SMatrix;
use std::collections::{BTreeSet, HashMap};

/// The mesh with every cell divided at the midpoints of its edges: a triangle into four similar
/// ones ("red" refinement; Bank, Sherman and Weiser 1983), a tetrahedron into four similar ones at
/// its corners and four about the shortest diagonal of the octahedron between them (Bey, Computing
/// 55, 1995; Zhang, Houston J. Math. 21, 1995). Cell `c` becomes the cells `2^D c` to
/// `2^D c + 2^D - 1`. Points keep their numbers; names of boundaries and regions are inherited.
///
/// The midpoint of an edge on the boundary is passed to `onto` with the names of its boundaries in
/// turn; the first position that `onto` returns replaces it, so that a polygon converges to the
/// curve that it approximates, a polyhedron to its surface.
///
/// # Errors
/// A cell inverted or flattened by a moved point.
pub fn refine<const D: usize>(
    mesh: &Mesh<D>,
    onto: impl Fn(&str, &Point<D>) -> Option<Point<D>>,
) -> Result<Mesh<D>> {
    let mut middles =
        Middles { points: mesh.points().to_vec(), by_ends: HashMap::new(), ends: Vec::new() };
    let mut cells = Vec::with_capacity(((D + 1) << D) * mesh.cell_count());
    for c in 0..mesh.cell_count() {
        match *mesh.cell(c) {
            [a, b, c] => {
                let (ab, bc, ca) = (middles.of(a, b), middles.of(b, c), middles.of(c, a));
                cells.extend([a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca]);
            }
            [a, b, c, d] => cells.extend(middles.eight(a, b, c, d).as_flattened()),
            _ => {}
        }
    }
    for (edge, names) in names_of_edges(mesh) {
        let Some(&middle) = middles.by_ends.get(&edge) else { continue };
        let point = &mut middles.points[middle as usize];
        if let Some(moved) = names.iter().find_map(|name| onto(name, point)) {
            *point = moved;
        }
    }
    refuse_turned(&middles.points, &cells)?;
    let Middles { points, ends: ends_of, .. } = middles;
    let old = mesh.points().len();
    let mut fine = Mesh::new(points, cells)?;
    let parent: Vec<Option<u32>> = fine
        .facets()
        .iter()
        .map(|f| {
            parent(mesh, &fine, f, |v| {
                if (v as usize) < old { [v; 2] } else { ends_of[v as usize - old] }
            })
        })
        .collect();
    inherit(mesh, &mut fine, &parent);
    Ok(fine)
}

/// Points in the middle of edges.
struct Middles<const D: usize> {
    /// The points of the mesh, then the midpoints.
    points: Vec<Point<D>>,
    by_ends: HashMap<[u32; 2], u32>,
    /// The ends of each edge, in the order of the middles.
    ends: Vec<[u32; 2]>,
}

impl<const D: usize> Middles<D> {
    fn of(&mut self, a: u32, b: u32) -> u32 {
        *self.by_ends.entry(ends(a, b)).or_insert_with(|| {
            self.points.push((self.points[a as usize] + self.points[b as usize]) * 0.5);
            self.ends.push(ends(a, b));
            (self.points.len() - 1) as u32
        })
    }

    /// The eight tetrahedra of `a b c d`, positively oriented.
    fn eight(&mut self, a: u32, b: u32, c: u32, d: u32) -> [[u32; 4]; 8] {
        let [ab, ac, ad, bc, bd, cd] =
            [(a, b), (a, c), (a, d), (b, c), (b, d), (c, d)].map(|(i, j)| self.of(i, j));
        let length =
            |i: u32, j: u32| (self.points[i as usize] - self.points[j as usize]).norm_squared();
        // The ends of a diagonal, and the four other points in turn about it.
        let diagonals =
            [(ab, cd, [ac, ad, bd, bc]), (ac, bd, [ad, ab, bc, cd]), (ad, bc, [ab, ac, cd, bd])];
        let (mut p, mut q, mut ring) = diagonals[0];
        for &(i, j, around) in &diagonals[1..] {
            // A diagonal shorter by rounding only is not taken: of equal ones the first.
            if length(i, j) < length(p, q) * (1.0 - 1e-12) {
                (p, q, ring) = (i, j, around);
            }
        }
        let about = |k: usize| [p, q, ring[k], ring[(k + 1) % 4]];
        let corners = [[a, ab, ac, ad], [ab, b, bc, bd], [ac, bc, c, cd], [ad, bd, cd, d]];
        [corners[0], corners[1], corners[2], corners[3], about(0), about(1), about(2), about(3)]
    }
}

/// The names of the boundaries that every edge on the boundary belongs to.
fn names_of_edges<const D: usize>(mesh: &Mesh<D>) -> HashMap<[u32; 2], BTreeSet<&str>> {
    let mut names: HashMap<[u32; 2], BTreeSet<&str>> = HashMap::new();
    for (name, facets) in mesh.boundaries() {
        for &f in facets {
            let corners: Vec<u32> = mesh.facet_points(&mesh.facets()[f as usize]).collect();
            for (i, &a) in corners.iter().enumerate() {
                for &b in &corners[..i] {
                    names.entry(ends(a, b)).or_default().insert(name);
                }
            }
        }
    }
    names
}

/// Rejects cells that moved points have inverted; [`Mesh::new`] would reorient them.
fn refuse_turned<const D: usize>(points: &[Point<D>], cells: &[u32]) -> Result<()> {
    let volume = |v: &[u32]| {
        let from_first =
            |i: usize, k: usize| points[v[k + 1] as usize][i] - points[v[0] as usize][i];
        determinant(&SMatrix::<f64, D, D>::from_fn(from_first))
    };
    let Some(cell) = cells.chunks_exact(D + 1).find(|v| volume(v) <= 0.0) else { return Ok(()) };
    let at: Vec<_> = cell.iter().map(|&v| points[v as usize].as_slice()).collect();
    let what = if D == 2 { "triangle" } else { "tetrahedron" };
    Err(Error::input(format!(
        "a {what} is turned over when the boundary of the refined mesh is moved onto its geometry"
    ))
    .at(format!("the {what} with vertices {at:?}"))
    .remedy("make the mesh finer where the boundary is curved, or correct its geometry")
    .because(Cause::CurvedBoundary))
}

/// The facet of the coarse mesh that contains `facet` of the fine one: the facet of its parent cell
/// with all its points, or with the ends of the edges whose midpoints they are.
fn parent<const D: usize>(
    mesh: &Mesh<D>,
    fine: &Mesh<D>,
    facet: &Facet,
    ends: impl Fn(u32) -> [u32; 2],
) -> Option<u32> {
    let cell = facet.cell >> D;
    let within = |opposite: u32| {
        let away = mesh.cell(cell as usize)[opposite as usize];
        fine.facet_points(facet).all(|v| !ends(v).contains(&away))
    };
    // Facets are in the order of their cells.
    let first = mesh.facets().partition_point(|f| f.cell < cell);
    let own = mesh.facets()[first..].iter().take_while(|f| f.cell == cell);
    own.zip(first as u32..).find(|(f, _)| within(f.opposite)).map(|(_, f)| f)
}

fn inherit<const D: usize>(mesh: &Mesh<D>, fine: &mut Mesh<D>, parent: &[Option<u32>]) {
    for (name, facets) in mesh.boundaries() {
        let mut of_name = vec![false; mesh.facets().len()];
        facets.iter().for_each(|&f| of_name[f as usize] = true);
        let inherits = |p: &Option<u32>| p.is_some_and(|p| of_name[p as usize]);
        fine.set_boundary(
            name,
            (0..).zip(parent).filter(|(_, p)| inherits(p)).map(|(f, _)| f).collect(),
        );
    }
    for (name, parts) in mesh.regions() {
        fine.set_region(name, parts.iter().flat_map(|&c| c << D..(c + 1) << D).collect());
    }
}

fn ends(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Diagonals, box_mesh, check, disc, rectangle};

    #[test]
    fn a_refined_rectangle_is_the_rectangle_of_twice_the_squares() {
        let mut coarse = rectangle([0.0, 0.0], [2.0, 1.0], [3, 2], Diagonals::Right).unwrap();
        coarse.set_region("first", vec![0, 3]);
        let fine = refine(&coarse, |_, _| None).unwrap();
        let direct = rectangle([0.0, 0.0], [2.0, 1.0], [6, 4], Diagonals::Right).unwrap();
        assert_eq!(
            (fine.cell_count(), fine.points().len()),
            (direct.cell_count(), direct.points().len())
        );
        assert!((fine.volume() - 2.0).abs() < 1e-14);
        for (name, facets) in direct.boundaries() {
            let length = |m: &Mesh<2>, f: &[u32]| -> f64 {
                f.iter().map(|&f| m.facet_normal(&m.facets()[f as usize]).1).sum()
            };
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
        let onto = |name: &str, x: &Point<2>| {
            (name == "wall").then(|| centre + (x - centre).normalize() * 2.0)
        };
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
        let far =
            |name: &str, x: &Point<2>| (name == "left").then(|| x + Point::<2>::new(0.6, 0.0));
        assert!(refine(&mesh, far).unwrap_err().to_string().contains("turned over"));
    }

    #[test]
    fn a_refined_box_is_the_box_of_twice_the_blocks() {
        let mut coarse = box_mesh([0.0; 3], [2.0, 2.0, 2.0], [2, 2, 2]).unwrap();
        coarse.set_region("first", vec![0, 7]);
        let fine = refine(&coarse, |_, _| None).unwrap();
        let direct = box_mesh([0.0; 3], [2.0, 2.0, 2.0], [4, 4, 4]).unwrap();
        let cells = |mesh: &Mesh<3>| -> BTreeSet<Vec<[i64; 3]>> {
            let point =
                |v: &u32| mesh.points()[*v as usize].map(|x| (x * 1e6).round() as i64).into();
            let cell = |c: usize| {
                let mut points: Vec<[i64; 3]> = mesh.cell(c).iter().map(point).collect();
                points.sort_unstable();
                points
            };
            (0..mesh.cell_count()).map(cell).collect()
        };
        // The shortest diagonal is the one of Kuhn's triangulation.
        assert_eq!(cells(&fine), cells(&direct));
        assert!(fine.reoriented().is_empty());
        for (name, facets) in direct.boundaries() {
            let area = |m: &Mesh<3>, f: &[u32]| {
                f.iter().map(|&f| m.facet_normal(&m.facets()[f as usize]).1).sum::<f64>()
            };
            let inherited = fine.boundary(name).unwrap();
            assert_eq!(inherited.len(), facets.len(), "{name}");
            assert!((area(&fine, inherited) - area(&direct, facets)).abs() < 1e-13, "{name}");
            for &f in inherited.iter().filter(|_| name != "walls") {
                let facet = &fine.facets()[f as usize];
                assert_eq!(
                    fine.facet_normal(facet).0.iamax(),
                    ["left right", "bottom top", "back front"]
                        .iter()
                        .position(|n| n.contains(name.as_str()))
                        .unwrap()
                );
            }
        }
        assert_eq!(fine.regions()["first"].len(), 16);
    }

    #[test]
    fn a_polyhedron_tends_to_the_ball() {
        // An octahedron about its centre: every cell has one facet on the sphere.
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Point::<3>::from);
        let points = [vec![Point::<3>::zeros()], axes.to_vec(), axes.map(|x| -x).to_vec()].concat();
        let cell = |k: u32| [0, 1 + (k & 1) * 3, 2 + (k >> 1 & 1) * 3, 3 + (k >> 2) * 3];
        let mut mesh = Mesh::<3>::new(points, (0..8).flat_map(cell).collect()).unwrap();
        mesh.set_boundary("sphere", (0..8).collect());
        let mut before = f64::INFINITY;
        for _ in 0..4 {
            mesh = refine(&mesh, |name, x| (name == "sphere").then(|| x.normalize())).unwrap();
            let error = 4.0 / 3.0 * std::f64::consts::PI - mesh.volume();
            assert!(error > 0.0 && error < 0.45 * before, "{error} after {before}");
            before = error;
        }
        let quality = check(&mesh).0;
        assert!(before < 0.05 && mesh.cell_count() == 8 << 12, "{before}");
        assert!(
            quality.smallest_angle.value > 10.0 && quality.parts == 1,
            "{}",
            quality.smallest_angle.value
        );
    }
}
