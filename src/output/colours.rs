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
    /// True if the colours begin and end at exactly these values; otherwise they may be widened,
    /// so that zero is in the middle of two colours or a constant has a range.
    pub fixed: bool,
}

/// Colours from the lowest to the highest value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColourMap {
    /// Viridis of matplotlib.
    Viridis,
    /// Cividis, which the colour-blind see alike (Nunez, Anderton and Renslow 2018).
    Cividis,
    /// Magma of matplotlib.
    Magma,
    /// Inferno of matplotlib.
    Inferno,
    /// Plasma of matplotlib.
    Plasma,
    /// Blue below zero and red above (ColorBrewer).
    BlueRed,
    /// Black to white.
    Grey,
}

impl ColourMap {
    /// The colour at the fraction `s` of the way.
    fn at(self, s: f64) -> [u8; 3] {
        let map = match self {
            ColourMap::Viridis => colorous::VIRIDIS,
            ColourMap::Cividis => colorous::CIVIDIS,
            ColourMap::Magma => colorous::MAGMA,
            ColourMap::Inferno => colorous::INFERNO,
            ColourMap::Plasma => colorous::PLASMA,
            ColourMap::BlueRed => colorous::RED_BLUE,
            ColourMap::Grey => return [(255.0 * s).round() as u8; 3],
        };
        let c = map.eval_continuous(if self == ColourMap::BlueRed { 1.0 - s } else { s });
        [c.r, c.g, c.b]
    }
}

impl Scale {
    /// From `low` to `high`, and widened where it helps.
    pub fn new(low: f64, high: f64) -> Scale {
        Scale { low, high, fixed: false }
    }
    /// From the least to the greatest value at the nodes, of the length for a vector field. Values
    /// that are not finite do not count; without values the range is empty.
    pub fn of<const D: usize>(field: FieldData<D>) -> Scale {
        let range = |values: &mut dyn Iterator<Item = f64>| {
            let finite = values.filter(|v| v.is_finite());
            finite
                .fold(Scale::new(f64::INFINITY, f64::NEG_INFINITY), |s, v| s.with(Scale::new(v, v)))
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
        Scale { low: self.low.min(other.low), high: self.high.max(other.high), ..self }
    }
}

/// The colours of a scale: those of a map, or viridis, or blue below zero and red above where
/// values have both signs.
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
    /// Colours by `map`, or by the one that fits the values.
    pub fn new(scale: Scale, map: Option<ColourMap>) -> Colours {
        let Scale { low, high, fixed } =
            if scale.low <= scale.high { scale } else { Scale::new(0.0, 1.0) };
        let largest = low.abs().max(high.abs());
        // A few negative values of a field that is positive by nature do not make it a signed one.
        let both = low < 0.0 && high > 0.0 && low.abs().min(high) > 0.05 * largest;
        let map = map.unwrap_or(if both { ColourMap::BlueRed } else { ColourMap::Viridis });
        let signed = map == ColourMap::BlueRed;
        let (low, high) = match (signed, largest) {
            _ if fixed && low < high => (low, high),
            (_, 0.0) => (0.0, 1.0),
            (true, _) => (-largest, largest),
            // Rounding is not worth colours.
            _ if high - low <= 1e-12 * largest => (low, low + 0.05 * largest),
            _ => (low, high),
        };
        let colour = |k: usize| {
            let s = k as f64 / (STEPS - 1) as f64;
            let zero_in_the_middle =
                0.5 + 0.5 * (low + s * (high - low)) / low.abs().max(high.abs());
            map.at(if signed { zero_in_the_middle } else { s })
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
        Colours::new(Scale::of(FieldData::<2>::Scalar(values)), None)
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
        assert_eq!(Scale::of(FieldData::Vector(&u)), Scale::new(0.0, 5.0));
    }

    #[test]
    fn frames_at_rest_do_not_change_the_scale_of_a_film() {
        let of = |values: &[f64]| Scale::of(FieldData::<2>::Scalar(values));
        let film = of(&[]).with(of(&[0.0])).with(of(&[1e-17, -1e-17])).with(of(&[0.0, 0.2]));
        let colours = Colours::new(film, None);
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
    #[test]
    fn a_fixed_range_is_kept_and_zero_stays_white() {
        let fixed = |low, high, map| Colours::new(Scale { low, high, fixed: true }, map);
        let c = fixed(-1.0, 3.0, None);
        assert_eq!((c.low, c.high), (-1.0, 3.0));
        assert!(c.of(0.0).iter().all(|&x| x > 235), "{:?}", c.of(0.0));
        let end = colorous::RED_BLUE.eval_continuous(0.0);
        assert_eq!(c.of(7.0), [end.r, end.g, end.b], "beyond the end");
        let c = fixed(0.0, 1.0, Some(ColourMap::Magma));
        let middle = colorous::MAGMA.eval_continuous(0.5);
        assert!(
            c.of(0.5).iter().zip([middle.r, middle.g, middle.b]).all(|(a, b)| a.abs_diff(b) < 3)
        );
        assert_eq!(Colours::new(Scale::new(0.0, 1.0), Some(ColourMap::Grey)).of(1.0), [255; 3]);
    }
}
