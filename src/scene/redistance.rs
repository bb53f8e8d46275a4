//! Redistancing according to the scene.

use super::Scene;
use super::schema::Redistance as Keys;
use crate::levelset::{Redistance, Redistancing};
use crate::sim::{Carried, When};
use crate::transport::Method;

/// Change of the slope on the interface of a vesicle after which it is redistanced.
const EVEN: f64 = 0.03;

/// The redistancing of a scene: that of its keys, or the default for sharp forces.
fn keys(scene: &Scene) -> Option<Keys> {
    let numerics = &scene.numerics;
    let of_default = || {
        let sharp = scene.acting().any(|s| s.traits().keeps_distance());
        // Bending sees errors of the curvature, which a level set with an even slope has least.
        let bends = scene.acting().any(|s| s.traits().keeps_size);
        let keys = if bends { Keys { slope: Some(EVEN), ..Keys::DEFAULT } } else { Keys::DEFAULT };
        (sharp && numerics.transport != Method::Composed).then_some(keys)
    };
    numerics.redistance.or_else(of_default)
}

/// Redistances the level sets according to the scene.
pub(super) fn redistance<const D: usize>(scene: &Scene, carried: &mut Carried<D>) {
    let Some(r) = keys(scene) else { return };
    if let Some(method) = r.scheme() {
        carried.redistance_when(r.when(), Redistancing { method, volume: r.volume });
    }
}

/// The redistancing in words, for the plan.
pub(super) fn in_words(scene: &Scene) -> Option<String> {
    let r = keys(scene)?;
    let method = match r.scheme()? {
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
    let (which, when) = match r.when() {
        When::Every(1) => ("level sets", "after every step".into()),
        When::Every(every) => ("level sets", format!("after every {every} steps")),
        When::Slope(change) => (
            "level sets of sharp forces",
            format!("when the slope on the interface changes by {change}"),
        ),
    };
    let derived = if scene.numerics.redistance.is_some() { "" } else { " (derived)" };
    let volume = if r.volume { "; a constant keeps what the interface encloses" } else { "" };
    Some(format!(
        "{which} redistanced {when}{derived}: {method}{volume}; this displaces the interface a \
         little each time, and sharp forces put it back"
    ))
}
