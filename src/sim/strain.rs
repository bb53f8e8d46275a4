//! Strain of interfaces, and the determinant of the backward characteristics.

use super::carried::Carried;
use crate::fem::{At, Basis, Cells, Rule, SurfacePoint, integrate};
use crate::levelset::Bounds;
use crate::mesh::determinant;
use crate::structure::{Fields, SurfaceStrain, rest_displacement};
use nalgebra::{SMatrix, SVector};
use std::borrow::Cow;
use std::sync::Arc;

/// Degree of the rule for the determinant of `grad Y`, whose square is of degree 6 in space.
const DEGREE: usize = 6;

impl<const D: usize> Carried<D> {
    /// The displacement `Y(x) - x` at the nodes to the position at rest of the material of
    /// structure number `k`; a passive interface is at rest at time 0. Empty where backward
    /// characteristics are not carried.
    pub fn rest_displacement<'a>(
        &self,
        fields: &'a Fields<D>,
        k: usize,
    ) -> Cow<'a, [SVector<f64, D>]> {
        let displacement = fields.displacement();
        match self.structures.get(k).and_then(|s| s.rest_map()) {
            Some(map) if !displacement.is_empty() => {
                Cow::Owned(rest_displacement(map, self.space.nodes(), displacement))
            }
            _ => Cow::Borrowed(displacement),
        }
    }
    /// Root mean square of `det grad Y - 1` over the domain, (5.21) of the paper, (3.68) of the
    /// book: zero in a divergence-free flow.
    pub fn determinant_error(&self, fields: &Fields<D>) -> f64 {
        let basis = Basis::new(&self.space, &Arc::new(Rule::simplex(D, DEGREE)));
        let displacement = fields.displacement();
        let [sum] =
            integrate(&basis, Cells::All, |at| [excess(&basis.jacobian(at, displacement)).powi(2)]);
        (sum / self.space.mesh().volume()).sqrt()
    }
    /// The same over an interface, given by its quadrature points.
    pub fn determinant_error_on(&self, fields: &Fields<D>, interface: &[SurfacePoint<D>]) -> f64 {
        let (mut sums, displacement) = ([0.0; 2], fields.displacement());
        for p in interface {
            let (cell, l) = (p.at.cell, &p.at.barycentric);
            let error = excess(&self.space.jacobian(displacement, cell, l));
            sums = [sums[0] + p.at.weight * error * error, sums[1] + p.at.weight];
        }
        (sums[0] / sums[1]).sqrt()
    }
    /// Strain of the interface of structure number `k` at points on it, relative to its state at
    /// rest; for a passive interface relative to time 0.
    pub fn surface_strain(
        &self,
        fields: &Fields<D>,
        k: usize,
        points: &[SurfacePoint<D>],
    ) -> Vec<SurfaceStrain<D>> {
        let (phi, rest) = (self.level_set(fields, k), self.rest_displacement(fields, k));
        let at = |p: &SurfacePoint<D>| {
            let carried = self.structures[k].strain_at(&self.space, fields, p);
            carried
                .unwrap_or_else(|| self.strain_at(k, (&phi, &rest), p.at.cell, &p.at.barycentric))
        };
        points.iter().map(at).collect()
    }
    /// Area and shear, `Z1` and `Z2`, of the level sets of structure number `k` at the nodes, means
    /// over the cells of each node; 1 farther than `reach` (a length) from the interface.
    pub fn nodal_strain(&self, fields: &Fields<D>, k: usize, reach: f64) -> [Vec<f64>; 2] {
        let (phi, rest) = (self.level_set(fields, k), self.rest_displacement(fields, k));
        let mut sums = vec![[0.0; 3]; self.space.len()];
        for c in 0..self.space.mesh().cell_count() {
            let bounds = Bounds::of_cell(&self.space, &phi, c);
            if !bounds.meet(reach * bounds.slope) {
                continue;
            }
            let volume = self.space.mesh().map(c).volume;
            for (a, &n) in self.space.cell_nodes(c).iter().enumerate() {
                let l = self.space.element().node(a, D);
                let normal = self.space.gradient(&phi, c, &l).normalize();
                let x = self.space.nodes()[n as usize];
                let at = At { cell: c, q: 0, barycentric: l, x, weight: 0.0 };
                let carried =
                    self.structures[k].strain_at(&self.space, fields, &SurfacePoint { at, normal });
                let s = carried.unwrap_or_else(|| self.strain_at(k, (&phi, &rest), c, &l));
                if s.z1.is_finite() && s.z2.is_finite() {
                    let [z1, z2, sum] = &mut sums[n as usize];
                    (*z1, *z2, *sum) = (*z1 + volume * s.z1, *z2 + volume * s.z2, *sum + volume);
                }
            }
        }
        let mean =
            |k: usize| sums.iter().map(|s| if s[2] > 0.0 { s[k] / s[2] } else { 1.0 }).collect();
        [mean(0), mean(1)]
    }
    /// Strain of the level set `phi` of structure number `k` at a location in the mesh.
    fn strain_at(
        &self,
        k: usize,
        (phi, rest): (&[f64], &[SVector<f64, D>]),
        cell: usize,
        l: &[f64; 4],
    ) -> SurfaceStrain<D> {
        let slope = self.space.gradient(phi, cell, l);
        let gradient = self.space.jacobian(rest, cell, l);
        self.structures[k].strain(&slope, &gradient)
    }
}

/// `det(I + gradient) - 1`.
fn excess<const D: usize>(gradient: &SMatrix<f64, D, D>) -> f64 {
    determinant(&(SMatrix::identity() + gradient)) - 1.0
}
