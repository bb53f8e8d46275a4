//! The wake of a body.

use crate::base::Result;
use crate::fem::Space;
use crate::mesh::{Location, Locator, Mesh, Point};
use nalgebra::{SMatrix, SVector};

/// Points in the shortest edge of a cell on the line along which a wake is measured.
const POINTS: f64 = 8.0;
/// Slack of barycentric coordinates where a line meets a facet.
const SLACK: f64 = 1e-9;
/// Halvings of the distance between two points where the velocity turns.
const HALVINGS: usize = 40;

/// The line from the rear of a body on along the stream, through the centre of its surface.
pub struct Wake<const D: usize> {
    stream: SVector<f64, D>,
    /// Distances from the rear, with their places in the mesh.
    points: Vec<(f64, Location)>,
}

impl<const D: usize> Wake<D> {
    /// The line behind the boundary `name` in the direction `stream`, a unit vector; `None` if the
    /// line from the centre of the boundary does not come out of it into the fluid.
    ///
    /// # Errors
    /// A boundary that the mesh does not have.
    pub fn new(mesh: &Mesh<D>, name: &str, stream: &SVector<f64, D>) -> Result<Option<Wake<D>>> {
        let facets: Vec<[Point<D>; D]> = mesh
            .boundary(name)?
            .iter()
            .map(|&f| {
                let mut ends = mesh.facet_points(&mesh.facets()[f as usize]);
                std::array::from_fn(|_| {
                    ends.next().map_or(Point::<D>::zeros(), |p| mesh.points()[p as usize])
                })
            })
            .collect();
        let sizes =
            mesh.boundary(name)?.iter().map(|&f| mesh.facet_normal(&mesh.facets()[f as usize]).1);
        let (mut centre, mut all) = (Point::<D>::zeros(), 0.0);
        for (ends, size) in facets.iter().zip(sizes) {
            centre += ends.iter().sum::<Point<D>>() * (size / D as f64);
            all += size;
        }
        centre /= all;
        let met = facets.iter().filter_map(|ends| crossing(ends, &centre, stream));
        let Some(rear) = met.filter(|s| *s > 0.0).max_by(f64::total_cmp) else { return Ok(None) };
        let locator = Locator::new(mesh);
        let (low, high) = mesh.bounding_box();
        let all = (high - low).norm();
        let mut points = Vec::new();
        // A little way off the surface, which is in the fluid if it is anywhere.
        let mut s = 1e-9 * all;
        while let Some(at) = locator.locate(mesh, &(centre + stream * (rear + s))) {
            points.push((s, at));
            s += shortest(mesh, at.cell as usize) / POINTS;
        }
        Ok((points.len() > 1).then_some(Wake { stream: *stream, points }))
    }

    /// Length of the recirculation: the distance from the rear at which the velocity along the
    /// stream, which is negative behind the body, becomes positive. 0 where it is positive from the
    /// rear on, NaN where it does not become so within the mesh.
    pub fn recirculation(&self, space: &Space<D>, u: &[SVector<f64, D>]) -> f64 {
        let along =
            |at: &Location| space.value(u, at.cell as usize, &at.barycentric).dot(&self.stream);
        let mut before = 0.0;
        for (k, (s, at)) in self.points.iter().enumerate().skip(1) {
            if along(at) < 0.0 {
                before = *s;
                continue;
            }
            // On the polynomial of this cell, as far back as the last point.
            let (mesh, x, mut low, mut high) =
                (space.mesh(), space.mesh().point_at(at), before, *s);
            let there = |z: f64| {
                let back = x - self.stream * (s - z);
                let barycentric = mesh.map(at.cell as usize).barycentric(&back);
                along(&Location { cell: at.cell, barycentric })
            };
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                if there(middle) < 0.0 { low = middle } else { high = middle }
            }
            return if k > 1 { high } else { 0.0 };
        }
        f64::NAN
    }
}

/// Where the line `x + s d` meets a facet; `None` where it does not.
fn crossing<const D: usize>(
    ends: &[Point<D>; D],
    x: &Point<D>,
    d: &SVector<f64, D>,
) -> Option<f64> {
    let sides = SMatrix::<f64, D, D>::from_fn(|i, j| match j {
        0 => d[i],
        _ => ends[0][i] - ends[j][i],
    });
    let solved = sides.try_inverse()? * (ends[0] - x);
    let share: f64 = solved.iter().skip(1).sum();
    let inside = solved.iter().skip(1).all(|t| *t >= -SLACK) && share <= 1.0 + SLACK;
    inside.then_some(solved[0])
}

/// The shortest edge of a cell.
fn shortest<const D: usize>(mesh: &Mesh<D>, cell: usize) -> f64 {
    let x = |k: usize| mesh.points()[mesh.cell(cell)[k] as usize];
    let pairs = (0..=D).flat_map(|a| (0..a).map(move |b| (a, b)));
    pairs.map(|(a, b)| (x(a) - x(b)).norm()).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Element;
    use crate::mesh::{Diagonals, box_mesh, rectangle};
    use std::sync::Arc;

    /// A mesh without the cells whose centres lie within a distance of a point in every direction;
    /// the hole is `body`.
    fn with_hole<const D: usize>(mesh: &Mesh<D>, centre: f64, half: f64) -> Arc<Mesh<D>> {
        let middle = |c: usize| {
            mesh.cell(c).iter().map(|&p| mesh.points()[p as usize]).sum::<Point<D>>()
                / (D + 1) as f64
        };
        let near = |x: &Point<D>, r: f64| x.iter().all(|x| (x - centre).abs() < r);
        let kept = (0..mesh.cell_count()).filter(|&c| !near(&middle(c), half));
        let cells = kept.flat_map(|c| mesh.cell(c).to_vec()).collect();
        let mut holed = Mesh::new(mesh.points().to_vec(), cells).unwrap();
        let at_hole = |f: &u32| {
            let mut ends = holed.facet_points(&holed.facets()[*f as usize]);
            ends.all(|p| near(&holed.points()[p as usize], half + 1e-9))
        };
        let body = (0..holed.facets().len() as u32).filter(at_hole).collect();
        holed.set_boundary("body", body);
        Arc::new(holed)
    }

    fn measured<const D: usize>(mesh: &Mesh<D>, axis: usize, sign: f64, turns: f64) -> f64 {
        let mesh = with_hole(mesh, 1.5, 0.5);
        let stream = SVector::<f64, D>::from_fn(|i, _| if i == axis { sign } else { 0.0 });
        let wake = Wake::new(&mesh, "body", &stream).unwrap().unwrap();
        let space = Space::new(&mesh, Element::P2);
        // Zero at the rear, and at `turns` behind it.
        let u = space.interpolate(|x| {
            let s = sign * (x[axis] - 1.5) - 0.5;
            stream * (s * (s - turns))
        });
        wake.recirculation(&space, &u)
    }

    #[test]
    fn the_wake_ends_where_the_stream_goes_on() {
        let plane = rectangle([0.0; 2], [3.0; 2], [9; 2], Diagonals::UnionJack).unwrap();
        let space = box_mesh([0.0; 3], [3.0; 3], [6; 3]).unwrap();
        for (axis, sign) in [(0, 1.0), (1, 1.0), (0, -1.0)] {
            assert!((measured(&plane, axis, sign, 0.37) - 0.37).abs() < 1e-9, "{axis} {sign}");
            assert!((measured(&space, axis, sign, 0.61) - 0.61).abs() < 1e-9, "{axis} {sign}");
        }
        // No wake; one that does not end in the mesh.
        assert_eq!(measured(&plane, 0, 1.0, -1.0), 0.0);
        assert!(measured(&plane, 0, 1.0, 2.0).is_nan());
    }

    #[test]
    fn a_side_of_the_mesh_has_no_wake() {
        let mesh = rectangle([0.0; 2], [1.0; 2], [4; 2], Diagonals::Right).unwrap();
        let stream = SVector::<f64, 2>::new(1.0, 0.0);
        assert!(Wake::new(&mesh, "top", &stream).unwrap().is_none());
        assert!(Wake::new(&mesh, "body", &stream).is_err());
    }
}
