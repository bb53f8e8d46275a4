//! Unions of shapes in space.

use super::shape::Shape;
use crate::base::{Error, Result};
use crate::mesh::Point;

/// The union of shapes in space, with the smallest of their distances.
///
/// Exact outside, and inside as long as the ball of this radius meets one part only. Where parts
/// overlap, the nearest boundary of one part may lie inside another: the distance inside is then
/// that to the boundary of the part in which the point is deepest, which is at most the true one.
/// Its slope is 1 and its zero set exact everywhere.
pub struct SolidUnion {
    parts: Vec<Box<dyn Shape<3>>>,
    bounds: (Point<3>, Point<3>),
}

impl SolidUnion {
    /// # Errors
    /// No part.
    pub fn new(parts: Vec<Box<dyn Shape<3>>>) -> Result<SolidUnion> {
        let boxes = parts.iter().map(|s| s.bounds());
        match boxes.reduce(|a, b| (a.0.inf(&b.0), a.1.sup(&b.1))) {
            Some(bounds) => Ok(SolidUnion { parts, bounds }),
            None => Err(Error::scene("a union needs at least one shape")),
        }
    }
}

impl Shape<3> for SolidUnion {
    fn distance(&self, x: &Point<3>) -> f64 {
        self.parts.iter().map(|s| s.distance(x)).fold(f64::INFINITY, f64::min)
    }
    fn bounds(&self) -> (Point<3>, Point<3>) {
        self.bounds
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::levelset::Circle;

    #[test]
    fn two_balls_are_as_far_as_the_nearer_and_as_deep_as_the_deeper() {
        let ball = |x: f64| {
            Box::new(Circle::new(Point::<3>::new(x, 0.0, 0.0), 1.0).unwrap()) as Box<dyn Shape<3>>
        };
        let both = SolidUnion::new(vec![ball(0.0), ball(1.5)]).unwrap();
        assert_eq!(both.distance(&Point::<3>::new(4.5, 0.0, 0.0)), 2.0);
        assert_eq!(both.distance(&Point::<3>::new(0.0, 0.0, 0.0)), -1.0);
        assert_eq!(both.bounds().1, Point::<3>::new(2.5, 1.0, 1.0));
        assert!(SolidUnion::new(Vec::new()).is_err());
    }
}
