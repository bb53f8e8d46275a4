//! Colours of values.

use super::field::FieldData;

/// The range of the values that get different colours; values beyond get the colour of the nearer
/// end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// The lowest value.
    pub low: f64,
    /// The highest value.
    pub high: f64,
}

impl Scale {
    /// From the least to the greatest value at the nodes, of the length for a vector field. Values
    /// that are not finite do not count; without values the range is empty.
    pub fn of<const D: usize>(field: FieldData<D>) -> Scale {
        let range = |values: &mut dyn Iterator<Item = f64>| {
            let finite = values.filter(|v| v.is_finite());
            finite.fold(Scale { low: f64::INFINITY, high: f64::NEG_INFINITY }, |s, v| {
                s.with(Scale { low: v, high: v })
            })
        };
        match field {
            FieldData::Scalar(f) => range(&mut f.iter().copied()),
            // A length is compared with zero.
            FieldData::Vector(f) => {
                range(&mut f.iter().map(|v| v.norm()).chain(std::iter::once(0.0)))
            }
        }
    }
    /// The scale that serves both: for the frames of a film.
    pub fn with(self, other: Scale) -> Scale {
        Scale { low: self.low.min(other.low), high: self.high.max(other.high) }
    }
}

/// The colours of a scale: viridis, or blue below zero and red above (ColorBrewer) where values
/// have both signs.
pub(super) struct Colours {
    /// The lowest and the highest value of the colour bar, never equal.
    pub low: f64,
    pub high: f64,
    pub signed: bool,
    /// Colours from the lowest to the highest value.
    pub table: Vec<[u8; 3]>,
}

/// Colours in a table.
const STEPS: usize = 512;

impl Colours {
    pub fn new(scale: Scale) -> Colours {
        Colours::with(scale, false)
    }
    /// Greys from black to white where `grey`, else colours.
    pub fn with(scale: Scale, grey: bool) -> Colours {
        let Scale { low, high } =
            if scale.low <= scale.high { scale } else { Scale { low: 0.0, high: 1.0 } };
        let largest = low.abs().max(high.abs());
        // A few negative values of a field that is positive by nature do not make it a signed one.
        let signed = !grey && low < 0.0 && high > 0.0 && low.abs().min(high) > 0.05 * largest;
        let (low, high) = match (signed, largest) {
            (true, _) => (-largest, largest),
            (_, 0.0) => (0.0, 1.0),
            // Rounding is not worth colours.
            _ if high - low <= 1e-12 * largest => (low, low + 0.05 * largest),
            _ => (low, high),
        };
        let colour = |k: usize| {
            let s = k as f64 / (STEPS - 1) as f64;
            if grey {
                return [(255.0 * s).round() as u8; 3];
            }
            let map = if signed { colorous::RED_BLUE } else { colorous::VIRIDIS };
            let c = map.eval_continuous(if signed { 1.0 - s } else { s });
            [c.r, c.g, c.b]
        };
        Colours { low, high, signed, table: (0..STEPS).map(colour).collect() }
    }
    /// The colour of a value; grey if it is not a number.
    pub fn of(&self, v: f64) -> [u8; 3] {
        let s = ((v - self.low) / (self.high - self.low)).clamp(0.0, 1.0);
        if s.is_nan() { [128; 3] } else { self.table[(s * (STEPS - 1) as f64).round() as usize] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::SVector;

    fn colours(values: &[f64]) -> Colours {
        Colours::new(Scale::of(FieldData::<2>::Scalar(values)))
    }

    #[test]
    fn the_scale_fits_the_field() {
        let of = |values: &[f64]| {
            let c = colours(values);
            (c.low, c.high, c.signed)
        };
        assert_eq!(of(&[-2.0, 1.0, f64::NAN]), (-2.0, 2.0, true));
        assert_eq!(of(&[-0.01, 1.0]), (-0.01, 1.0, false));
        assert_eq!(of(&[0.0, 0.0]), (0.0, 1.0, false));
        assert_eq!(of(&[]), (0.0, 1.0, false));
        assert!(of(&[3.0, 3.0]).1 > 3.1 && of(&[-3.0]).1 > -3.0);
        let u = [SVector::<f64, 2>::new(3.0, -4.0)];
        assert_eq!(Scale::of(FieldData::Vector(&u)), Scale { low: 0.0, high: 5.0 });
    }

    #[test]
    fn frames_at_rest_do_not_change_the_scale_of_a_film() {
        let of = |values: &[f64]| Scale::of(FieldData::<2>::Scalar(values));
        let film = of(&[]).with(of(&[0.0])).with(of(&[1e-17, -1e-17])).with(of(&[0.0, 0.2]));
        let colours = Colours::new(film);
        assert!(!colours.signed && colours.high == 0.2);
    }

    #[test]
    fn colours_run_from_end_to_end() {
        let c = colours(&[-1.0, 1.0]);
        let ([r, _, b], [red, _, blue]) = (c.of(-9.0), c.of(1.0));
        assert!(b > r && red > blue, "blue to red");
        assert!(c.of(0.0).iter().all(|&x| x > 235), "zero is nearly white");
        assert_eq!(c.of(f64::NAN), [128; 3]);
    }
}
