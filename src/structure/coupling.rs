//! Coupling of a force with the time step.

use crate::base::{Cause, Error, Result};

/// Time level at which the force of a structure is taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Coupling {
    /// The force of the old (order 2: extrapolated) interface; stable below the limit (1.54).
    Explicit,
    /// The same with the interface also transported by the old velocity (remark 1.12): unstable for
    /// any step without viscosity. For demonstration.
    FullyExplicit,
    /// The force of an interface predicted by an implicit diffusion: the book's semi-implicit
    /// scheme (3.62)-(3.64).
    SemiImplicit,
    /// Linearised in the velocity of the new time level.
    #[default]
    Implicit,
}

impl Coupling {
    /// True if the step is bounded by (1.54) or less.
    pub fn is_explicit(self) -> bool {
        matches!(self, Coupling::Explicit | Coupling::FullyExplicit)
    }
    /// Checks that the coupling is possible in steps of order `order` with least density
    /// `lightest`.
    ///
    /// # Errors
    /// The fully explicit scheme at order 2; the semi-implicit scheme, which is of order 1 and
    /// whose predictor divides by the density, at order 2 or without inertia.
    pub fn check(self, order: usize, lightest: f64) -> Result<()> {
        if self == Coupling::FullyExplicit && order != 1 {
            return Err(Error::scene(
                "the fully explicit scheme of remark 1.12 is of order 1 in time",
            )
            .value(format!("order {order}"))
            .remedy("take steps of order 1, or explicit coupling")
            .because(Cause::FirstOrder));
        }
        let (what, value, remedy, cause) = if self != Coupling::SemiImplicit {
            return Ok(());
        } else if order != 1 {
            (
                "the semi-implicit scheme (3.62)-(3.64) is of order 1 in time",
                format!("order {order}"),
                "steps of order 1",
                Cause::FirstOrder,
            )
        } else if lightest <= 0.0 {
            (
                "the semi-implicit scheme (3.62)-(3.64) needs inertia: it predicts the velocity \
                 that the force gives to the fluid",
                format!("density {lightest}"),
                "densities above 0",
                Cause::Massless,
            )
        } else {
            return Ok(());
        };
        let remedy = format!("take {remedy}, or implicit coupling");
        Err(Error::scene(what).value(value).remedy(remedy).because(cause))
    }
    /// Refuses the semi-implicit scheme for a force that it is not made for: `what`, and its
    /// `cause`.
    pub fn refuse_semi_implicit(self, what: &str, cause: Cause) -> Result<()> {
        if self != Coupling::SemiImplicit {
            return Ok(());
        }
        let remedy = "take implicit or explicit coupling";
        Err(Error::scene(what).remedy(remedy).because(cause))
    }
}
