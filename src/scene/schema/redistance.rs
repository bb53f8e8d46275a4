//! `[numerics.redistance]`: level sets that become distances again.

use crate::base::Result;
use crate::levelset;
use crate::scene::keys::Item;
use crate::scene::keys::{Absent::*, Keys, Kind::*, row, words};
use crate::scene::keys::{Writer, name};

/// How and when level sets are redistanced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Redistance {
    /// How a distance is found.
    pub method: levelset::Redistance,
    /// Steps from one redistancing to the next.
    pub every: usize,
    /// Whether a constant gives back what an interface encloses.
    pub volume: bool,
}

const METHODS: [(&str, levelset::Redistance); 3] = [
    ("hamilton-jacobi", levelset::Redistance::HamiltonJacobi { iterations: ITERATIONS }),
    ("fast-marching", levelset::Redistance::FastMarching),
    ("exact", levelset::Redistance::Exact),
];
const METHOD_WORDS: [&str; METHODS.len()] = words(&METHODS);
const ITERATIONS: usize = 5;
const MOST_ITERATIONS: usize = 10_000;
const MOST_STEPS: usize = 1_000_000_000;

pub(in crate::scene) static KEYS: Keys = Keys {
    about: "Makes level sets the signed distance (times their stretch at the start) again, after a step. For interfaces whose slope means \
            nothing: level sets that act on nothing, and membranes of constant tension. It displaces the interface a little each time.",
    keys: &[
        row(
            "method",
            Choice(&METHOD_WORDS),
            "",
            Required,
            "By pseudo-time steps of the Hamilton-Jacobi equation (1.35) along its characteristics; by fast marching from node to node, of first \
             order; or by the distance of each node from the zero set of the P2 function, of third.",
        ),
        row(
            "iterations",
            Value("whole number from 1 to 10000"),
            "",
            Derived("5 with hamilton-jacobi"),
            "Pseudo-time steps with hamilton-jacobi: the slope is straightened up to about this many distances of nodes, half edges, from the interface.",
        ),
        row("every", Value("whole number from 1"), "", Default("1"), "Steps from one redistancing to the next."),
        row(
            "volume",
            Value("true or false"),
            "",
            Default("false"),
            "Whether a constant is added then, with which the cut interface encloses what it did before.",
        ),
    ],
};

impl Redistance {
    pub(in crate::scene) fn read(item: &Item) -> Result<Redistance> {
        let table = item.table(&KEYS)?;
        let remedy = "write method = \"exact\", \"fast-marching\" or \"hamilton-jacobi\"";
        let mut method = table.required("method", remedy, |i| i.choice(&METHODS))?;
        let given = table.optional("iterations", |i| i.count(1, MOST_ITERATIONS))?;
        match (&mut method, table.get("iterations")) {
            (levelset::Redistance::HamiltonJacobi { iterations }, _) => *iterations = given.unwrap_or(*iterations),
            (_, None) => {}
            (_, Some(item)) => {
                return Err(item
                    .key_error("only the Hamilton-Jacobi equation is iterated")
                    .remedy("leave iterations out, or take method = \"hamilton-jacobi\""));
            }
        }
        Ok(Redistance {
            method,
            every: table.optional("every", |i| i.count(1, MOST_STEPS))?.unwrap_or(1),
            volume: table.optional("volume", Item::boolean)?.unwrap_or(false),
        })
    }

    pub(in crate::scene) fn write(&self, out: &mut Writer) {
        out.header("[numerics.redistance]");
        match self.method {
            levelset::Redistance::HamiltonJacobi { iterations } => {
                let method = levelset::Redistance::HamiltonJacobi { iterations: ITERATIONS };
                out.entry("method", name(method, &METHODS));
                out.entry("iterations", iterations);
            }
            method => out.entry("method", name(method, &METHODS)),
        }
        out.entry("every", self.every);
        out.entry("volume", self.volume);
    }
}
