//! `[numerics.redistance]`: redistancing of level sets.

use crate::base::Result;
use crate::levelset;
use crate::scene::keys::{
    Context, Count, Flag, Form, Kind, Opt, Positive, Table, kinds, table, words,
};
use crate::sim::When;

table! {
    /// Makes level sets the signed distance (times their stretch at the start) again, after a step.
    /// For interfaces whose slope means nothing: level sets that act on nothing, sharp forces and
    /// constant tension. It displaces the interface a little each time; sharp forces put it back.
    Redistance: Copy {
        /// By pseudo-time steps of the Hamilton-Jacobi equation (1.35) along its characteristics;
        /// by fast marching from node to node, of first order; or by the distance of each node from
        /// the zero set of the P2 function, of third. With "none" no level set is ever redistanced,
        /// not even that of a sharp force, which is lost then in a flow that drives it for long.
        method: Option<levelset::Redistance> [Methods,
            Required("write method = \"exact\", \"fast-marching\", \"hamilton-jacobi\" or \
                \"none\"")],
        /// Pseudo-time steps with hamilton-jacobi: the slope is straightened up to about this many
        /// distances of nodes, half edges, from the interface.
        iterations: Option<usize> [Opt<Count<1, 10_000>>, Derived("5 with hamilton-jacobi")],
        /// Steps from one redistancing to the next.
        every: Option<usize> [Opt<Steps>, Derived("1, where `slope` is not given")],
        /// In place of `every`: the relative change of the slope on an interface after which it is
        /// redistanced.
        slope: Option<f64> [Opt<Positive>],
        /// Whether a constant is added then, with which the cut interface encloses what it did
        /// before.
        volume: bool [Flag, Default(false)],
    } check Redistance::check;
}

words! {
    Methods: Option<levelset::Redistance> {
        "hamilton-jacobi" = Some(levelset::Redistance::HamiltonJacobi { iterations: ITERATIONS }),
        "fast-marching" = Some(levelset::Redistance::FastMarching),
        "exact" = Some(levelset::Redistance::Exact),
        "none" = None,
    }
}
kinds! {
    /// A number of time steps.
    Steps: usize = Kind::Value("whole number from 1", Form::Whole([1, MOST_STEPS])), |i, _| i.count(1, MOST_STEPS);
}
const ITERATIONS: usize = 5;
const MOST_STEPS: usize = 1_000_000_000;

/// Change of the slope on the interface after which level sets of sharp forces are redistanced.
const SLOPE: f64 = 0.2;

impl Redistance {
    /// That of sharp forces, where the scene says nothing.
    pub const DEFAULT: Redistance = Redistance {
        method: Some(levelset::Redistance::Exact),
        iterations: None,
        every: None,
        slope: Some(SLOPE),
        volume: false,
    };

    /// The method with its iterations; `None` if level sets are never redistanced.
    pub fn scheme(&self) -> Option<levelset::Redistance> {
        match (self.method?, self.iterations) {
            (levelset::Redistance::HamiltonJacobi { .. }, Some(iterations)) => {
                Some(levelset::Redistance::HamiltonJacobi { iterations })
            }
            (method, _) => Some(method),
        }
    }
    /// When it is done.
    pub fn when(&self) -> When {
        match self.slope {
            Some(change) => When::Slope(change),
            None => When::Every(self.every.unwrap_or(1) as u64),
        }
    }

    fn check(&mut self, table: &Table<'_>, _: &Context) -> Result<()> {
        if let (Some(_), Some(item)) = (self.every, table.get("slope")) {
            return Err(item
                .key_error("`every` and `slope` both say when level sets are redistanced")
                .remedy("keep one of the two"));
        }
        if self.slope.is_none() {
            self.every.get_or_insert(1);
        }
        if let Some(levelset::Redistance::HamiltonJacobi { iterations }) = self.method {
            self.iterations.get_or_insert(iterations);
            return Ok(());
        }
        table.get("iterations").map_or(Ok(()), |item| {
            Err(item
                .key_error("only the Hamilton-Jacobi equation is iterated")
                .remedy("leave iterations out, or take method = \"hamilton-jacobi\""))
        })
    }
}
