//! What a flow is told of while it runs.

use super::ImmersedFlow;
use crate::base::{Warning, rounded};
use crate::flow::ConvectionScheme;
use crate::mesh::Point;
use crate::scene::row::Row;

/// Courant number of a flow that is at rest but for rounding.
const AT_REST: f64 = 1e-3;
/// Estimated error of the velocity due to the steps that is told.
const HASTY: f64 = 0.01;
/// Speed inward through an open side over the largest in the flow that is told.
const SLOW: f64 = 0.02;

impl<const D: usize> ImmersedFlow<D> {
    /// A warning of steps that are too long for the flow, by a row of its series.
    pub(super) fn find_haste(&self, row: &Row) -> Option<Warning> {
        let error = row.get("time_error").filter(|e| *e > HASTY)?;
        let sim = &self.simulation;
        if sim.courant() < AT_REST {
            return None;
        }
        let what = format!(
            "the steps are long for this flow: at t = {:.4} they make an estimated error of {} % of \
             the velocity, at Courant number {}; forces may be off by more",
            sim.time(),
            rounded(100.0 * error, 2),
            rounded(sim.courant(), 2)
        );
        let shorter = match sim.settings().order {
            1 => "take time.order = 2",
            2 if self.scene.time.tolerance.is_some() => "take a smaller time.tolerance",
            2 => "half of time.step makes it a quarter",
            _ => "half of time.step makes it an eighth",
        };
        let remedy = match sim.settings().convection {
            Some(ConvectionScheme::Characteristics) => format!(
                "{shorter}; numerics.convection = \"baker1982\" makes no such error in steady flows"
            ),
            _ if sim.settings().order == 2 && self.scene.time.tolerance.is_none() => {
                format!("{shorter}, time.order = 3 about a tenth")
            }
            _ => shorter.into(),
        };
        Some(Warning::new(what, remedy))
    }
    /// The open side through which fluid comes in most quickly, with a warning; `None` where it is
    /// slow.
    pub(super) fn find_inflow(&self) -> Option<(String, Warning)> {
        let sim = &self.simulation;
        let fastest = sim.largest_speed();
        let quick = |(_, speed, _): &(&str, f64, Point<D>)| *speed > SLOW * fastest;
        let Some((side, speed, x)) = sim.inflow().filter(quick) else {
            let (side, speed, x) = sim.oblique_inflow().filter(quick)?;
            let what = format!(
                "fluid comes in obliquely through boundary.{side}, where a pressure is given, from \
                 t = {:.4} on: at {:.4?} with {} inward and along the side, the largest speed is {}",
                sim.time(),
                x.as_slice(),
                rounded(speed, 3),
                rounded(fastest, 3)
            );
            let remedy = "a pressure bounds no energy of what comes in: give total_pressure if the \
                          flow grows";
            return Some((side.to_string(), Warning::new(what, remedy)));
        };
        let what = format!(
            "fluid comes in through boundary.{side}, which is open, from t = {:.4} on: at {:.4?} with \
             {}, the largest speed is {}",
            sim.time(),
            x.as_slice(),
            rounded(speed, 3),
            rounded(fastest, 3)
        );
        let remedy = "what comes in is not known there, and a stress takes its energy back \
                      (directional do-nothing): put the side farther away if the flow near it counts, or give \
                      its total_pressure if a pressure is to drive it in";
        Some((side.to_string(), Warning::new(what, remedy)))
    }
}
