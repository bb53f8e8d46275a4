//! The checkerboard that a material carries with it.

use crate::mesh::Point;
use std::f64::consts::PI;

/// A pattern of two colours on the body in its reference state. Painted on the deformed body, it
/// shows how the material has moved, as in Fig. 5.2 of the paper on membranes with shear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pattern {
    /// Fields of longitude and latitude about a centre; the poles lie in the direction of z.
    Globe {
        /// The centre.
        centre: Point<3>,
        /// Fields around the equator; even, or two neighbours have the same colour.
        around: usize,
        /// Fields from pole to pole.
        along: usize,
    },
    /// Cubes with this length of an edge, corners of eight meet at the origin.
    Cubes {
        /// The corner of eight cubes.
        origin: Point<3>,
        /// The length of an edge.
        edge: f64,
    },
}

impl Pattern {
    /// True for a material point `y` of the second of the two colours.
    pub fn is_odd(&self, y: &Point<3>) -> bool {
        let fields = match self {
            Pattern::Globe { centre, around, along } => {
                let d = y - centre;
                let longitude = d[1].atan2(d[0]) / (2.0 * PI) + 0.5;
                let latitude = d[2].atan2(d[0].hypot(d[1])) / PI + 0.5;
                (longitude * *around as f64).floor() + (latitude * *along as f64).floor()
            }
            Pattern::Cubes { origin, edge } => {
                ((y - origin) / *edge).iter().map(|v| v.floor()).sum()
            }
        };
        fields.rem_euclid(2.0) >= 1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_colour_changes_across_each_line_of_the_globe() {
        let globe = Pattern::Globe { centre: Point::<3>::new(1.0, 2.0, 3.0), around: 8, along: 4 };
        let odd = |longitude: f64, latitude: f64| {
            let (a, b) = (longitude.to_radians(), latitude.to_radians());
            let direction = Point::<3>::new(b.cos() * a.cos(), b.cos() * a.sin(), b.sin());
            globe.is_odd(&(Point::<3>::new(1.0, 2.0, 3.0) + direction * 0.5))
        };
        for k in 0..8 {
            let line = 45.0 * f64::from(k);
            assert_ne!(odd(line - 1.0, 10.0), odd(line + 1.0, 10.0), "meridian {line}");
            assert_eq!(odd(line + 1.0, 10.0), odd(line + 44.0, 40.0));
        }
        for line in [-45.0, 0.0, 45.0] {
            assert_ne!(odd(10.0, line - 1.0), odd(10.0, line + 1.0), "parallel {line}");
        }
    }

    #[test]
    fn the_colour_changes_across_each_face_of_the_cubes() {
        let cubes = Pattern::Cubes { origin: Point::<3>::new(0.5, 0.0, 0.0), edge: 0.25 };
        let odd = |x, y, z| cubes.is_odd(&Point::<3>::new(x, y, z));
        assert!(
            !odd(0.6, 0.1, 0.1) && odd(0.6, -0.1, 0.1) && odd(0.8, 0.1, 0.1) && odd(0.6, 0.1, 0.3)
        );
        assert!(!odd(0.6, -0.1, -0.1) && odd(0.4, -0.1, -0.1));
    }
}
