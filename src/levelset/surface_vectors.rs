//! Vectors on a cut interface, projected onto P2 functions: curvature, normals, divergences.

use crate::base::Result;
use crate::fem::{Space, SurfaceMass, SurfacePoint};
use nalgebra::{SMatrix, SVector};

/// The curvature vector `H n` of an interface at the nodes of the cells that it cuts, NaN
/// elsewhere: `int_S h . v = int_S P : grad v` for all P2 functions `v`, which is minus the Laplacian
/// of the position (G. Dziuk, An algorithm for evolutionary surfaces, Numer. Math. 58, 1991). `H` is
/// the sum of the principal curvatures, positive on spheres. It sees nothing of the level set `phi`
/// but its zero.
///
/// `points` are those of [`surface`](super::surface); `unknowns` has one number per node, equal for
/// nodes that periodic sides identify.
///
/// # Errors
/// A matrix that cannot be factored.
pub fn curvature_vector<const D: usize>(
    (space, unknowns): (&Space<D>, &[u32]),
    (points, phi): (&[SurfacePoint<D>], &[f64]),
) -> Result<Vec<SVector<f64, D>>> {
    project(
        (space, unknowns),
        (points, phi),
        |_| 0.0,
        |mass, loads| {
            for p in points {
                mass.deposit_divergence(space, p, &-p.projection(), loads);
            }
        },
    )
}

/// The normals of an interface, projected onto P2 functions in the same way.
///
/// # Errors
/// A matrix that cannot be factored.
pub fn normal_vector<const D: usize>(
    (space, unknowns): (&Space<D>, &[u32]),
    (points, phi): (&[SurfacePoint<D>], &[f64]),
) -> Result<Vec<SVector<f64, D>>> {
    project(
        (space, unknowns),
        (points, phi),
        |_| 0.0,
        |mass, loads| {
            for (p, i) in points.iter().flat_map(|p| (0..D).map(move |i| (p, i))) {
                let at = (p.at.cell, &p.at.barycentric);
                mass.deposit(space, at, p.at.weight * p.normal[i], &mut loads[i]);
            }
        },
    )
}

/// The second fundamental form `grad_S n` at a point, of normals at the nodes: symmetric,
/// tangential.
pub fn second_form<const D: usize>(
    space: &Space<D>,
    normals: &[SVector<f64, D>],
    p: &SurfacePoint<D>,
) -> SMatrix<f64, D, D> {
    let tangential = p.projection();
    let gradient = space.jacobian(normals, p.at.cell, &p.at.barycentric);
    let form = tangential * gradient * tangential;
    (form + form.transpose()) * 0.5
}

/// The tangential divergence `P div_S T` of a tensor on the interface of `points`, the zero of `phi`,
/// at the nodes of cut cells; NaN elsewhere. `tensor` is tangential, and `diffusivity` smooths the
/// result along the interface (an area). `unknowns` has one number per node, equal for nodes that
/// periodic sides identify.
///
/// # Errors
/// A matrix that cannot be factored.
pub fn surface_divergence<const D: usize>(
    (space, unknowns): (&Space<D>, &[u32]),
    (points, phi): (&[SurfacePoint<D>], &[f64]),
    tensor: impl Fn(&SurfacePoint<D>) -> SMatrix<f64, D, D>,
    diffusivity: impl Fn(&SurfacePoint<D>) -> f64,
) -> Result<Vec<SVector<f64, D>>> {
    let mut divergence = project((space, unknowns), (points, phi), diffusivity, |mass, loads| {
        points.iter().for_each(|p| mass.deposit_divergence(space, p, &tensor(p), loads));
    })?;
    let mut slopes = vec![SVector::<f64, D>::zeros(); space.len()];
    for group in points.chunk_by(|a, b| a.at.cell == b.at.cell) {
        let c = group[0].at.cell;
        for (k, &n) in space.cell_nodes(c).iter().enumerate() {
            let slope = space.gradient(phi, c, &space.element().node(k, D));
            slopes[n as usize] += slope * space.mesh().map(c).volume;
        }
    }
    for (d, slope) in divergence.iter_mut().zip(&slopes) {
        if let Some(n) = slope.try_normalize(0.0) {
            *d -= n * n.dot(d);
        }
    }
    Ok(divergence)
}

/// The vectors whose components have the right-hand sides that `load` makes, smoothed along the
/// interface by `diffusivity` (an area); NaN beside the cut cells.
fn project<const D: usize>(
    (space, unknowns): (&Space<D>, &[u32]),
    (points, phi): (&[SurfacePoint<D>], &[f64]),
    diffusivity: impl Fn(&SurfacePoint<D>) -> f64,
    load: impl Fn(&SurfaceMass, &mut [Vec<f64>; D]),
) -> Result<Vec<SVector<f64, D>>> {
    let mut vectors = vec![SVector::repeat(f64::NAN); space.len()];
    let Some(mut mass) = SurfaceMass::new(space, unknowns, points)? else { return Ok(vectors) };
    mass.diffuse(space, (points, phi), diffusivity)?;
    let mut loads: [Vec<f64>; D] = std::array::from_fn(|_| mass.load());
    load(&mass, &mut loads);
    let mut component = vec![f64::NAN; space.len()];
    for (i, load) in loads.iter().enumerate() {
        mass.solve(load, &mut component)?;
        vectors.iter_mut().zip(&component).for_each(|(v, c)| v[i] = *c);
    }
    Ok(vectors)
}
