//! The predictor of the level set in the book's semi-implicit scheme.

use super::area_law::AreaLaw;
use crate::base::Result;
use crate::fem::{At, Basis, Projector, Translation};

/// Sub-step 1 of the semi-implicit scheme (3.62)-(3.64) (for constant tension (1.60)-(1.62); Cottet and Maitre 2016): where
/// the force of the coming step is taken.
///
/// The velocity of the coming step is guessed as `u^n + dt F/rho`, with the force of the interface where it will be. Along
/// the normal this force is `-E'(r) H r w`, with `H` the curvature and `w = zeta(phi/(r eps))/(r eps)`; in the transport
/// equation it makes `-dt u . grad phi = dt^2 E'(r) r^2 H w/rho`. The book keeps the derivatives of highest order of
/// `r H = lap phi - n . D^2 phi n`, drops the normal one and puts `zeta = 1` everywhere:
///
/// `(phi* - phi^n o X)/dt - (E'(|grad phi^n|) dt/(rho eps)) lap phi* = 0`,
///
/// where `X` are the feet of the characteristics of `u^n`, which stand for `- u^n . grad phi^n` as in the other schemes.
/// The flow is then solved with the force of `phi*` (3.63), and `phi^n` itself is carried by `u^{n+1}` (3.64): `phi*` is
/// nowhere but in the force. On the space of the level set, with the natural condition on the boundary:
///
/// `(m phi*, q) + (grad phi*, grad q) = (m phi^n o X, q)`, `m = rho eps/(dt^2 E')`,
///
/// symmetric although the diffusivity is outside the divergence. Where nothing is under tension (`E' <= 0`) nothing is diffused: `m`
/// is bounded by `1e6/h^2`.
///
/// Limits: of first order in time. Made for constant tension over a carried band, where the force needs `phi*` for its place and its normal
/// only; with an area law the stretch is diffused as well, and energy comes from nowhere at steps above the explicit limit
/// (ARCHITECTURE.md, "The book's semi-implicit scheme").
pub struct Predictor<const D: usize> {
    projector: Projector<D>,
    is_set: bool,
}

/// Largest `m h^2`: the diffusion that is left damps the shortest wave of the mesh by less than one part in ten thousand.
const LARGEST_MASS: f64 = 1e6;

impl<const D: usize> Predictor<D> {
    /// A predictor on the space and the rule of `basis`; no matrix is assembled yet.
    pub fn new(basis: Basis<D>, translations: &[Translation<D>]) -> Result<Predictor<D>> {
        Ok(Predictor { projector: Projector::without_form(basis, translations)?, is_set: false })
    }
    /// Turns `carried`, the level set `phi` of a membrane with this law and half-width of its band,
    /// carried over a step `dt`, into the predicted one. With a density that
    /// `is_constant` and constant tension the matrix is factored once; the arguments must then be those of the first call.
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
            if tension > 0.0 { (density(at) * eps / (dt * dt * tension)).min(largest) } else { largest }
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
