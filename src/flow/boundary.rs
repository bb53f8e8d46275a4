//! Integrals over named boundaries: force by the stress, and flux.

use super::coefficient::Coefficient;
use super::step::FlowState;
use crate::base::Result;
use crate::fem::{Rule, Space};
use crate::mesh::{Facet, Mesh};
use nalgebra::SVector;

/// Degree of the rule on facets.
const DEGREE: usize = 5;

/// Sum over the facets of a named boundary and their quadrature points of `f(facet, barycentric, weight * size)`.
fn over_boundary<const D: usize>(mesh: &Mesh<D>, name: &str, mut f: impl FnMut(&Facet, &[f64; 4], f64)) -> Result<()> {
    let rule = Rule::simplex(D - 1, DEGREE);
    for &k in mesh.boundary(name)? {
        let facet = mesh.facets()[k as usize];
        let (_, size) = mesh.facet_normal(&facet);
        for (point, w) in rule.points.iter().zip(&rule.weights) {
            let mut l = [0.0; 4];
            let mut next = point.iter();
            for (i, v) in l.iter_mut().enumerate().take(D + 1) {
                if i as u32 != facet.opposite {
                    *v = *next.next().unwrap_or(&0.0);
                }
            }
            f(&facet, &l, w * size);
        }
    }
    Ok(())
}

/// Force of the fluid on a boundary by the stress, `-int (2 mu D(u) - p) n ds` with `n` outward from the fluid, for a constant
/// viscosity (a pointwise one is taken at the first quadrature point of the cell).
pub fn traction<const D: usize>(
    velocity: &Space<D>,
    pressure: &Space<D>,
    viscosity: &Coefficient,
    state: &FlowState<D>,
    name: &str,
) -> Result<SVector<f64, D>> {
    let mesh = velocity.mesh();
    let mut force = SVector::<f64, D>::zeros();
    over_boundary(mesh, name, |facet, l, w| {
        let c = facet.cell as usize;
        let (n, _) = mesh.facet_normal(facet);
        let grad = velocity.jacobian(&state.u, c, l);
        let p = pressure.value(&state.p, c, l);
        let mu = match viscosity {
            Coefficient::Constant(mu) => *mu,
            Coefficient::Pointwise { points, values } => values[c * points],
        };
        force += ((grad + grad.transpose()) * n * mu - n * p) * (-w);
    })?;
    Ok(force)
}

/// Volume that leaves through a boundary per time, `int u . n ds`.
pub fn flux<const D: usize>(velocity: &Space<D>, state: &FlowState<D>, name: &str) -> Result<f64> {
    let mesh = velocity.mesh();
    let mut sum = 0.0;
    over_boundary(mesh, name, |facet, l, w| {
        let (n, _) = mesh.facet_normal(facet);
        sum += w * velocity.value(&state.u, facet.cell as usize, l).dot(&n);
    })?;
    Ok(sum)
}
