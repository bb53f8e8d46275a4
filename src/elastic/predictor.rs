//! The predictor of the level set in the book's semi-implicit scheme.

use super::area_law::AreaLaw;
use crate::base::Result;
use crate::fem::{At, Basis, Projector, Translation};

/// Sub-step 1 of the semi-implicit scheme (3.62)-(3.64) (for constant tension (1.60)-(1.62); Cottet
/// and Maitre 2016): predicts the level set at which the force of the step is taken.
///
/// The velocity of the step is estimated as `u^n + dt F/rho`, with the force at the predicted
/// interface. Its normal part is `-E'(r) H r w`, with `H` the curvature and
/// `w = zeta(phi/(r eps))/(r eps)`; in the transport equation it gives
/// `-dt u . grad phi = dt^2 E'(r) r^2 H w/rho`. The book keeps the derivatives of highest order of
/// `r H = lap phi - n . D^2 phi n`, omits the normal one and sets `zeta = 1` everywhere:
///
/// `(phi* - phi^n o X)/dt - (E'(|grad phi^n|) dt/(rho eps)) lap phi* = 0`,
///
/// where `X` are the feet of the characteristics of `u^n`, in place of `- u^n . grad phi^n`, as in
/// the other schemes. The flow is then solved with the force of `phi*` (3.63), and `phi^n` itself
/// is transported by `u^{n+1}` (3.64): `phi*` enters the force only. On the space of the level set,
/// with the natural boundary condition:
///
/// `(m phi*, q) + (grad phi*, grad q) = (m phi^n o X, q)`, `m = rho eps/(dt^2 E')`,
///
/// symmetric although the diffusivity is outside the divergence. Without tension (`E' <= 0`) there
/// is no diffusion: `m` is bounded by `1e6/h^2`.
///
/// Limits: of first order in time. Suited to constant tension over a carried band, where the force
/// uses only position and normal of `phi*`. With an area law the stretch is diffused as well, and
/// spurious energy is produced at steps above the explicit limit (user guide, "Coupling").
pub struct Predictor<const D: usize> {
    projector: Projector<D>,
    is_set: bool,
}

/// Largest `m h^2`: the remaining diffusion damps the shortest wave of the mesh by less than 1e-4.
const LARGEST_MASS: f64 = 1e6;

impl<const D: usize> Predictor<D> {
    /// A predictor on the space and the rule of `basis`; no matrix is assembled yet.
    pub fn new(basis: Basis<D>, translations: &[Translation<D>]) -> Result<Predictor<D>> {
        Ok(Predictor { projector: Projector::without_form(basis, translations)?, is_set: false })
    }
    /// Replaces `carried`, the level set `phi` of a membrane with this law and half-width,
    /// transported over a step `dt`, by the predicted one. If the density `is_constant` and the
    /// tension is constant, the matrix is factored once; the arguments must then be those of the
    /// first call.
    pub fn predict(
        &mut self,
        (law, eps): (AreaLaw, f64),
        dt: f64,
        (density, is_constant): (impl Fn(&At<D>) -> f64 + Sync, bool),
        phi: &[f64],
        carried: &mut [f64],
    ) -> Result<()> {
        let basis = self.projector.basis().clone();
        let mass = |at: &At<D>| {
            let tension = law.tension(basis.gradient(at, phi).norm());
            let largest = LARGEST_MASS / basis.space().mesh().diameter(at.cell).powi(2);
            if tension > 0.0 {
                (density(at) * eps / (dt * dt * tension)).min(largest)
            } else {
                largest
            }
        };
        if !(self.is_set && is_constant && matches!(law, AreaLaw::Tension { .. })) {
            self.projector.set_form(|at| (mass(at), 1.0))?;
            self.is_set = true;
        }
        let source = carried.to_vec();
        self.projector.project(|at| mass(at) * basis.value(at, &source), carried)
    }
    /// Bytes held by the factor.
    pub fn bytes(&self) -> usize {
        self.projector.bytes()
    }
}
