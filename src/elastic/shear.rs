//! The membrane with full elasticity: the forces F1 and F2 of (5.15), (3.47), on a band, explicit or implicit in the velocity.

use super::band_cells::{Band, BandCells, BandPoint, BandWidth};
use super::surface_law::{SurfaceLaw, Tangent};
use super::surface_strain::{SurfaceStrain, in_space};
use crate::fem::{At, Basis, Cells, VectorForm};
use crate::flow::term::MomentumTerm;
use crate::mesh::Point;
use nalgebra::{Matrix2, SMatrix, SVector};
use std::sync::Arc;

/// Where the material that is at a point at time 0 is at rest: `Y` at time 0.
pub type RestMap<const D: usize> = dyn Fn(&Point<D>) -> Point<D> + Send + Sync;

/// What a point of the band knows.
#[derive(Clone, Copy, Debug)]
struct Strained<const D: usize> {
    /// Weight per area at rest; zero outside the band.
    w: f64,
    normal: SVector<f64, D>,
    tangents: [SVector<f64, D>; 2],
    /// The tension, in the basis of the tangent plane.
    tension: Matrix2<f64>,
    /// Positive semi-definite stiffnesses out of the plane and in it; zero without implicit coupling.
    stiffness: (Matrix2<f64>, SMatrix<f64, 4, 4>),
}

/// An elastic membrane on the zero level of `phi` that resists area change and shear, smeared over a band.
///
/// The energy is (5.13), (3.45), `int W(Z1, Z2) w` with `w = zeta(phi/eps)/eps` (renormalised: `zeta(phi/(r eps))/(r eps)`, `r = |grad phi|`),
/// an integral over the area at rest as `r` is the area stretch. The force is the divergence part of (5.15) integrated
/// weakly, `F(v) = - int T : grad v w`, `T = W_1 Z1 C1 + W_2 Z2 C2`; the gradient in (5.15) goes into the pressure.
/// `Z1` and `Z2` come from [`SurfaceStrain`], that is from derivatives of `Y` along the level sets of `phi`.
///
/// Implicit in the velocity, the form `C(u, v) = dt int K[grad u, grad v] w` is added to the matrix, `K` being the second variation of `W`
/// ([`Tangent`]) with its negative eigenvalues set to zero, point by point: symmetric, positive semi-definite, and at least as stiff as the
/// membrane.
#[derive(Clone)]
pub struct ShearMembrane<const D: usize> {
    law: SurfaceLaw,
    width: BandWidth,
    /// Area stretch at time 0 beside that of the map.
    stretch: f64,
    /// `Y` at time 0; `None` for the identity.
    map: Option<Arc<RestMap<D>>>,
    /// Whether `Z1` is the slope of the level set.
    by_slope: bool,
    band: BandCells<Strained<D>>,
    implicit_step: Option<f64>,
}

impl<const D: usize> ShearMembrane<D> {
    /// A membrane at rest at time 0 but for an area stretch in all directions, on a renormalised band of half-width `thickness` (a length).
    pub fn new(law: SurfaceLaw, thickness: f64, stretch: f64) -> ShearMembrane<D> {
        ShearMembrane {
            law,
            width: BandWidth::new(thickness),
            stretch,
            map: None,
            by_slope: false,
            band: BandCells::default(),
            implicit_step: None,
        }
    }
    /// The same membrane with the material at places that `map` gives when at rest.
    pub fn with_map(self, map: Arc<RestMap<D>>) -> ShearMembrane<D> {
        ShearMembrane { map: Some(map), ..self }
    }
    /// The same membrane with `Z1 = |grad phi|`, (8.1) of the paper with `J = 1` for a level set that starts as a distance times the area stretch.
    pub fn with_area_by_slope(self) -> ShearMembrane<D> {
        ShearMembrane { by_slope: true, ..self }
    }
    /// The same membrane over another band; `slope` is that of the level set at the start.
    pub fn with_band(self, band: Band, slope: f64) -> ShearMembrane<D> {
        ShearMembrane { width: self.width.with_band(band, slope), ..self }
    }
    /// The law.
    pub fn law(&self) -> SurfaceLaw {
        self.law
    }
    /// `Y` at time 0; `None` for the identity.
    pub fn map(&self) -> Option<&RestMap<D>> {
        self.map.as_deref()
    }
    /// Half-width of the band.
    pub fn thickness(&self) -> f64 {
        self.width.thickness
    }
    /// Takes stock of the band of `phi`, where the material has the displacement `rest` back to its place at rest (`Y(x) - x`, one vector a
    /// node). `basis` must have the rule of the flow. With `implicit_step`, a time step, the stiffness goes into the matrix.
    pub fn prepare(&mut self, basis: &Basis<D>, phi: &[f64], rest: &[SVector<f64, D>], implicit_step: Option<f64>) {
        self.implicit_step = implicit_step;
        let nothing = Strained {
            w: 0.0,
            normal: SVector::zeros(),
            tangents: [SVector::zeros(); 2],
            tension: Matrix2::zeros(),
            stiffness: (Matrix2::zeros(), SMatrix::zeros()),
        };
        let (law, stretch, by_slope) = (self.law, self.stretch, self.by_slope);
        self.band.prepare(&self.width, basis, phi, nothing, |c, q, b| {
            if b.w == 0.0 {
                return nothing;
            }
            let strain = strain_at(basis, c, q, b, rest, stretch, by_slope);
            let tangent = Tangent::new(law, &strain);
            Strained {
                w: b.w,
                normal: b.n,
                tangents: strain.tangents,
                tension: tangent.tension,
                stiffness: if implicit_step.is_some() { tangent.clamped() } else { nothing.stiffness },
            }
        });
    }
    /// Elastic energy (5.13) on `phi` with the displacement `rest`. `basis` may have a finer rule than the flow's.
    pub fn energy(&self, basis: &Basis<D>, phi: &[f64], rest: &[SVector<f64, D>]) -> f64 {
        self.width.integrate(basis, phi, |c, q, b| {
            if b.w == 0.0 {
                return 0.0;
            }
            let strain = strain_at(basis, c, q, b, rest, self.stretch, self.by_slope);
            self.law.response(strain.z1, strain.z2).energy
        })
    }
    /// The strain where the unit normal is `n` and the gradient of the displacement `Y(x) - x` is `gradient`.
    pub fn strain(&self, n: &SVector<f64, D>, gradient: &SMatrix<f64, D, D>) -> SurfaceStrain<D> {
        SurfaceStrain::new(n, &(SMatrix::identity() + gradient), self.stretch)
    }
    /// Largest tension in the band that was prepared last, per length of membrane at rest; 0 when nothing is under tension.
    pub fn largest_tension(&self) -> f64 {
        let tensions = self.band.values().iter().filter(|b| b.w > 0.0).map(|b| b.tension.symmetric_eigenvalues().max());
        tensions.fold(0.0, f64::max)
    }
}

/// The strain at point `q` of cell `c`.
fn strain_at<const D: usize>(
    basis: &Basis<D>,
    c: usize,
    q: usize,
    b: &BandPoint<D>,
    rest: &[SVector<f64, D>],
    stretch: f64,
    by_slope: bool,
) -> SurfaceStrain<D> {
    let own = basis.space().on_cell(rest, c);
    let gradient = own.reference_jacobian(basis.reference_gradients(q)) * basis.space().mesh().map(c).inverse;
    let mut strain = SurfaceStrain::new(&b.n, &(SMatrix::identity() + gradient), stretch);
    if by_slope {
        strain.z1 = b.r;
    }
    strain
}

impl<const D: usize> MomentumTerm<D> for ShearMembrane<D> {
    fn cells(&self) -> Cells<'_> {
        Cells::Some(self.band.cells())
    }
    fn force(&self, at: &At<D>) -> VectorForm<D> {
        let Some(b) = self.band.get(at).filter(|b| b.w > 0.0) else { return (SVector::zeros(), SMatrix::zeros()) };
        (SVector::zeros(), in_space(&b.tangents, &b.tension) * -b.w)
    }
    fn is_implicit(&self) -> bool {
        self.implicit_step.is_some()
    }
    fn stiffness(&self, at: &At<D>, grad_u: &SMatrix<f64, D, D>) -> SMatrix<f64, D, D> {
        let (Some(b), Some(dt)) = (self.band.get(at).filter(|b| b.w > 0.0), self.implicit_step) else {
            return SMatrix::zeros();
        };
        let (n, [s, t]) = (&b.normal, &b.tangents);
        let (along_s, along_t) = (grad_u * s, grad_u * t);
        let out = b.stiffness.0 * SVector::<f64, 2>::new(n.dot(&along_s), n.dot(&along_t));
        let a = SVector::<f64, 4>::new(s.dot(&along_s), s.dot(&along_t), t.dot(&along_s), t.dot(&along_t));
        let inside = b.stiffness.1 * a;
        let (column_s, column_t) =
            (s * inside[0] + t * inside[2] + n * out[0], s * inside[1] + t * inside[3] + n * out[1]);
        (column_s * s.transpose() + column_t * t.transpose()) * (dt * b.w)
    }
}
