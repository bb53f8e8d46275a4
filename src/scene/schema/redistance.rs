//! `[numerics.redistance]`: redistancing of level sets.

use crate::base::Result;
use crate::levelset;
use crate::scene::keys::{Context, Count, Flag, Kind, Opt, Table, kinds, table, words};

table! {
    /// Makes level sets the signed distance (times their stretch at the start) again, after a step.
    /// For interfaces whose slope means nothing: level sets that act on nothing, and membranes of
    /// constant tension. It displaces the interface a little each time.
    Redistance: Copy, Eq {
        /// By pseudo-time steps of the Hamilton-Jacobi equation (1.35) along its characteristics;
        /// by fast marching from node to node, of first order; or by the distance of each node from
        /// the zero set of the P2 function, of third.
        method: levelset::Redistance [Methods,
            Required("write method = \"exact\", \"fast-marching\" or \"hamilton-jacobi\"")],
        /// Pseudo-time steps with hamilton-jacobi: the slope is straightened up to about this many
        /// distances of nodes, half edges, from the interface.
        iterations: Option<usize> [Opt<Count<1, 10_000>>, Derived("5 with hamilton-jacobi")],
        /// Steps from one redistancing to the next.
        every: usize [Steps, Default(1)],
        /// Whether a constant is added then, with which the cut interface encloses what it did
        /// before.
        volume: bool [Flag, Default(false)],
    } check Redistance::check;
}

words! {
    Methods: levelset::Redistance {
        "hamilton-jacobi" = levelset::Redistance::HamiltonJacobi { iterations: ITERATIONS },
        "fast-marching" = levelset::Redistance::FastMarching,
        "exact" = levelset::Redistance::Exact,
    }
}
kinds! {
    /// A number of time steps.
    Steps: usize = Kind::Value("whole number from 1"), |i, _| i.count(1, MOST_STEPS);
}
const ITERATIONS: usize = 5;
const MOST_STEPS: usize = 1_000_000_000;

impl Redistance {
    /// The method with its iterations.
    pub fn scheme(&self) -> levelset::Redistance {
        match (self.method, self.iterations) {
            (levelset::Redistance::HamiltonJacobi { .. }, Some(iterations)) => {
                levelset::Redistance::HamiltonJacobi { iterations }
            }
            (method, _) => method,
        }
    }

    fn check(&mut self, table: &Table<'_>, _: &Context) -> Result<()> {
        if let levelset::Redistance::HamiltonJacobi { iterations } = self.method {
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
