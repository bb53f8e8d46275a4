//! Points at equal distances on an interface.

use super::interface::Interface;
use crate::base::{Cause, Error, Result};
use crate::mesh::Point;

impl<const D: usize> Interface<'_, D> {
    /// `count` points at equal distances along a closed curve of the plane: on the cut interface
    /// first, then moved onto the zero set of `distance`.
    ///
    /// # Errors
    /// A surface in space; several curves or none.
    pub fn markers(
        &self,
        distance: &dyn Fn(&Point<D>) -> f64,
        count: usize,
    ) -> Result<Vec<Point<D>>> {
        let Some(contour) = self.contour() else {
            return Err(Error::scene("markers follow a curve, and the interface is a surface")
                .value(count)
                .remedy("leave them out"));
        };
        let [line] = contour.lines() else {
            return Err(Error::scene("markers need an interface of one closed curve")
                .value(format!("{} curves", contour.lines().len()))
                .remedy("give each curve a level set of its own")
                .because(Cause::SeveralCurves));
        };
        let polyline: Vec<Point<D>> =
            contour.polyline(line).iter().map(|x| x.fixed_resize(0.0)).collect();
        let mut lengths = vec![0.0];
        for pair in polyline.windows(2) {
            lengths.push(lengths[lengths.len() - 1] + (pair[1] - pair[0]).norm());
        }
        let whole = lengths[lengths.len() - 1];
        let delta = 1e-6 * whole;
        let onto = |x: Point<D>| {
            let along = |axis: usize| {
                let mut step = Point::<D>::zeros();
                step[axis] = delta;
                (distance(&(x + step)) - distance(&(x - step))) / (2.0 * delta)
            };
            x - Point::<D>::from_fn(|axis, _| along(axis)) * distance(&x)
        };
        let point = |k: usize| {
            let s = whole * k as f64 / count as f64;
            let i = lengths.partition_point(|l| *l <= s).clamp(1, polyline.len() - 1);
            let t = (s - lengths[i - 1]) / (lengths[i] - lengths[i - 1]).max(f64::MIN_POSITIVE);
            onto(onto(polyline[i - 1] + (polyline[i] - polyline[i - 1]) * t))
        };
        Ok((0..count).map(point).collect())
    }
}
