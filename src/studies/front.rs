//! Pareto front of cost and error: the runs that no other run beats in both.

/// A price and an error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Offer {
    /// Its cost.
    pub cost: f64,
    /// The error; NaN for a run that failed.
    pub error: f64,
}

impl Offer {
    fn counts(&self) -> bool {
        self.cost.is_finite() && self.error.is_finite()
    }
}

/// Numbers of the offers that no other one beats: each that costs less has a larger error. From
/// cheap to dear.
pub fn front(offers: &[Offer]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..offers.len()).filter(|&i| offers[i].counts()).collect();
    order.sort_by(|&i, &j| {
        let (a, b) = (offers[i], offers[j]);
        a.cost.total_cmp(&b.cost).then(a.error.total_cmp(&b.error))
    });
    let mut least = f64::INFINITY;
    order.retain(|&i| {
        let better = offers[i].error < least;
        least = least.min(offers[i].error);
        better
    });
    order
}

/// The cheapest offer with an error of at most `tolerance`, or else the one with the least error.
pub fn cheapest(offers: &[Offer], tolerance: f64) -> Option<Result<usize, usize>> {
    let front = front(offers);
    let within = front.iter().find(|&&i| offers[i].error <= tolerance);
    within.map(|&i| Ok(i)).or(front.last().map(|&i| Err(i)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn offers(pairs: &[(f64, f64)]) -> Vec<Offer> {
        pairs.iter().map(|&(cost, error)| Offer { cost, error }).collect()
    }

    #[test]
    fn what_costs_more_and_errs_more_is_not_on_the_front() {
        let all = offers(&[
            (3.0, 0.1),
            (1.0, 0.5),
            (2.0, 0.6),
            (4.0, 0.1),
            (f64::NAN, 0.0),
            (0.5, f64::NAN),
            (1.0, 0.4),
        ]);
        assert_eq!(front(&all), [6, 0]);
        assert_eq!(cheapest(&all, 0.45), Some(Ok(6)));
        assert_eq!(cheapest(&all, 0.1), Some(Ok(0)));
        assert_eq!(cheapest(&all, 0.01), Some(Err(0)));
        assert_eq!(cheapest(&all[4..6], 1.0), None, "nothing but failures");
    }

    proptest! {
        #[test]
        fn every_offer_is_beaten_or_matched_by_the_front(pairs in prop::collection::vec((0.1..9.0f64, 0.1..9.0f64), 1..30)) {
            let all = offers(&pairs);
            let best = front(&all);
            for o in &all {
                prop_assert!(best.iter().any(|&i| all[i].cost <= o.cost && all[i].error <= o.error));
            }
            for w in best.windows(2) {
                prop_assert!(all[w[0]].cost <= all[w[1]].cost && all[w[0]].error > all[w[1]].error);
            }
        }
    }
}
