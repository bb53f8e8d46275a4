//! The membrane with area and shear resistance: the forces F1 and F2 of (5.15), (3.47), on a band,
//! explicit or implicit in the velocity.

use super::band_cells::{Band, BandCells, BandPoint, BandWidth};
use super::surface_law::{SurfaceLaw, Tangent};
use super::waves::explicit_step_limit;
use crate::base::{Cause, Result};
use crate::fem::{At, Basis, Cells, VectorForm};
use crate::flow::term::{MomentumTerm, Support};
use crate::levelset::{Kernel, Norm};
use crate::structure::{
    Coupling, Declaration, FieldId, Host, ImmersedInterface, InterfaceForce, Medium, Place,
    RestMap, SurfaceStrain, rest_displacement,
};
use nalgebra::{ArrayStorage, Matrix2, SMatrix, SVector};
use std::borrow::Cow;
use std::sync::Arc;

/// Source of the area change `Z1`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AreaFrom {
    /// `|grad phi|`: (8.1) of the paper, (3.42), in a divergence-free flow and for a level set that
    /// starts as a distance times the area stretch. The level set is smoother than the three
    /// components of `Y`, and its response to the force is closer to the derivative of the energy:
    /// spurious energy is 4.8 % from the slope and 24 % from the map (sheared sphere, 12 x 12 x 12
    /// cubes, `eps` = 1.5 edges, t = 1.2).
    Slope,
    /// `sqrt(det A)` of the map, (4.5), (3.40).
    Map,
}

/// Tension and stiffness of a membrane at a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Strained<const D: usize> {
    /// Weight per area at rest; zero outside the band.
    pub w: f64,
    pub strain: SurfaceStrain<D>,
    /// The tension, in the basis of the tangent plane.
    tension: Matrix2<f64>,
    /// Positive semi-definite stiffnesses out of the plane and in it; zero without implicit
    /// coupling.
    stiffness: (Matrix2<f64>, SMatrix<f64, 4, 4>),
}

impl<const D: usize> Strained<D> {
    const NOTHING: Strained<D> = Strained {
        w: 0.0,
        strain: SurfaceStrain::NOTHING,
        tension: Matrix2::new(0.0, 0.0, 0.0, 0.0),
        stiffness: (
            Matrix2::new(0.0, 0.0, 0.0, 0.0),
            SMatrix::from_array_storage(ArrayStorage([[0.0; 4]; 4])),
        ),
    };
    /// The point with weight `w` per area at rest.
    pub fn new(law: SurfaceLaw, strain: SurfaceStrain<D>, w: f64, implicit: bool) -> Strained<D> {
        let tangent = Tangent::new(law, &strain);
        let stiffness = if implicit { tangent.clamped() } else { Self::NOTHING.stiffness };
        Strained { w, strain, tension: tangent.tension, stiffness }
    }
    /// `- T w`, tested with `grad v`.
    pub fn force(&self) -> SMatrix<f64, D, D> {
        self.strain.in_space(&self.tension) * -self.w
    }
    /// Largest stiffness of waves along the membrane, per area.
    pub fn stiffest(&self, law: SurfaceLaw) -> f64 {
        Tangent::new(law, &self.strain).wave_stiffnesses()[1] * self.w
    }
    /// `K[grad u, .] w`, tested with `grad v`.
    pub fn stiffness(&self, grad_u: &SMatrix<f64, D, D>) -> SMatrix<f64, D, D> {
        let (n, [s, t]) = (&self.strain.normal, &self.strain.tangents);
        let (along_s, along_t) = (grad_u * s, grad_u * t);
        let out = self.stiffness.0 * SVector::<f64, 2>::new(n.dot(&along_s), n.dot(&along_t));
        let a = SVector::<f64, 4>::new(
            s.dot(&along_s),
            s.dot(&along_t),
            t.dot(&along_s),
            t.dot(&along_t),
        );
        let inside = self.stiffness.1 * a;
        let (column_s, column_t) = (
            s * inside[0] + t * inside[2] + n * out[0],
            s * inside[1] + t * inside[3] + n * out[1],
        );
        (column_s * s.transpose() + column_t * t.transpose()) * self.w
    }
}

/// Largest wave stiffnesses at some points, normal and tangential to the membrane, per area at rest;
/// 0 without any.
pub(super) fn wave_stiffnesses<'a, const D: usize>(
    law: SurfaceLaw,
    points: impl Iterator<Item = &'a Strained<D>>,
) -> [f64; 2] {
    let inside = points.filter(|b| b.w > 0.0);
    let stiffnesses = inside.map(|b| Tangent::new(law, &b.strain).wave_stiffnesses());
    stiffnesses.fold([0.0; 2], |most, s| [most[0].max(s[0]), most[1].max(s[1])])
}

/// The first of [`wave_stiffnesses`], the largest principal tension.
pub(super) fn largest_tension<'a, const D: usize>(
    points: impl Iterator<Item = &'a Strained<D>>,
) -> f64 {
    let inside = points.filter(|b| b.w > 0.0);
    inside.map(|b| b.tension.symmetric_eigenvalues().max()).fold(0.0, f64::max)
}

/// An elastic membrane on the zero level of `phi` that resists area change and shear, smeared over
/// a band.
///
/// The energy is (5.13), (3.45), `int W(Z1, Z2) w` with `w = zeta(phi/eps)/eps` (renormalised:
/// `zeta(phi/(r eps))/(r eps)`, `r = |grad phi|`), an integral over the area at rest as `r` is the
/// area stretch. The force is the divergence part of (5.15) integrated weakly,
/// `F(v) = - int T : grad v w`, `T = W_1 Z1 C1 + W_2 Z2 C2`; the gradient in (5.15) goes into the
/// pressure. `Z1` and `Z2` come from [`SurfaceStrain`], that is from derivatives of `Y` along the
/// level sets of `phi`.
///
/// Implicit in the velocity, the form `C(u, v) = dt int K[grad u, grad v] w` is added to the
/// matrix, `K` being the second variation of `W` ([`Tangent`]) with its negative eigenvalues set to
/// zero, point by point: symmetric, positive semi-definite, and at least as stiff as the membrane.
#[derive(Clone)]
pub struct ShearMembrane<const D: usize> {
    law: SurfaceLaw,
    width: BandWidth,
    /// Area stretch at time 0 in addition to that of the map.
    stretch: f64,
    /// `Y` at time 0; `None` for the identity.
    map: Option<Arc<RestMap<D>>>,
    area_from: AreaFrom,
    band: BandCells<Strained<D>>,
    implicit_step: Option<f64>,
    /// Field of the displacement of the backward characteristics.
    displacement: FieldId,
}

impl<const D: usize> ShearMembrane<D> {
    /// A membrane at rest at time 0 up to an isotropic area stretch, on a renormalised band of
    /// half-width `thickness` (a length).
    pub fn new(law: SurfaceLaw, thickness: f64, stretch: f64) -> ShearMembrane<D> {
        ShearMembrane {
            law,
            width: BandWidth::new(thickness),
            stretch,
            map: None,
            area_from: AreaFrom::Slope,
            band: BandCells::default(),
            implicit_step: None,
            displacement: FieldId::default(),
        }
    }
    /// The same membrane with the material position at rest given by `map`.
    pub fn with_map(self, map: Arc<RestMap<D>>) -> ShearMembrane<D> {
        ShearMembrane { map: Some(map), ..self }
    }
    /// The same membrane with another source of `Z1`.
    pub fn with_area_from(self, area_from: AreaFrom) -> ShearMembrane<D> {
        ShearMembrane { area_from, ..self }
    }
    /// The same membrane over another band; `slope` is that of the level set at time 0.
    pub fn with_band(self, band: Band, slope: f64) -> ShearMembrane<D> {
        ShearMembrane { width: self.width.with_band(band, slope), ..self }
    }
    /// The same membrane over a band with another cut-off function; `norm` is that of the local
    /// slope of a renormalised one.
    pub fn with_kernel(self, kernel: Kernel, norm: Norm) -> ShearMembrane<D> {
        ShearMembrane { width: self.width.with_kernel(kernel, norm), ..self }
    }
    /// `Y` at time 0; `None` for the identity.
    pub fn map(&self) -> Option<&RestMap<D>> {
        self.map.as_deref()
    }
    /// The displacement `Y(x) - x` at the nodes to the position at rest, from the displacement back
    /// to time 0.
    fn rest<'a>(
        &self,
        nodes: &[SVector<f64, D>],
        displacement: &'a [SVector<f64, D>],
    ) -> Cow<'a, [SVector<f64, D>]> {
        let Some(map) = self.map() else { return Cow::Borrowed(displacement) };
        Cow::Owned(rest_displacement(map, nodes, displacement))
    }
    /// Precomputes the force on the band of `phi`; `rest` is the displacement `Y(x) - x` to the
    /// position at rest, one vector per node. `basis` must have the rule of the flow. With
    /// `implicit_step`, a time step, the stiffness enters the matrix.
    pub fn prepare(
        &mut self,
        basis: &Basis<D>,
        phi: &[f64],
        rest: &[SVector<f64, D>],
        implicit_step: Option<f64>,
    ) {
        self.implicit_step = implicit_step;
        let (law, how) = (self.law, (self.stretch, self.area_from));
        self.band.prepare(&self.width, basis, phi, Strained::NOTHING, |c, q, b| {
            if b.w == 0.0 {
                return Strained::NOTHING;
            }
            let strain = strain_at(basis, c, q, b, rest, how);
            Strained::new(law, strain, b.w, implicit_step.is_some())
        });
    }
    /// Elastic energy (5.13) on `phi` with the displacement `rest`. `basis` may have a finer rule
    /// than the flow's.
    pub fn energy(&self, basis: &Basis<D>, phi: &[f64], rest: &[SVector<f64, D>]) -> f64 {
        self.width.integrate(basis, phi, |c, q, b| {
            if b.w == 0.0 {
                return 0.0;
            }
            let strain = strain_at(basis, c, q, b, rest, (self.stretch, self.area_from));
            self.law.response(strain.z1, strain.z2).energy
        })
    }
    /// The strain where the level set has the gradient `slope` and the displacement `Y(x) - x` the
    /// gradient `gradient`.
    pub fn strain(
        &self,
        slope: &SVector<f64, D>,
        gradient: &SMatrix<f64, D, D>,
    ) -> SurfaceStrain<D> {
        let r = slope.norm();
        strain(&(slope / r), r, gradient, (self.stretch, self.area_from))
    }
    /// Largest wave stiffnesses in the prepared band, normal and tangential to the membrane, per
    /// area at rest; 0 without any.
    pub fn wave_stiffnesses(&self) -> [f64; 2] {
        wave_stiffnesses(self.law, self.band.values().iter())
    }
    /// Largest stable step of the explicit coupling: the smaller of (1.54) with the tension, for
    /// normal waves as in [`explicit_step_limit`], and of (1.54) with the stiffness of tangential
    /// waves and `dx = h/2`, the distance of P2 nodes: the fluid dragged along spreads these over
    /// more than the shortest wave of the mesh. This length is measured (user guide, "Stability"),
    /// not derived.
    pub fn step_limit(&self, medium: &Medium) -> f64 {
        step_limit(self.wave_stiffnesses(), self.width.thickness, medium)
    }
}

/// The limit (1.54) for the stiffnesses of normal and tangential waves, see
/// [`ShearMembrane::step_limit`].
pub(super) fn step_limit([tension, stiffness]: [f64; 2], thickness: f64, medium: &Medium) -> f64 {
    let spread = Medium { edge: medium.edge * 60f64.sqrt() / 4.0, ..*medium };
    let along = explicit_step_limit(&spread, thickness, stiffness);
    explicit_step_limit(medium, thickness, tension).min(along)
}

/// The strain at point `q` of cell `c`.
fn strain_at<const D: usize>(
    basis: &Basis<D>,
    c: usize,
    q: usize,
    b: &BandPoint<D>,
    rest: &[SVector<f64, D>],
    how: (f64, AreaFrom),
) -> SurfaceStrain<D> {
    let own = basis.space().on_cell(rest, c);
    let gradient =
        own.reference_jacobian(basis.reference_gradients(q)) * basis.space().mesh().map(c).inverse;
    strain(&b.n, b.r, &gradient, how)
}

/// The strain for the unit normal `n`, the slope `r` of the level set and the gradient `gradient`
/// of `Y(x) - x`.
fn strain<const D: usize>(
    n: &SVector<f64, D>,
    r: f64,
    gradient: &SMatrix<f64, D, D>,
    (stretch, area_from): (f64, AreaFrom),
) -> SurfaceStrain<D> {
    let strain = SurfaceStrain::new(n, &(SMatrix::identity() + gradient), stretch);
    match area_from {
        AreaFrom::Slope => SurfaceStrain { z1: r, ..strain },
        AreaFrom::Map => strain,
    }
}

impl<const D: usize> MomentumTerm<D> for ShearMembrane<D> {
    fn support(&self) -> Support<'_, D> {
        Support::Cells(Cells::Some(self.band.cells()))
    }
    fn force(&self, at: &At<D>) -> VectorForm<D> {
        let Some(b) = self.band.get(at).filter(|b| b.w > 0.0) else {
            return (SVector::zeros(), SMatrix::zeros());
        };
        (SVector::zeros(), b.force())
    }
    fn is_implicit(&self) -> bool {
        self.implicit_step.is_some()
    }
    fn stiffness(
        &self,
        at: &At<D>,
        _: &SVector<f64, D>,
        grad_u: &SMatrix<f64, D, D>,
    ) -> VectorForm<D> {
        let (Some(b), Some(dt)) = (self.band.get(at).filter(|b| b.w > 0.0), self.implicit_step)
        else {
            return (SVector::zeros(), SMatrix::zeros());
        };
        (SVector::zeros(), b.stiffness(grad_u) * dt)
    }
}

impl<const D: usize> InterfaceForce<D> for ShearMembrane<D> {
    fn begin(
        &mut self,
        _: &ImmersedInterface<D>,
        host: &Host<'_, D>,
        fields: &mut Declaration<'_, D>,
    ) -> Result<()> {
        self.width.begin(host);
        self.displacement = fields.backward_map(true);
        Ok(())
    }
    fn term(&self) -> Option<&dyn MomentumTerm<D>> {
        Some(self)
    }
    fn prepare(&mut self, of: &ImmersedInterface<D>, at: &Place<'_, D>) -> Result<()> {
        let implicit = at.step.filter(|_| of.coupling == Coupling::Implicit);
        let rest = self.rest(at.space.nodes(), at.fields.vector(self.displacement));
        ShearMembrane::prepare(self, at.basis, at.fields.scalar(of.level_set()), &rest, implicit);
        Ok(())
    }
    fn energy(
        &mut self,
        of: &ImmersedInterface<D>,
        at: &Place<'_, D>,
        rule: &Basis<D>,
    ) -> Result<f64> {
        let rest = self.rest(at.space.nodes(), at.fields.vector(self.displacement));
        Ok(ShearMembrane::energy(self, rule, at.fields.scalar(of.level_set()), &rest))
    }
    fn tension(&self) -> f64 {
        largest_tension(self.band.values().iter())
    }
    fn step_limit(&self, medium: &Medium) -> f64 {
        ShearMembrane::step_limit(self, medium)
    }
    fn check_coupling(&self, coupling: Coupling) -> Result<()> {
        coupling.refuse_semi_implicit(
            "the semi-implicit scheme (3.62)-(3.64) predicts the level set, which knows nothing \
             of shear",
            Cause::ShearForce,
        )
    }
    fn rest_map(&self) -> Option<&RestMap<D>> {
        self.map()
    }
    fn strain(
        &self,
        slope: &SVector<f64, D>,
        gradient: &SMatrix<f64, D, D>,
    ) -> Option<SurfaceStrain<D>> {
        Some(ShearMembrane::strain(self, slope, gradient))
    }
    fn resists_shear(&self) -> bool {
        true
    }
}
