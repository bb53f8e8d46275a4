//! Which colour a value has.

use super::field::FieldData;

/// The colours of the values from `low` to `high`; values beyond get the colour of the nearer end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// The lowest value.
    pub low: f64,
    /// The highest value.
    pub high: f64,
    /// Whether zero is the middle: blue below it, red above. Otherwise dark to bright.
    pub signed: bool,
}

/// Colours in a table.
const STEPS: usize = 512;

impl Scale {
    /// The scale for a field: of both signs and symmetric if the field takes both, otherwise from its least to its
    /// greatest value. A vector field is shown by its length. Values that are not finite do not count.
    pub fn of<const D: usize>(field: FieldData<D>) -> Scale {
        let range = |values: &mut dyn Iterator<Item = f64>| {
            values.filter(|v| v.is_finite()).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)))
        };
        let (low, high) = match field {
            FieldData::Scalar(f) => range(&mut f.iter().copied()),
            FieldData::Vector(f) => range(&mut f.iter().map(|v| v.norm()).chain(std::iter::once(0.0))),
        };
        if low > high {
            return Scale { low: 0.0, high: 1.0, signed: false };
        }
        // A few negative values of a field that is positive by nature do not make it a signed one.
        let signed = low < 0.0 && high > 0.0 && low.abs().min(high) > 0.05 * low.abs().max(high);
        Scale { low, high, signed }.opened()
    }
    /// The scale that serves both: for the frames of a film.
    pub fn with(self, other: Scale) -> Scale {
        let (low, high) = (self.low.min(other.low), self.high.max(other.high));
        Scale { low, high, signed: self.signed || other.signed }.opened()
    }
    /// Symmetric if signed, and never empty: rounding is not worth colours.
    fn opened(self) -> Scale {
        let largest = self.low.abs().max(self.high.abs());
        if self.signed {
            return Scale { low: -largest, high: largest, ..self };
        }
        let room = if largest == 0.0 { 1.0 } else { 0.05 * largest };
        if self.high - self.low > 1e-12 * largest {
            self
        } else {
            Scale { low: self.low, high: self.low + room, ..self }
        }
    }
    /// Colours from the lowest to the highest value: viridis, or the red and blue of ColorBrewer.
    pub(super) fn table(self) -> Vec<[u8; 3]> {
        let colour = |k: usize| {
            let s = k as f64 / (STEPS - 1) as f64;
            let c = if self.signed {
                colorous::RED_BLUE.eval_continuous(1.0 - s)
            } else {
                colorous::VIRIDIS.eval_continuous(s)
            };
            [c.r, c.g, c.b]
        };
        (0..STEPS).map(colour).collect()
    }
    /// Entry of [`Scale::table`] for a value; none if it is not a number.
    pub(super) fn entry(self, v: f64) -> Option<usize> {
        let s = (v - self.low) / (self.high - self.low);
        (!s.is_nan()).then(|| (s.clamp(0.0, 1.0) * (STEPS - 1) as f64).round() as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::SVector;

    #[test]
    fn the_scale_fits_the_field() {
        let of = |f: &[f64]| Scale::of(FieldData::<2>::Scalar(f));
        assert_eq!(of(&[-2.0, 1.0, f64::NAN]), Scale { low: -2.0, high: 2.0, signed: true });
        assert_eq!(of(&[-0.01, 1.0]), Scale { low: -0.01, high: 1.0, signed: false });
        assert_eq!(of(&[0.0, 0.0]), Scale { low: 0.0, high: 1.0, signed: false });
        assert!(of(&[3.0, 3.0]).high > 3.1);
        assert!(of(&[]).high > of(&[]).low);
        let u = [SVector::<f64, 2>::new(3.0, -4.0)];
        assert_eq!(Scale::of(FieldData::Vector(&u)), Scale { low: 0.0, high: 5.0, signed: false });
        assert_eq!(of(&[-2.0, 1.0]).with(of(&[0.0, 7.0])), Scale { low: -7.0, high: 7.0, signed: true });
    }

    #[test]
    fn colours_run_from_end_to_end() {
        let scale = Scale { low: -1.0, high: 1.0, signed: true };
        let (table, at) = (scale.table(), |v| scale.entry(v));
        assert_eq!((at(-9.0), at(1.0), at(f64::NAN)), (Some(0), Some(STEPS - 1), None));
        assert!(table[0][2] > table[0][0] && table[STEPS - 1][0] > table[STEPS - 1][2], "blue to red");
        let middle = table[at(0.0).unwrap()];
        assert!(middle.iter().all(|&c| c > 235), "zero is nearly white: {middle:?}");
    }
}
