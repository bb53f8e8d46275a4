//! Numbers for people: on axes and colour bars, in texts and tables.

pub use crate::base::rounded;
pub(super) use crate::base::trimmed;

/// Round numbers in `[low, high]`, about `count` of them.
pub(super) fn ticks(low: f64, high: f64, count: f64) -> Vec<f64> {
    let rough = (high - low) / count;
    if !(rough.is_finite() && rough > 0.0) {
        return Vec::new();
    }
    let decade = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 2.5, 5.0, 10.0]
        .into_iter()
        .map(|m| m * decade)
        .find(|s| *s >= rough)
        .unwrap_or(rough);
    let first = (low / step - 1e-9).ceil();
    (0..=(2.0 * count) as usize)
        .map(|k| (first + k as f64) * step)
        .take_while(|v| *v <= high + 1e-9 * step)
        .collect()
}

/// Round numbers in `[low, high]`, about `count` of them and three at least.
pub(super) fn ticks_for_reading(low: f64, high: f64, count: f64) -> Vec<f64> {
    let finer = |more: i32| ticks(low, high, count + f64::from(more));
    // Six intervals give steps of at most a third of the length.
    (0..=6).map(finer).find(|found| found.len() >= 3).unwrap_or_default()
}

/// A number on an axis with ticks about `step` apart and numbers up to `largest`: as many digits as
/// tell ticks apart.
pub(super) fn tick_text(v: f64, step: f64, largest: f64) -> String {
    let decade = |x: f64| if x > 0.0 { x.log10().floor() } else { 0.0 };
    // Ticks are multiples of 1, 2, 2.5 or 5 times a power of ten: one digit more than the step has.
    let digits = 1.0 - decade(step);
    if (1e-3..1e6).contains(&largest) {
        return trimmed(&format!("{v:.*}", digits.clamp(0.0, 15.0) as usize));
    }
    let text = format!("{v:.*e}", (digits + decade(v.abs())).clamp(0.0, 15.0) as usize);
    match text.split_once('e') {
        Some((mantissa, exponent)) if v.abs() > 1e-9 * step => {
            format!("{}e{exponent}", trimmed(mantissa))
        }
        _ => "0".into(),
    }
}

/// A number for people: six digits, without zeros at the end.
pub(super) fn short(v: f64) -> String {
    rounded(v, 6)
}

/// A fraction in per cent for people, with at most `digits` digits.
pub fn per_cent(v: f64, digits: usize) -> String {
    format!("{} %", rounded(100.0 * v, digits))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        let text = |low, high| {
            ticks(low, high, 5.0).iter().map(|&v| short(v)).collect::<Vec<_>>().join(" ")
        };
        assert_eq!(text(0.0, 1.0), "0 0.2 0.4 0.6 0.8 1");
        assert_eq!(text(-0.31, 0.77), "-0.25 0 0.25 0.5 0.75");
        assert_eq!(text(0.0, 3e-7), "0 1e-7 2e-7 3e-7");
        for (low, high) in [(1.0, 1.0), (0.0, f64::INFINITY), (f64::NAN, 1.0), (2.0, 1.0)] {
            assert!(ticks(low, high, 5.0).is_empty());
        }
    }

    #[test]
    fn three_ticks_are_there_to_be_read_whatever_the_range() {
        let ends = (1..400).map(|k| f64::from(k) * 0.37);
        for (low, high) in ends.flat_map(|h| [(0.0, h), (-0.61 * h, h), (0.93 * h, h), (-h, 0.0)]) {
            let found = ticks_for_reading(low, high, 2.0);
            assert!((3..=8).contains(&found.len()), "{low} {high}: {found:?}");
            let texts: Vec<String> = found
                .iter()
                .map(|&v| tick_text(v, 0.2 * (high - low), low.abs().max(high.abs())))
                .collect();
            assert!(texts.windows(2).all(|t| t[0] != t[1]), "{low} {high}: {texts:?}");
        }
        assert!(ticks_for_reading(0.0, f64::NAN, 2.0).is_empty());
    }

    #[test]
    fn numbers_tell_ticks_apart() {
        assert_eq!(tick_text(0.05, 0.05, 1.0), "0.05");
        assert_eq!(tick_text(1.1780974, 2e-7, 1.2), "1.1780974");
        assert_eq!(tick_text(-2e-10, 2e-10, 5e-10), "-2e-10");
        assert_eq!(tick_text(2.5e7, 2.5e6, 3e7), "2.5e7");
        assert_eq!(tick_text(-1e-30, 0.5, 1.0), "0");
    }

    #[test]
    fn short_numbers_hide_rounding() {
        for (v, text) in [
            (0.1 + 0.2, "0.3"),
            (0.0, "0"),
            (-1234.5678, "-1234.57"),
            (1e-9, "1e-9"),
            (6.02214076e23, "6.02214e23"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(short(v), text);
        }
        for (v, digits, text) in [
            (9.99961, 4, "10"),
            (0.72194, 4, "0.7219"),
            (123456.7, 3, "123457"),
            (-2.4e-4, 1, "-2e-4"),
        ] {
            assert_eq!(rounded(v, digits), text);
        }
    }
}
