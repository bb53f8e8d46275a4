//! Segments cut off at a rectangle.

use super::raster::Segment;

/// The part of a segment inside of `[left, top, right, bottom]`, by the parameters at which it
/// crosses the four lines (Liang and Barsky 1984).
pub(super) fn clipped(segment: &Segment, [left, top, right, bottom]: [f64; 4]) -> Option<Segment> {
    let [a, b] = *segment;
    let d = [b[0] - a[0], b[1] - a[1]];
    let (mut first, mut last) = (0.0f64, 1.0f64);
    for (axis, low, high) in [(0, left, right), (1, top, bottom)] {
        if d[axis] == 0.0 {
            if a[axis] < low || a[axis] > high {
                return None;
            }
            continue;
        }
        let at = [low, high].map(|end| (end - a[axis]) / d[axis]);
        (first, last) = (first.max(at[0].min(at[1])), last.min(at[0].max(at[1])));
    }
    let at = |s: f64| [a[0] + s * d[0], a[1] + s * d[1]];
    // All of a segment is kept as it is.
    let ends = [if first > 0.0 { at(first) } else { a }, if last < 1.0 { at(last) } else { b }];
    (first <= last).then_some(ends)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_inside_is_kept_and_what_is_outside_is_not() {
        let clip = |ends| clipped(&ends, [0.0, 0.0, 4.0, 2.0]);
        assert_eq!(clip([[1.0, 1.0], [3.0, 1.5]]), Some([[1.0, 1.0], [3.0, 1.5]]));
        assert_eq!(clip([[-2.0, 1.0], [6.0, 1.0]]), Some([[0.0, 1.0], [4.0, 1.0]]));
        assert_eq!(clip([[3.0, 3.0], [3.0, -1.0]]), Some([[3.0, 2.0], [3.0, 0.0]]));
        assert_eq!(clip([[-2.0, 1.0], [6.0, 5.0]]), Some([[0.0, 2.0], [0.0, 2.0]]));
        assert_eq!(clip([[-2.0, 1.5], [6.0, 9.5]]), None);
        assert_eq!(clip([[5.0, 0.0], [5.0, 2.0]]), None);
    }
}
