//! Strain of a surface from the backward characteristics `Y`: change of area and shear.

use nalgebra::{ArrayStorage, Matrix2, SMatrix, SVector, Vector3};

/// The deformation of a surface at a point, from the unit normal `n` and `grad Y` (row `i`, column
/// `j` is `d Y_i / d x_j`).
///
/// The surface tensor of the book is (3.38), the paper's (4.3), `A = B - (B n)(B n)/(B n . n)` with
/// `B = (grad Y)^-1 (grad Y)^-T` (3.37). It maps the tangent plane to itself and is there the
/// inverse of the metric `G = (grad Y)^T (grad Y)`: the Schur complement of a block is the inverse
/// of that block of the inverse. So `A` follows from tangential derivatives of `Y`, without
/// inverting `grad Y`, and errors of `Y` across the surface do not enter.
///
/// In the plane, a curve is treated as the cylinder over it, without stretch along its generators.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceStrain<const D: usize> {
    /// Unit normal.
    pub normal: SVector<f64, D>,
    /// Orthonormal basis of the tangent plane; in the plane the second is zero, as it points out of
    /// it.
    pub tangents: [SVector<f64, D>; 2],
    /// `A` in that basis.
    pub a: Matrix2<f64>,
    /// `Z1` (3.40): area over area at rest.
    pub z1: f64,
    /// `Z2` (3.41): the shear, 1 where there is none.
    pub z2: f64,
}

impl<const D: usize> SurfaceStrain<D> {
    const ZERO: SVector<f64, D> =
        SVector::<f64, D>::from_array_storage(ArrayStorage([[0.0; D]; 1]));
    /// The zero of all components, outside a surface.
    pub(crate) const NOTHING: SurfaceStrain<D> = SurfaceStrain {
        normal: Self::ZERO,
        tangents: [Self::ZERO; 2],
        a: Matrix2::new(0.0, 0.0, 0.0, 0.0),
        z1: 0.0,
        z2: 0.0,
    };
    /// The strain for the unit normal `n` and `grad Y`. `stretch` is an isotropic area stretch in
    /// addition to that of `Y`.
    pub fn new(n: &SVector<f64, D>, grad_y: &SMatrix<f64, D, D>, stretch: f64) -> SurfaceStrain<D> {
        let tangents = tangent_basis(n);
        let rest = tangents.map(|t| grad_y * t);
        let out = if D == 2 { 1.0 } else { rest[1].norm_squared() };
        let metric =
            Matrix2::new(rest[0].norm_squared(), rest[0].dot(&rest[1]), rest[0].dot(&rest[1]), out)
                / stretch;
        let determinant = metric.determinant();
        let z1 = 1.0 / determinant.sqrt();
        let a = Matrix2::new(metric.m22, -metric.m12, -metric.m12, metric.m11) / determinant;
        // Trace over twice the root of the determinant: the same for a 2 x 2 matrix and its
        // inverse.
        SurfaceStrain { normal: *n, tangents, a, z1, z2: 0.5 * metric.trace() * z1 }
    }
    /// The strain for the unit normal `n`, the area change `z1` and a surface tensor `A` up to a
    /// factor: its tangential part, scaled to the determinant `z1^2`. `shape` must be positive
    /// definite there.
    pub fn from_shape(
        n: &SVector<f64, D>,
        z1: f64,
        shape: &SMatrix<f64, D, D>,
    ) -> SurfaceStrain<D> {
        let tangents = tangent_basis(n);
        let a = tangential(&tangents, shape);
        let a = a * (z1 / a.determinant().sqrt());
        SurfaceStrain { normal: *n, tangents, a, z1, z2: 0.5 * a.trace() / z1 }
    }
    /// The strain for the unit normal `n`, the area change `z1` and the logarithm of the shape
    /// `A / Z1`: of `log_shape` the tangential part without its trace counts, so that any symmetric
    /// tensor gives a positive definite shape of determinant 1.
    pub fn from_log_shape(
        n: &SVector<f64, D>,
        z1: f64,
        log_shape: &SMatrix<f64, D, D>,
    ) -> SurfaceStrain<D> {
        let tangents = tangent_basis(n);
        let log = deviator(&tangential(&tangents, log_shape));
        let size = log.m11.hypot(log.m12);
        let sinh_by_size = if size > 0.0 { size.sinh() / size } else { 1.0 };
        let shape = Matrix2::identity() * size.cosh() + log * sinh_by_size;
        SurfaceStrain { normal: *n, tangents, a: shape * z1, z1, z2: size.cosh() }
    }
    /// The logarithm of the shape `A / Z1`, a tensor of the tangent plane without trace; zero
    /// without shear.
    pub fn log_shape(&self) -> SMatrix<f64, D, D> {
        let shape = deviator(&(self.a / self.z1));
        let sinh = shape.m11.hypot(shape.m12);
        let size_by_sinh = if sinh > 0.0 { sinh.asinh() / sinh } else { 1.0 };
        self.in_space(&(shape * size_by_sinh))
    }
    /// The surface tensor `A`, (3.38).
    pub fn tensor(&self) -> SMatrix<f64, D, D> {
        self.in_space(&self.a)
    }
    /// `C1 = I - n n` of (5.5): `D Z1/Dt = Z1 C1 : grad u`.
    pub fn c1(&self) -> SMatrix<f64, D, D> {
        self.in_space(&Matrix2::identity())
    }
    /// `C2 = 2 A/tr A - (I - n n)` of (5.6): `D Z2/Dt = Z2 C2 : grad u`.
    pub fn c2(&self) -> SMatrix<f64, D, D> {
        self.in_space(&self.shear_direction())
    }
    /// `C2` in the basis of the tangent plane.
    pub(crate) fn shear_direction(&self) -> Matrix2<f64> {
        self.a * (2.0 / self.a.trace()) - Matrix2::identity()
    }
    /// A tensor of the tangent plane as a tensor in space.
    pub(crate) fn in_space(&self, m: &Matrix2<f64>) -> SMatrix<f64, D, D> {
        let [s, t] = &self.tangents;
        (s * m.m11 + t * m.m21) * s.transpose() + (s * m.m12 + t * m.m22) * t.transpose()
    }
}

/// The symmetric part of a tensor in the basis of a tangent plane.
fn tangential<const D: usize>(
    [s, t]: &[SVector<f64, D>; 2],
    tensor: &SMatrix<f64, D, D>,
) -> Matrix2<f64> {
    let along = [tensor * s, tensor * t];
    let mixed = 0.5 * (s.dot(&along[1]) + t.dot(&along[0]));
    Matrix2::new(s.dot(&along[0]), mixed, mixed, t.dot(&along[1]))
}

/// A matrix without its trace.
fn deviator(m: &Matrix2<f64>) -> Matrix2<f64> {
    m - Matrix2::identity() * (0.5 * m.trace())
}

/// Two unit vectors that form an orthonormal frame with `n`; continuous except at `n = -e_z` (Duff
/// et al. 2017). In the plane the tangent and zero.
fn tangent_basis<const D: usize>(n: &SVector<f64, D>) -> [SVector<f64, D>; 2] {
    if D == 2 {
        let t = SVector::<f64, D>::from_fn(|i, _| if i == 0 { -n[1] } else { n[0] });
        return [t, SVector::zeros()];
    }
    let (x, y, z) = (n[0], n[1], n[2]);
    let sign = 1f64.copysign(z);
    let (p, q) = (-1.0 / (sign + z), -x * y / (sign + z));
    let first = Vector3::new(1.0 + sign * x * x * p, sign * q, -sign * x);
    let second = Vector3::new(q, sign + y * y * p, -y);
    [first, second].map(|v| SVector::from_fn(|i, _| v[i]))
}

/// `Z1` by (8.1) of the paper, (3.42) of the book: `J |grad phi| / |grad phi0(Y)|` with
/// `J = 1/det grad Y`.
pub fn area_change_by_level_set(j: f64, slope: f64, slope_at_rest: f64) -> f64 {
    j * slope / slope_at_rest
}

/// Area and shear of a parametrised surface from its metric `M_ij = d_i Psi . d_j Psi` now and at
/// the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LagrangianInvariants {
    /// The area change, `sqrt(det M/det M(0))`; both definitions agree in it.
    pub area: f64,
    /// The shear by (3.1) of the paper, (3.43), over its value at the start. It depends on the
    /// parametrisation, and at the pole of a sphere on the direction from which the pole is
    /// reached.
    pub shear: f64,
    /// The shear by (3.44), of `M M(0)^-1`: the same for all parametrisations, and `Z2` of the
    /// Eulerian description. (In print the area of (3.44) lacks a square root.)
    pub corrected_shear: f64,
}

impl LagrangianInvariants {
    /// The invariants from the two metrics.
    pub fn new(now: &Matrix2<f64>, start: &Matrix2<f64>) -> LagrangianInvariants {
        let shear = |trace: f64, determinant: f64| 0.5 * trace / determinant.sqrt();
        let (d, d0) = (now.determinant(), start.determinant());
        // tr(M M(0)^-1), by the adjugate.
        let adjugate = Matrix2::new(start.m22, -start.m12, -start.m21, start.m11);
        LagrangianInvariants {
            area: (d / d0).sqrt(),
            shear: shear(now.trace(), d) / shear(start.trace(), d0),
            corrected_shear: shear((now * adjugate).trace() / d0, d / d0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Matrix3;
    use proptest::prelude::*;

    fn strain(
        n: [f64; 3],
        f: [f64; 9],
    ) -> Option<(SVector<f64, 3>, Matrix3<f64>, SurfaceStrain<3>)> {
        let n = SVector::<f64, 3>::from(n);
        let grad_y = Matrix3::identity() + Matrix3::from_row_slice(&f) * 0.4;
        if n.norm() < 0.1 || grad_y.determinant().abs() < 0.2 {
            return None;
        }
        let n = n.normalize();
        Some((n, grad_y, SurfaceStrain::new(&n, &grad_y, 1.0)))
    }

    proptest! {
        /// (4.3), (4.4), (4.5), (4.6), (8.1) and Lemma 8.1, term by term as printed.
        #[test]
        fn the_metric_of_the_tangent_plane_gives_the_surface_tensor_as_printed(
            n in prop::array::uniform3(-1.0..1.0f64), f in prop::array::uniform9(-1.0..1.0f64)
        ) {
            let Some((n, grad_y, s)) = strain(n, f) else { return Ok(()) };
            let inverse = grad_y.try_inverse().unwrap();
            let b = inverse * inverse.transpose();
            let bn = b * n;
            let a = b - bn * bn.transpose() / bn.dot(&n);
            let size = a.norm();
            prop_assert!((s.tensor() - a).norm() < 1e-11 * size);
            prop_assert!((a * n).norm() < 1e-11 * size);
            let cofactor = 0.5 * (a.trace().powi(2) - (a * a).trace());
            prop_assert!((s.z1 - cofactor.sqrt()).abs() < 1e-9 * s.z1);
            prop_assert!((s.z2 - 0.5 * a.trace() / cofactor.sqrt()).abs() < 1e-8 * s.z2 && s.z2 >= 1.0 - 1e-12);
            prop_assert!((a * a.trace() - a * a - s.c1() * cofactor).norm() < 1e-10 * size * size);
            prop_assert!((s.c1() - (Matrix3::identity() - n * n.transpose())).norm() < 1e-13);
            prop_assert!((s.c2() - (a * (2.0 / a.trace()) - s.c1())).norm() < 1e-11);
            // A level set at rest with the normal that `n` came from, of slope 1.7 there.
            let at_rest = grad_y.transpose().try_inverse().unwrap() * n;
            let slope_at_rest = 1.7;
            let slope = slope_at_rest / at_rest.norm();
            let z1 = area_change_by_level_set(1.0 / grad_y.determinant().abs(), slope, slope_at_rest);
            prop_assert!((s.z1 - z1).abs() < 1e-10 * z1);
        }

        /// (5.5) and (5.6): what a velocity gradient does to `grad Y` in a small time,
        /// `grad Y (I - dt grad u)`, and to `n`.
        #[test]
        fn the_invariants_grow_as_their_equations_say(
            n in prop::array::uniform3(-1.0..1.0f64), f in prop::array::uniform9(-1.0..1.0f64), u in prop::array::uniform9(-1.0..1.0f64)
        ) {
            let Some((n, grad_y, s)) = strain(n, f) else { return Ok(()) };
            let grad_u = Matrix3::from_row_slice(&u);
            let at = |dt: f64| {
                let turned = (n - grad_u.tr_mul(&n) * dt).normalize();
                SurfaceStrain::new(&turned, &(grad_y - grad_y * grad_u * dt), 1.0)
            };
            let h = 1e-5;
            let (before, after) = (at(-h), at(h));
            let rate = [after.z1 - before.z1, after.z2 - before.z2].map(|d| d / (2.0 * h));
            let said = [s.z1 * s.c1().dot(&grad_u), s.z2 * s.c2().dot(&grad_u)];
            prop_assert!((rate[0] - said[0]).abs() < 1e-6 * (1.0 + s.z1) * (1.0 + s.z2));
            prop_assert!((rate[1] - said[1]).abs() < 1e-6 * (1.0 + s.z2) * (1.0 + s.z2));
        }
    }

    proptest! {
        #[test]
        fn a_shape_is_that_of_its_logarithm(
            n in prop::array::uniform3(-1.0..1.0f64), f in prop::array::uniform9(-1.0..1.0f64)
        ) {
            let Some((n, _, s)) = strain(n, f) else { return Ok(()) };
            let log = s.log_shape();
            prop_assert!(log.trace().abs() < 1e-12 && (log * n).norm() < 1e-12);
            let again = SurfaceStrain::from_log_shape(&n, s.z1, &log);
            prop_assert!((again.tensor() - s.tensor()).norm() < 1e-9 * s.tensor().norm());
            prop_assert!((again.z2 - s.z2).abs() < 1e-9 * s.z2);
            let scaled = SurfaceStrain::from_shape(&n, s.z1, &(s.tensor() * 3.0));
            prop_assert!((scaled.tensor() - s.tensor()).norm() < 1e-9 * s.tensor().norm());
        }
    }

    #[test]
    fn a_stretch_in_all_directions_is_area_and_no_shear() {
        let n = SVector::<f64, 3>::new(0.6, 0.0, -0.8);
        let s = SurfaceStrain::new(&n, &Matrix3::identity(), 1.3);
        assert!((s.z1 - 1.3).abs() < 1e-14 && (s.z2 - 1.0).abs() < 1e-14);
    }

    #[test]
    fn in_the_plane_a_curve_is_a_cylinder() {
        let n = SVector::<f64, 2>::new(0.6, 0.8);
        let s = SurfaceStrain::<2>::new(&n, &(SMatrix::<f64, 2, 2>::identity() / 1.5), 1.0);
        assert!((s.z1 - 1.5).abs() < 1e-14 && (s.z2 - 0.5 * (1.5 + 1.0 / 1.5)).abs() < 1e-14);
    }

    /// Section 3 of the paper: a plane sheared by `u = (0, x, 0)`, in skew coordinates (3.4), and a
    /// sphere near its pole (3.6).
    #[test]
    fn the_shear_of_a_parametrisation_depends_on_it_and_the_corrected_one_does_not() {
        let t = 0.8;
        let metric = |a: [SVector<f64, 3>; 2]| {
            Matrix2::new(a[0].norm_squared(), a[0].dot(&a[1]), a[0].dot(&a[1]), a[1].norm_squared())
        };
        let moved = Matrix3::new(1.0, 0.0, 0.0, t, 1.0, 0.0, 0.0, 0.0, 1.0);
        let of = |a: [SVector<f64, 3>; 2]| {
            LagrangianInvariants::new(&metric(a.map(|a| moved * a)), &metric(a))
        };
        for beta in [0.4f64, 1.0, 2.2] {
            let skew =
                of([SVector::<f64, 3>::x(), SVector::<f64, 3>::new(beta.cos(), beta.sin(), 0.0)]);
            let printed =
                0.5 * (1.0 + t * t + beta.cos().powi(2) + (t * beta.cos() + beta.sin()).powi(2));
            assert!((skew.shear - printed).abs() < 1e-13 && (skew.area - 1.0).abs() < 1e-13);
            assert!((skew.corrected_shear - (1.0 + 0.5 * t * t)).abs() < 1e-13);
        }
        let sphere = |polar: f64, azimuth: f64| {
            let ((s, c), (sin, cos)) = (polar.sin_cos(), azimuth.sin_cos());
            of([
                SVector::<f64, 3>::new(c * cos, c * sin, -s),
                SVector::<f64, 3>::new(-s * sin, s * cos, 0.0),
            ])
        };
        let (polar, mut naive) = (1e-4, Vec::new());
        for azimuth in [0.0f64, 0.7, 1.5] {
            let at = sphere(polar, azimuth);
            // The limit at the pole as printed under (3.6), where the metric at the start is
            // degenerate.
            let limit = azimuth.cos().powi(2) + (azimuth.sin() + t * azimuth.cos()).powi(2);
            assert!((at.shear - limit).abs() < 1e-6, "{} {limit}", at.shear);
            naive.push(at.shear);
            // The pole lies in the plane z = 1, sheared as a plane is.
            assert!((at.corrected_shear - (1.0 + 0.5 * t * t)).abs() < 1e-6);
        }
        assert!((naive[0] - naive[1]).abs() > 0.1, "the pole has one value: {naive:?}");
        // Elsewhere the corrected one is (7.5) at the place where the particle is now.
        let (polar, azimuth) = (1.1f64, 0.7f64);
        let (x, y, z) = (
            polar.sin() * azimuth.cos(),
            polar.sin() * azimuth.sin() + t * polar.sin() * azimuth.cos(),
            polar.cos(),
        );
        let n = SVector::<f64, 3>::new(x - t * (y - t * x), y - t * x, z).normalize();
        let grad_y = Matrix3::new(1.0, 0.0, 0.0, -t, 1.0, 0.0, 0.0, 0.0, 1.0);
        let euler = SurfaceStrain::new(&n, &grad_y, 1.0);
        let lagrange = sphere(polar, azimuth);
        assert!(
            (lagrange.corrected_shear - euler.z2).abs() < 1e-13
                && (lagrange.area - euler.z1).abs() < 1e-13
        );
    }
}
