//! Order, limit and error bar of a sequence of values on finer and finer levels.

/// A value on levels of falling size; a level that gave none has NaN.
#[derive(Clone, Debug, PartialEq)]
pub struct Sequence {
    /// Mesh size, step or thickness of each level, falling.
    pub sizes: Vec<f64>,
    /// The value on each level.
    pub values: Vec<f64>,
}

/// Limit of a quantity and its error bar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// The value at size zero.
    pub value: f64,
    /// Its error bar, by the rule in [`Basis`].
    pub bar: f64,
    /// Basis of both.
    pub basis: Basis,
}

/// Derivation of a limit and its bar from the finest levels, the last being `v`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Basis {
    /// Extrapolated from the two finest levels with a whole (or the given) order; the bar is the
    /// distance from the same extrapolation one level earlier and, where the order was not given,
    /// from that with the observed order if it is larger.
    Whole(f64),
    /// Extrapolated from the three finest levels with the order observed on them, which is no whole
    /// one; the bar is all that the extrapolation adds to `v`.
    Observed(f64),
    /// `v` itself, as no order is seen; the bar is the spread of the three finest values.
    Spread,
}

/// Orders below this say that nothing converges, those above the second that two errors cancel.
const CREDIBLE: [f64; 2] = [0.3, 6.0];
/// An observed order this close to a whole one is taken for it.
pub(super) const WHOLE: f64 = 0.25;
/// Changes below this part of a value are rounding.
const ROUNDING: f64 = 1e-12;

impl Sequence {
    /// The levels that gave a value.
    fn finished(&self) -> Vec<(usize, f64, f64)> {
        let all = self.sizes.iter().zip(&self.values).enumerate();
        all.filter(|(_, (h, v))| h.is_finite() && v.is_finite())
            .map(|(k, (h, v))| (k, *h, *v))
            .collect()
    }

    /// The change of the value from the level before, a level; NaN where there is none.
    pub fn changes(&self) -> Vec<f64> {
        let mut changes = vec![f64::NAN; self.values.len()];
        for pair in self.finished().windows(2) {
            changes[pair[1].0] = pair[1].2 - pair[0].2;
        }
        changes
    }

    /// The order seen on each level and the two before; NaN where none is credible.
    ///
    /// It is the `p` of `v(h) = v + C h^p` through the three values: `(v_1 - v_0)/(v_2 - v_1) =
    /// (h_0^p - h_1^p)/(h_1^p - h_2^p)`, which for halved sizes is `p = log2((v_1 - v_0)/(v_2 -
    /// v_1))`.
    pub fn orders(&self) -> Vec<f64> {
        let mut orders = vec![f64::NAN; self.values.len()];
        for three in self.finished().windows(3) {
            let [(_, a, u), (_, b, v), (k, c, w)] = *three else { continue };
            if (w - v).abs() > ROUNDING * w.abs() {
                orders[k] = order_of_changes([a, b, c], [v - u, w - v]);
            }
        }
        orders
    }

    /// The limit of the values and its error bar; `None` with fewer than three levels or where
    /// nothing converges.
    ///
    /// With `known`, the order that theory gives, extrapolation is with that one, provided that
    /// some order is seen.
    pub fn limit(&self, known: Option<f64>) -> Option<Limit> {
        let levels = self.finished();
        let [.., (_, a, u), (_, b, v), (last, c, w)] = levels[..] else { return None };
        let seen = self.orders()[last];
        if seen.is_nan() {
            let [before, after] = [v - u, w - v];
            let quiet = after.abs() <= ROUNDING * w.abs();
            let settles = (before * after < 0.0 && after.abs() <= before.abs())
                || too_fast([a, b, c], [before, after]);
            let spread = u.max(v).max(w) - u.min(v).min(w);
            return (quiet || settles).then_some(Limit {
                value: w,
                bar: spread,
                basis: Basis::Spread,
            });
        }
        let whole = known.unwrap_or(seen.round());
        if known.is_some() || (whole >= 1.0 && (seen - whole).abs() <= WHOLE) {
            let (value, before) =
                (extrapolated([b, c], [v, w], whole), extrapolated([a, b], [u, v], whole));
            // An order that is taken for a whole one may yet be what it looks like.
            let as_seen = if known.is_some() { value } else { extrapolated([b, c], [v, w], seen) };
            let bar = (value - before).abs().max((value - as_seen).abs());
            return Some(Limit { value, bar, basis: Basis::Whole(whole) });
        }
        let value = extrapolated([b, c], [v, w], seen);
        Some(Limit { value, bar: (value - w).abs(), basis: Basis::Observed(seen) })
    }
}

/// The order of errors that tend to zero, a level and the one before; NaN where there is none.
pub fn orders_of_errors(sizes: &[f64], errors: &[f64]) -> Vec<f64> {
    let mut orders = vec![f64::NAN; errors.len()];
    for k in 1..errors.len().min(sizes.len()) {
        let order = (errors[k - 1] / errors[k]).ln() / (sizes[k - 1] / sizes[k]).ln();
        if order.is_finite() {
            orders[k] = order;
        }
    }
    orders
}

/// The order of changes between levels, such as distances, `changes[k]` being that from level `k -
/// 1` to `k`; NaN where none is credible.
pub fn orders_of_changes(sizes: &[f64], changes: &[f64]) -> Vec<f64> {
    let mut orders = vec![f64::NAN; changes.len()];
    for k in 2..changes.len().min(sizes.len()) {
        orders[k] =
            order_of_changes([sizes[k - 2], sizes[k - 1], sizes[k]], [changes[k - 1], changes[k]]);
    }
    orders
}

/// `v + C h^p` through two values, at zero.
fn extrapolated([a, b]: [f64; 2], [v, w]: [f64; 2], order: f64) -> f64 {
    w + (w - v) / ((a / b).powf(order) - 1.0)
}

/// The ratio of successive changes of `C h^p`.
fn ratio([a, b, c]: [f64; 3], p: f64) -> f64 {
    (a.powf(p) - b.powf(p)) / (b.powf(p) - c.powf(p))
}

/// True for changes of one sign that fall faster than any credible order.
fn too_fast(sizes: [f64; 3], [before, after]: [f64; 2]) -> bool {
    before / after >= ratio(sizes, CREDIBLE[1])
}

/// The order that makes two changes between three levels; the ratio grows with it.
fn order_of_changes(sizes: [f64; 3], [before, after]: [f64; 2]) -> f64 {
    let sizes = sizes.map(|h| h / sizes[0]);
    let wanted = before / after;
    let [mut low, mut high] = CREDIBLE;
    if !(ratio(sizes, low) <= wanted && wanted <= ratio(sizes, high)) {
        return f64::NAN;
    }
    while high - low > 1e-12 {
        let middle = 0.5 * (low + high);
        if ratio(sizes, middle) < wanted { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn sequence(sizes: &[f64], value: impl Fn(f64) -> f64) -> Sequence {
        Sequence { sizes: sizes.to_vec(), values: sizes.iter().map(|&h| value(h)).collect() }
    }

    proptest! {
        #[test]
        fn the_order_and_the_limit_of_a_power_are_found(
            p in 0.4f64..5.0, c in 0.1f64..3.0, limit in -2.0f64..2.0, r in 0.4f64..0.8, s in 0.4f64..0.8
        ) {
            // Mesh files refine by ratios of their own.
            let q = sequence(&[0.3, 0.3 * r, 0.3 * r * s], |h| limit + c * h.powf(p));
            prop_assert!((q.orders()[2] - p).abs() < 1e-6, "{:?}", q.orders());
            let found = q.limit(None).unwrap();
            prop_assert!((found.value - limit).abs() <= found.bar + 1e-12);
            let known = q.limit(Some(p)).unwrap();
            prop_assert!((known.value - limit).abs() < 1e-8 && known.bar < 1e-8);
        }
        #[test]
        fn the_bar_holds_the_error_of_the_next_term(c in -0.2f64..0.2) {
            let q = sequence(&[0.4, 0.2, 0.1, 0.05], |h| 1.0 + h * h + c * h.powi(3));
            let limit = q.limit(None).unwrap();
            prop_assert_eq!(limit.basis, Basis::Whole(2.0));
            prop_assert!((limit.value - 1.0).abs() <= limit.bar + 1e-12);
        }
    }

    #[test]
    fn halves_and_wholes() {
        let q = sequence(&[0.4, 0.2, 0.1], |h| 3.0 + h.powf(1.5));
        let limit = q.limit(None).unwrap();
        assert!(matches!(limit.basis, Basis::Observed(p) if (p - 1.5).abs() < 1e-9));
        assert!((limit.value - 3.0).abs() < 1e-9 && (limit.bar - 0.1f64.powf(1.5)).abs() < 1e-9);
        let q = sequence(&[0.4, 0.2, 0.1], |h| 3.0 + h * h + 0.1 * h.powi(3));
        let limit = q.limit(None).unwrap();
        assert_eq!(limit.basis, Basis::Whole(2.0));
        assert!((limit.value - 3.0).abs() < limit.bar && limit.bar < 1e-3, "{limit:?}");
    }

    #[test]
    fn no_order_is_made_up() {
        let values = |v: [f64; 3]| Sequence { sizes: vec![0.4, 0.2, 0.1], values: v.to_vec() };
        // Oscillating and settling: the finest value and the spread.
        let q = values([1.0, 1.3, 1.2]);
        assert!(q.orders().iter().all(|p| p.is_nan()));
        let limit = q.limit(Some(2.0)).unwrap();
        assert_eq!((limit.value, limit.basis), (1.2, Basis::Spread));
        assert!((limit.bar - 0.3).abs() < 1e-12);
        // Growing changes, of one sign or not, and changes that do not fall: nothing is said.
        for v in [[1.0, 1.1, 1.4], [1.0, 1.1, 0.8], [1.0, 1.1, 1.19], [f64::NAN, 1.0, 1.1]] {
            assert_eq!(values(v).limit(None), None, "{v:?}");
            assert!(values(v).orders()[2].is_nan());
        }
        // No change at all, and one that falls as no method does.
        assert_eq!(values([2.0, 2.0, 2.0]).limit(None).unwrap().bar, 0.0);
        assert_eq!(values([2.0, 2.1, 2.1001]).limit(None).unwrap().basis, Basis::Spread);
    }

    #[test]
    fn a_level_that_failed_is_left_out() {
        let sizes = vec![0.8, 0.4, 0.2, 0.1];
        let q = Sequence { sizes, values: vec![f64::NAN, 1.16, 1.04, 1.01] };
        assert!(q.changes()[1].is_nan() && (q.changes()[2] + 0.12).abs() < 1e-12);
        assert!((q.orders()[3] - 2.0).abs() < 1e-9);
    }

    #[test]
    fn errors_and_distances_have_orders() {
        let sizes = [0.4, 0.2, 0.1];
        let orders = orders_of_errors(&sizes, &[0.64, 0.08, 0.01]);
        assert!(
            orders[0].is_nan()
                && (orders[1] - 3.0).abs() < 1e-12
                && (orders[2] - 3.0).abs() < 1e-12
        );
        let orders = orders_of_changes(&sizes, &[f64::NAN, 0.12, 0.03]);
        assert!((orders[2] - 2.0).abs() < 1e-9 && orders[1].is_nan());
    }
}
