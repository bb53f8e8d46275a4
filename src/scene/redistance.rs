//! Redistancing according to the scene.

use super::script::Script;
use crate::levelset::{Redistance, Redistancing};
use crate::sim::Carried;

/// Redistances the level sets according to the scene.
pub(super) fn redistance<const D: usize>(script: &Script, carried: &mut Carried<D>) {
    if let Some(r) = script.numerics.redistance {
        carried.redistance_every(r.every, Redistancing { method: r.scheme(), volume: r.volume });
    }
}

/// The redistancing in words, for the plan.
pub(super) fn in_words(scene: &Script) -> Option<String> {
    let r = scene.numerics.redistance?;
    let method = match r.scheme() {
        Redistance::HamiltonJacobi { iterations } => {
            format!(
                "{iterations} pseudo-time steps of (1.35), straight up to about {iterations} half \
                 edges from the interface"
            )
        }
        Redistance::FastMarching => "fast marching, of first order away from the interface".into(),
        Redistance::Exact => {
            "the distance of each node from the zero set of the P2 function".into()
        }
    };
    let every = if r.every == 1 { "every step".into() } else { format!("every {} steps", r.every) };
    let volume = if r.volume { "; a constant keeps what the interface encloses" } else { "" };
    Some(format!(
        "level sets redistanced after {every}: {method}{volume}; this displaces the interface a \
         little each time"
    ))
}
