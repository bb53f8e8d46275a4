//! Transport along characteristics (semi-Lagrangian).
//!
//! `d_t f + u . grad f = 0` is solved by `f(x, t + dt) = f(X(x), t)`, where `X(x)` is the foot at
//! time `t` of the characteristic that arrives at `x` at `t + dt` (book, section 2.1.1; FreeFEM's
//! `convect`).

mod drift;
mod feet;
mod map;
mod passage;

pub use feet::{AdvectingVelocity, Feet, Tracer, path};
pub use map::CharacteristicMap;

use crate::base::Result;
use crate::fem::{At, Projector, Space};
use nalgebra::SVector;

/// Method that maps a transported scalar field back to its space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Values at the feet of the nodes: the book's `convect`. Each step costs one interpolation.
    Nodal,
    /// L2 projection of the values at the feet of the quadrature points (Lagrange-Galerkin; Douglas
    /// and Russell 1982).
    Projected,
    /// The initial function at the backward map, a chain of P2 submaps ([`CharacteristicMap`]): the
    /// field itself is never interpolated.
    Composed,
}

/// `f o X` at the nodes; `feet` belong to the nodes.
pub fn carry_nodal<const D: usize>(space: &Space<D>, f: &[f64], feet: &Feet, out: &mut [f64]) {
    crate::base::parallel::fill(out, 1, |first, part| {
        for (i, v) in part.iter_mut().enumerate() {
            let foot = feet.get(first + i);
            *v = space.value(f, foot.cell as usize, &foot.barycentric);
        }
    });
}

/// L2 projection of `f o X`; `feet` belong to the quadrature points of the projector's basis.
pub fn carry_projected<const D: usize>(
    projector: &mut Projector<D>,
    f: &[f64],
    feet: &Feet,
    out: &mut [f64],
) -> Result<()> {
    let space = projector.basis().space().clone();
    let points = projector.basis().rule().len();
    projector.project(
        |at| {
            let foot = feet.get(at.cell * points + at.q);
            space.value(f, foot.cell as usize, &foot.barycentric)
        },
        out,
    )
}

/// The displacement `Y(x) - x` of the backward characteristics one step later: its value at the
/// foot plus the step back to it. `feet` belong to the nodes.
pub fn carry_displacement_nodal<const D: usize>(
    tracer: &Tracer<D>,
    d: &[SVector<f64, D>],
    feet: &Feet,
    out: &mut [SVector<f64, D>],
) {
    let space = tracer.space();
    crate::base::parallel::fill(out, 1, |first, part| {
        for (i, v) in part.iter_mut().enumerate() {
            let (foot, start) = (feet.get(first + i), space.nodes()[first + i]);
            let way = tracer.unwrapped(space.mesh().point_at(foot) - start);
            *v = way + space.value(d, foot.cell as usize, &foot.barycentric);
        }
    });
}

/// The same by L2 projection; `feet` belong to the quadrature points of the projector's basis.
pub fn carry_displacement_projected<const D: usize>(
    tracer: &Tracer<D>,
    projector: &mut Projector<D>,
    d: &[SVector<f64, D>],
    feet: &Feet,
    out: &mut [SVector<f64, D>],
) -> Result<()> {
    let space = projector.basis().space().clone();
    let points = projector.basis().rule().len();
    let mut component = vec![0.0; out.len()];
    for k in 0..D {
        let value = |at: &At<D>| {
            let foot = feet.get(at.cell * points + at.q);
            let way = tracer.unwrapped(space.mesh().point_at(foot) - at.x);
            way[k] + space.value(d, foot.cell as usize, &foot.barycentric)[k]
        };
        projector.project(value, &mut component)?;
        out.iter_mut().zip(&component).for_each(|(v, c)| v[k] = *c);
    }
    Ok(())
}
