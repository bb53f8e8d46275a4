//! Energy of a membrane that resists area change and shear, as a function of `Z1` and `Z2`.

use super::area_law::AreaLaw;
use crate::structure::SurfaceStrain;
use nalgebra::{Matrix2, SMatrix, Vector2};

/// A law `E2(Z2)` of the shear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ShearLaw {
    /// `E2' = mu (Z2 - 1)`: the second of (5.18), (3.65).
    Linear {
        /// `mu`, force per length. No resistance to a small shear: `Z2 - 1` is of second order in
        /// it.
        modulus: f64,
    },
    /// `E2 = mu (Z2 - 1)`: the shear part of the neo-Hookean law, of modulus `mu` for small
    /// strains.
    NeoHookean {
        /// `mu`, force per length.
        modulus: f64,
    },
}

/// The energy `W` of a membrane per unit of area at rest, as a function of `Z1 = l1 l2` and
/// `Z2 = (l1/l2 + l2/l1)/2`, `l1` and `l2` being the principal stretches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SurfaceLaw {
    /// `W = E1(Z1) + E2(Z2)` (5.13).
    Split {
        /// `E1`.
        area: AreaLaw,
        /// `E2`.
        shear: ShearLaw,
    },
    /// `W = G/2 (l1^2 + l2^2 + 1/(l1 l2)^2 - 3) = G/2 (2 Z1 Z2 + Z1^-2 - 3)`: a thin sheet of
    /// incompressible neo-Hookean rubber, whose tension is `G/(l1 l2) (l1^2 - 1/(l1 l2)^2)`.
    /// `E_s = 3 G`.
    NeoHookean {
        /// `G`, the surface shear modulus, force per length.
        modulus: f64,
    },
    /// `W = G/4 (I1^2 + 2 I1 - 2 I2 + C I2^2)`, `I1 = l1^2 + l2^2 - 2 = 2 Z1 Z2 - 2`,
    /// `I2 = (l1 l2)^2 - 1 = Z1^2 - 1` (Skalak, Tozeren, Zarda and Chien 1973): red blood cells for
    /// large `C`.
    Skalak {
        /// `G`, the surface shear modulus, force per length.
        modulus: f64,
        /// `C`, resistance to area over that to shear.
        area_ratio: f64,
    },
}

/// `W` with its first and second derivatives by `(Z1, Z2)`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Response {
    /// `W`.
    pub energy: f64,
    /// `dW/dZ1`, `dW/dZ2`.
    pub first: [f64; 2],
    /// `d2W/dZ1^2`, `d2W/dZ1 dZ2`, `d2W/dZ2^2`.
    pub second: [f64; 3],
}

impl SurfaceLaw {
    /// `W` and its derivatives at `(Z1, Z2)`.
    pub fn response(self, z1: f64, z2: f64) -> Response {
        match self {
            SurfaceLaw::Split { area, shear } => {
                let [e, d, dd] = match shear {
                    ShearLaw::Linear { modulus } => {
                        [0.5 * modulus * (z2 - 1.0).powi(2), modulus * (z2 - 1.0), modulus]
                    }
                    ShearLaw::NeoHookean { modulus } => [modulus * (z2 - 1.0), modulus, 0.0],
                };
                Response {
                    energy: area.energy(z1) + e,
                    first: [area.tension(z1), d],
                    second: [area.stiffness(z1), 0.0, dd],
                }
            }
            SurfaceLaw::NeoHookean { modulus: g } => Response {
                energy: 0.5 * g * (2.0 * z1 * z2 + z1.powi(-2) - 3.0),
                first: [g * (z2 - z1.powi(-3)), g * z1],
                second: [3.0 * g * z1.powi(-4), g, 0.0],
            },
            SurfaceLaw::Skalak { modulus: g, area_ratio: c } => {
                let (i1, i2) = (2.0 * z1 * z2 - 2.0, z1 * z1 - 1.0);
                Response {
                    energy: 0.25 * g * (i1 * i1 + 2.0 * i1 - 2.0 * i2 + c * i2 * i2),
                    first: [g * ((i1 + 1.0) * z2 - z1 + c * i2 * z1), g * (i1 + 1.0) * z1],
                    second: [
                        g * (2.0 * z2 * z2 - 1.0 + c * (3.0 * z1 * z1 - 1.0)),
                        g * (i1 + 1.0 + 2.0 * z1 * z2),
                        2.0 * g * z1 * z1,
                    ],
                }
            }
        }
    }
    /// The largest modulus of the law, force per length.
    pub fn modulus(self) -> f64 {
        match self {
            SurfaceLaw::Split { area, shear } => {
                let (ShearLaw::Linear { modulus } | ShearLaw::NeoHookean { modulus }) = shear;
                area.modulus().max(modulus)
            }
            SurfaceLaw::NeoHookean { modulus } => 3.0 * modulus,
            SurfaceLaw::Skalak { modulus, area_ratio } => modulus * (1.0 + area_ratio).max(1.0),
        }
    }
}

/// Tension and tangent stiffness of a law at a point, per area at rest, in the basis of the tangent
/// plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tangent {
    /// The tension `T = W_1 Z1 C1 + W_2 Z2 C2`, such that `dW/dt = T : grad u`.
    pub tension: Matrix2<f64>,
    /// The second derivative of `W` along `I + s grad u` in the tangential part of `grad u`: its
    /// components as `[11, 12, 21, 22]`, where `ij` is `t_i . grad u t_j`. (The second derivative
    /// in the part out of the plane is `T` itself.)
    pub in_plane: SMatrix<f64, 4, 4>,
}

impl Tangent {
    /// The tension and the second variation of `W` under the deformation `x -> x + s u(x)`:
    /// with `a` the tangential part of `grad u`, `p = tr a` and `q = C2 : a`,
    ///
    /// `W_11 Z1^2 p^2 + 2 W_12 Z1 Z2 p q + W_22 Z2^2 q^2 + W_1 Z1 (p^2 - tr a^2) + W_2 Z2 (q^2 + 2
    /// (a A) : a/tr A - (p + q)^2 + tr a^2)`.
    pub fn new<const D: usize>(law: SurfaceLaw, strain: &SurfaceStrain<D>) -> Tangent {
        let Response { first, second, .. } = law.response(strain.z1, strain.z2);
        let (c2, a) = (strain.shear_direction(), strain.a);
        let (s1, s2) = (first[0] * strain.z1, first[1] * strain.z2);
        let (k11, k12, k22) = (
            second[0] * strain.z1.powi(2),
            second[1] * strain.z1 * strain.z2,
            second[2] * strain.z2.powi(2),
        );
        let p = [1.0, 0.0, 0.0, 1.0];
        let q = [c2.m11, c2.m12, c2.m21, c2.m22];
        let mut k = SMatrix::<f64, 4, 4>::zeros();
        for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
            let (row, column) = ([i / 2, i % 2], [j / 2, j % 2]);
            // tr(a b) pairs `ij` with `ji`; (a A) : b pairs rows with themselves.
            let trace = f64::from(row[0] == column[1] && row[1] == column[0]);
            let by_rows =
                if row[0] == column[0] { 2.0 * a[(row[1], column[1])] / a.trace() } else { 0.0 };
            let sum = (p[i] + q[i]) * (p[j] + q[j]);
            k[(i, j)] = k11 * p[i] * p[j]
                + k12 * (p[i] * q[j] + q[i] * p[j])
                + k22 * q[i] * q[j]
                + s1 * (p[i] * p[j] - trace)
                + s2 * (q[i] * q[j] + by_rows - sum + trace);
        }
        Tangent { tension: Matrix2::identity() * s1 + c2 * s2, in_plane: k }
    }
    /// The nearest positive semi-definite forms, out of the plane and in it.
    pub fn clamped(&self) -> (Matrix2<f64>, SMatrix<f64, 4, 4>) {
        let tension = self.tension.symmetric_eigen();
        let tension = tension.eigenvectors
            * Matrix2::from_diagonal(&tension.eigenvalues.map(|v| v.max(0.0)))
            * tension.eigenvectors.transpose();
        // The rotation in the plane and the three symmetric components: coupled, but only a 4 x 4
        // matrix.
        let k = self.in_plane.symmetric_eigen();
        let values = SMatrix::<f64, 4, 4>::from_diagonal(&k.eigenvalues.map(|v| v.max(0.0)));
        (tension, k.eigenvectors * values * k.eigenvectors.transpose())
    }
    /// Largest wave stiffnesses, normal and tangential to the membrane: the largest tension, and
    /// the largest eigenvalue of the acoustic tensor `K[u k, u k]` over directions `k`, per area at
    /// rest. For an area law at rest 0 and its modulus.
    pub fn wave_stiffnesses(&self) -> [f64; 2] {
        let along = |i: usize| {
            let (sin, cos) = (std::f64::consts::PI * i as f64 / DIRECTIONS as f64).sin_cos();
            let k = Vector2::new(cos, sin);
            let acoustic = Matrix2::from_fn(|i, l| {
                let pairs = (0..2).flat_map(|j| (0..2).map(move |m| (j, m)));
                pairs.map(|(j, m)| self.in_plane[(2 * i + j, 2 * l + m)] * k[j] * k[m]).sum::<f64>()
            });
            acoustic.symmetric_eigenvalues().max()
        };
        [self.tension.symmetric_eigenvalues().max(), (0..DIRECTIONS).map(along).fold(0.0, f64::max)]
    }
}

/// Number of sampled wave directions, over half a turn.
const DIRECTIONS: usize = 8;

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, SVector};
    use proptest::prelude::*;

    const LAWS: [SurfaceLaw; 5] = [
        SurfaceLaw::Split {
            area: AreaLaw::Linear { modulus: 1.0 },
            shear: ShearLaw::Linear { modulus: 0.1 },
        },
        SurfaceLaw::Split {
            area: AreaLaw::Tension { tension: 0.3 },
            shear: ShearLaw::NeoHookean { modulus: 0.7 },
        },
        SurfaceLaw::NeoHookean { modulus: 2.0 },
        SurfaceLaw::Skalak { modulus: 0.5, area_ratio: 1.0 },
        SurfaceLaw::Skalak { modulus: 0.5, area_ratio: 20.0 },
    ];

    #[test]
    fn the_response_holds_the_derivatives_of_the_energy() {
        for law in LAWS {
            for (z1, z2) in [(0.8, 1.0), (1.0, 1.3), (1.4, 2.1)] {
                let (r, h) = (law.response(z1, z2), 1e-5);
                let slope = |f: &dyn Fn(Response) -> f64, a: [f64; 2]| {
                    let at = |s: f64| f(law.response(z1 + s * a[0], z2 + s * a[1]));
                    (at(h) - at(-h)) / (2.0 * h)
                };
                for (k, a) in [[1.0, 0.0], [0.0, 1.0]].into_iter().enumerate() {
                    assert!((slope(&|r| r.energy, a) - r.first[k]).abs() < 1e-7, "{law:?}");
                    assert!((slope(&|r| r.first[0], a) - r.second[k]).abs() < 1e-6, "{law:?}");
                    assert!((slope(&|r| r.first[1], a) - r.second[k + 1]).abs() < 1e-6, "{law:?}");
                }
            }
        }
    }

    /// Principal tensions as the literature on capsules prints them, from
    /// `T = W_1 Z1 C1 + W_2 Z2 C2` over the area.
    #[test]
    fn the_tensions_of_capsules_are_the_published_ones() {
        for (l1, l2) in [(1.0f64, 1.0f64), (1.3, 0.9), (1.1, 1.25)] {
            let grad_y =
                Matrix3::from_diagonal(&SVector::<f64, 3>::new(1.0 / l1, 1.0 / l2, l1 * l2));
            let strain = SurfaceStrain::new(&SVector::<f64, 3>::z(), &grad_y, 1.0);
            let g = 0.7;
            let of =
                |law| strain.in_space(&(Tangent::new(law, &strain).tension / strain.z1))[(0, 0)];
            let rubber = g / (l1 * l2) * (l1 * l1 - (l1 * l2).powi(-2));
            assert!((of(SurfaceLaw::NeoHookean { modulus: g }) - rubber).abs() < 1e-13);
            // G l1/l2 [(l1^2 - 1) + C l2^2 (l1^2 l2^2 - 1)], of W = G/4 (...).
            let c = 10.0;
            let cell = g * l1 / l2 * (l1 * l1 - 1.0 + c * l2 * l2 * ((l1 * l2).powi(2) - 1.0));
            assert!((of(SurfaceLaw::Skalak { modulus: g, area_ratio: c }) - cell).abs() < 1e-12);
        }
    }

    #[test]
    fn waves_along_a_membrane_at_rest_meet_its_moduli() {
        let strain = SurfaceStrain::new(&SVector::<f64, 3>::z(), &Matrix3::identity(), 1.0);
        let stiffest = |law| Tangent::new(law, &strain).wave_stiffnesses()[1];
        assert!((stiffest(LAWS[0]) - 1.0).abs() < 1e-14);
        // Rubber: 4 G lengthwise (E_s/(1 - nu^2) with E_s = 3 G, nu = 1/2); Skalak: G (2 + 2 C).
        assert!((stiffest(LAWS[2]) - 4.0 * 2.0).abs() < 1e-13);
        assert!((stiffest(LAWS[3]) - 0.5 * (2.0 + 2.0)).abs() < 1e-13);
        assert!((stiffest(LAWS[4]) - 0.5 * (2.0 + 40.0)).abs() < 1e-12);
    }

    proptest! {
        /// `W` along `x -> x + s u(x)`: its slope is the tension and its curvature the tangent, in
        /// the plane and out of it.
        #[test]
        fn tension_and_tangent_are_the_first_and_second_variation(
            n in prop::array::uniform3(-1.0..1.0f64), f in prop::array::uniform9(-1.0..1.0f64), u in prop::array::uniform9(-1.0..1.0f64)
        ) {
            let n = SVector::<f64, 3>::from(n);
            let grad_y = Matrix3::identity() + Matrix3::from_row_slice(&f) * 0.25;
            prop_assume!(n.norm() > 0.1 && grad_y.determinant().abs() > 0.4);
            let (n, grad_u) = (n.normalize(), Matrix3::from_row_slice(&u));
            let strain = SurfaceStrain::new(&n, &grad_y, 1.0);
            let at = |law: SurfaceLaw, s: f64| {
                let back = (Matrix3::identity() + grad_u * s).try_inverse().unwrap();
                let moved = SurfaceStrain::new(&back.tr_mul(&n).normalize(), &(grad_y * back), 1.0);
                law.response(moved.z1, moved.z2).energy
            };
            for law in LAWS {
                let (tangent, h) = (Tangent::new(law, &strain), 1e-4);
                let t = strain.tangents;
                let a = SVector::<f64, 4>::from_fn(|k, _| t[k / 2].dot(&(grad_u * t[k % 2])));
                let b = SVector::<f64, 2>::from_fn(|k, _| n.dot(&(grad_u * t[k])));
                let slope = (at(law, h) - at(law, -h)) / (2.0 * h);
                let said = strain.in_space(&tangent.tension).dot(&grad_u);
                let size = 1.0 + tangent.in_plane.norm();
                prop_assert!((slope - said).abs() < 1e-5 * size, "{law:?}: {slope} {said}");
                let curve = (at(law, h) - 2.0 * at(law, 0.0) + at(law, -h)) / (h * h);
                let said = a.dot(&(tangent.in_plane * a)) + b.dot(&(tangent.tension * b));
                prop_assert!((curve - said).abs() < 1e-4 * size * size, "{law:?}: {curve} {said}");
                let (out, inside) = tangent.clamped();
                prop_assert!(out.symmetric_eigenvalues().min() > -1e-10 * size);
                prop_assert!(inside.symmetric_eigenvalues().min() > -1e-10 * size);
                prop_assert!(a.dot(&(inside * a)) >= a.dot(&(tangent.in_plane * a)) - 1e-9 * size);
            }
        }
    }
}
