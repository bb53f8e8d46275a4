//! Surface tension as a force per volume.

use super::area_law::AreaLaw;
use super::band_cells::{Band, BandCells, BandWidth};
use super::waves::explicit_step_limit;
use crate::base::Result;
use crate::fem::{At, Basis, Cells, Recovery, VectorForm};
use crate::flow::term::{MomentumTerm, Support};
use crate::levelset::{Curvature, Kernel, Norm};
use crate::mesh::Mesh;
use crate::structure::{Declaration, Host, ImmersedInterface, InterfaceForce, Medium, Place};
use nalgebra::{SMatrix, SVector};
use std::sync::Arc;

/// Surface tension on the zero level of `phi` as a continuum surface force (Brackbill, Kothe and
/// Zemach 1992; book, (1.32)).
///
/// `F(v) = - int lambda H w grad phi . v`, with `w |grad phi|` the surface delta of the band,
/// `H = div n` the curvature (1.9), positive on a sphere, and `n` outward. (1.32) is printed with
/// the opposite sign and with the density as a factor: the jump of the normal stress is `lambda H`
/// for any densities.
///
/// The curvature is computed at the points of the mesh from recovered second derivatives of `phi`
/// ([`Curvature`]), and interpolated linearly. It is bounded by `2 (D - 1)` over the longest edge
/// of a cell.
///
/// Limits: explicit in time, below (1.54). The force is not the derivative of an energy on the
/// mesh, and between two close interfaces the recovery mixes their curvatures.
#[derive(Clone, Debug)]
pub struct ContinuumForce<const D: usize> {
    /// `lambda`, force per length.
    tension: f64,
    width: BandWidth,
    band: BandCells<SVector<f64, D>>,
    /// With its mesh.
    recovery: Option<(Arc<Mesh<D>>, Recovery<D>)>,
}

impl<const D: usize> ContinuumForce<D> {
    /// The force of this surface tension over a renormalised band of half-width `thickness`.
    pub fn new(tension: f64, thickness: f64) -> ContinuumForce<D> {
        ContinuumForce {
            tension,
            width: BandWidth::new(thickness),
            band: BandCells::default(),
            recovery: None,
        }
    }
    /// The same force over another band; `slope` is that of the level set at time 0.
    pub fn with_band(self, band: Band, slope: f64) -> ContinuumForce<D> {
        ContinuumForce { width: self.width.with_band(band, slope), ..self }
    }
    /// The same force over a band with another cut-off function and norm.
    pub fn with_kernel(self, kernel: Kernel, norm: Norm) -> ContinuumForce<D> {
        ContinuumForce { width: self.width.with_kernel(kernel, norm), ..self }
    }
    /// Precomputes the force on the band of `phi`, a function of the space of `basis`, which must
    /// have the rule of the flow.
    pub fn prepare(&mut self, basis: &Basis<D>, phi: &[f64]) {
        let (space, tension, width) = (basis.space(), self.tension, self.width.clone());
        let mesh = space.mesh();
        let recovery = match self.recovery.take() {
            Some((of, recovery)) if Arc::ptr_eq(&of, mesh) => recovery,
            _ => Recovery::new(mesh),
        };
        let of_cell = |&c: &u32| mesh.cell(c as usize);
        let mut vertices: Vec<u32> =
            width.with_cells(basis, phi, |near| near.iter().flat_map(of_cell).copied().collect());
        vertices.sort_unstable();
        vertices.dedup();
        let curvature = Curvature::new(&recovery, space, phi, &vertices);
        self.recovery = Some((Arc::clone(mesh), recovery));
        self.band.prepare(&width, basis, phi, SVector::zeros(), |c, q, b| {
            // A mesh cannot represent a curvature above about the inverse of its edges; where the
            // gradient nearly vanishes, on the medial axis, the computed value is arbitrary.
            let limit = 2.0 * (D - 1) as f64 / mesh.diameter(c);
            let h = curvature.mean_at(mesh, c, &basis.rule().points[q]).clamp(-limit, limit);
            b.n * (-tension * h * b.w * b.r)
        });
    }
}

impl<const D: usize> MomentumTerm<D> for ContinuumForce<D> {
    fn support(&self) -> Support<'_, D> {
        Support::Cells(Cells::Some(self.band.cells()))
    }
    fn force(&self, at: &At<D>) -> VectorForm<D> {
        (self.band.get(at).copied().unwrap_or(SVector::zeros()), SMatrix::zeros())
    }
}

impl<const D: usize> InterfaceForce<D> for ContinuumForce<D> {
    fn begin(
        &mut self,
        _: &ImmersedInterface<D>,
        host: &Host<'_, D>,
        _: &mut Declaration<'_, D>,
    ) -> Result<()> {
        self.width.begin(host);
        Ok(())
    }
    fn term(&self) -> Option<&dyn MomentumTerm<D>> {
        Some(self)
    }
    fn prepare(&mut self, of: &ImmersedInterface<D>, at: &Place<'_, D>) -> Result<()> {
        ContinuumForce::prepare(self, at.basis, at.fields.scalar(of.level_set()));
        Ok(())
    }
    /// Surface energy `int lambda r w`, (3.12), over the band.
    fn energy(
        &mut self,
        of: &ImmersedInterface<D>,
        at: &Place<'_, D>,
        rule: &Basis<D>,
    ) -> Result<f64> {
        let law = AreaLaw::Tension { tension: self.tension };
        Ok(self.width.integrate(rule, at.fields.scalar(of.level_set()), |_, _, b| law.energy(b.r)))
    }
    fn conserves_energy(&self) -> bool {
        false
    }
    fn tension(&self) -> f64 {
        self.tension
    }
    fn step_limit(&self, medium: &Medium) -> f64 {
        explicit_step_limit(medium, self.width.thickness, self.tension)
    }
}
