//! Segmentation of an image by a level set: the side of each pixel, and the contours in the
//! coordinates of the image.

use super::sampling::Lattice;
use super::series::Series;
use crate::base::Result;
use crate::fem::Space;
use crate::levelset::Contour;
use crate::mesh::Point;

/// Placement of an image: its lower left corner is the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixels {
    /// Columns and rows.
    pub size: [usize; 2],
    /// Side of a pixel.
    pub side: f64,
}

impl Pixels {
    /// True for pixels with `phi < 0` in their middle, row by row from the top; false outside of
    /// the mesh.
    pub fn inside(&self, space: &Space<2>, phi: &[f64]) -> Vec<bool> {
        let [columns, rows] = self.size;
        let lattice = Lattice {
            origin: [0.5 * self.side, (rows as f64 - 0.5) * self.side],
            step: [self.side, -self.side],
            columns,
            rows,
        };
        lattice.sample(space.mesh(), false, |c, l| space.value(phi, c, l) < 0.0)
    }

    /// The lines of a contour as a table of points: number of the line, whether it is `closed`
    /// (else both ends lie on the boundary), whether it is the rim of a `hole`, and `column` and
    /// `row` in pixels from the upper left corner of the image. The inside is on the left when a
    /// line is walked in the scene, whose second axis points up.
    ///
    /// # Errors
    /// None is known.
    pub fn contours(&self, contour: &Contour) -> Result<Series> {
        let mut columns: [Vec<f64>; 5] = Default::default();
        for (k, line) in contour.lines().iter().enumerate() {
            let points = contour.polyline(line);
            let hole = line.closed && enclosed(&points) < 0.0;
            for x in &points {
                let place = [x[0] / self.side, self.size[1] as f64 - x[1] / self.side];
                let row = [
                    k as f64,
                    f64::from(u8::from(line.closed)),
                    f64::from(u8::from(hole)),
                    place[0],
                    place[1],
                ];
                columns.iter_mut().zip(row).for_each(|(column, v)| column.push(v));
            }
        }
        let names = ["contour", "closed", "hole", "column", "row"];
        let named: Vec<(&str, &[f64])> =
            names.into_iter().zip(columns.iter().map(Vec::as_slice)).collect();
        Ok(Series::new(&named))
    }
}

/// The area that a closed polygon walks around counter-clockwise.
fn enclosed(points: &[Point<2>]) -> f64 {
    points.windows(2).map(|p| 0.5 * (p[0][0] * p[1][1] - p[0][1] * p[1][0])).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Element;
    use crate::mesh::{Diagonals, rectangle};
    use std::f64::consts::PI;
    use std::sync::Arc;

    #[test]
    fn a_ring_has_two_lines_and_its_pixels() {
        let pixels = Pixels { size: [40, 30], side: 0.5 };
        let mesh =
            Arc::new(rectangle([0.0, 0.0], [20.0, 15.0], [20, 15], Diagonals::Right).unwrap());
        let space = Space::new(&mesh, Element::P2);
        let radius = |x: &Point<2>| (x - Point::<2>::new(9.0, 8.0)).norm();
        let phi = space.interpolate(|x| (radius(x) - 4.0).abs() - 2.0);
        let inside = pixels.inside(&space, &phi);
        // Column 18 and row 13 are at (9.25, 8.25), in the hole; 9 columns to the left is the ring.
        assert!(!inside[13 * 40 + 18] && inside[13 * 40 + 9] && !inside[0]);
        let area = inside.iter().filter(|i| **i).count() as f64 * 0.25;
        assert!((area / (32.0 * PI) - 1.0).abs() < 0.03, "{area}");
        let table = pixels.contours(&Contour::new(&space, &phi).unwrap()).unwrap();
        let (line, hole) = (table.column("contour").unwrap(), table.column("hole").unwrap());
        assert_eq!(line.last(), Some(&1.0));
        for k in 0..table.rows() {
            let place =
                [table.column("column").unwrap()[k] - 18.0, table.column("row").unwrap()[k] - 14.0];
            let exact = if hole[k] == 1.0 { 4.0 } else { 12.0 };
            assert!((place[0].hypot(place[1]) - exact).abs() < 0.05, "{place:?}");
        }
        assert!(
            table.column("closed").unwrap().iter().all(|c| *c == 1.0)
                && hole.contains(&1.0)
                && hole.contains(&0.0)
        );
    }
}
