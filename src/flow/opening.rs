//! Sides through which fluid passes under a given stress.

use super::boundary::over_boundary;
use super::term::{MomentumTerm, Support};
use crate::fem::{At, Condition, Conditions, Rule, Space, VectorForm};
use crate::mesh::{Facet, Location, Mesh, Point};
use nalgebra::{SMatrix, SVector};

/// Degree of the rule on the edges of facets in space: products of P2 functions.
const DEGREE: usize = 4;

/// The given stress on open sides, as a force: a traction `t`, or `-P n` for a pressure `P`.
#[derive(Default)]
pub struct GivenStress<const D: usize> {
    /// Quadrature points on the sides with a stress other than zero; `q` counts them.
    points: Vec<At<D>>,
    /// Outward normals and numbers of the conditions.
    sites: Vec<(SVector<f64, D>, usize)>,
    /// Force per area.
    forces: Vec<SVector<f64, D>>,
}

impl<const D: usize> GivenStress<D> {
    /// The stress on these facets, each with the number of its condition.
    pub fn new(mesh: &Mesh<D>, facets: &[(u32, usize)], conditions: &Conditions<D>) -> Self {
        let mut given = GivenStress { points: Vec::new(), sites: Vec::new(), forces: Vec::new() };
        let mut facets: Vec<(u32, usize)> = facets.to_vec();
        facets.retain(|(_, k)| stress(&conditions[*k].1).is_some());
        facets.sort_by_key(|(f, _)| mesh.facets()[*f as usize].cell);
        for (number, condition) in facets {
            over_boundary(mesh, &[number], |facet, l, weight| {
                let at = point(mesh, facet, *l, weight, given.points.len());
                given.points.push(at);
                given.sites.push((mesh.facet_normal(facet).0, condition));
            });
        }
        given.forces = vec![SVector::zeros(); given.points.len()];
        given
    }
    /// Takes the stress at a time.
    pub fn prepare(&mut self, conditions: &Conditions<D>, time: f64) {
        for ((at, (n, k)), force) in self.points.iter().zip(&self.sites).zip(&mut self.forces) {
            if let Some(stress) = stress(&conditions[*k].1) {
                *force = stress(&at.x, n, time);
            }
        }
    }
    /// True if no side has a stress other than zero.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }
    /// The first point whose stress is no finite number.
    pub fn not_finite(&self) -> Option<&Point<D>> {
        let bad = |f: &SVector<f64, D>| !f.iter().all(|v| v.is_finite());
        self.forces.iter().position(bad).map(|k| &self.points[k].x)
    }
    /// Power of the stress on a flow with the velocity `u`.
    pub fn power(&self, space: &Space<D>, u: &[SVector<f64, D>]) -> f64 {
        let of = |(at, force): (&At<D>, &SVector<f64, D>)| {
            at.weight * force.dot(&space.value(u, at.cell, &at.barycentric))
        };
        self.points.iter().zip(&self.forces).map(of).sum()
    }
}

impl<const D: usize> MomentumTerm<D> for GivenStress<D> {
    fn support(&self) -> Support<'_, D> {
        Support::Points(&self.points)
    }
    fn force(&self, at: &At<D>) -> VectorForm<D> {
        (self.forces[at.q], SMatrix::zeros())
    }
}

/// The stress that a condition gives, as a function of point, outward normal and time; `None` for
/// none.
fn stress<const D: usize>(
    condition: &Condition<D>,
) -> Option<impl Fn(&Point<D>, &SVector<f64, D>, f64) -> SVector<f64, D> + '_> {
    let given = matches!(
        condition,
        Condition::Traction(_) | Condition::Pressure(_) | Condition::TotalPressure(_)
    );
    given.then_some(move |x: &Point<D>, n: &SVector<f64, D>, t: f64| match condition {
        Condition::Traction(f) => f(x, t),
        Condition::Pressure(p) | Condition::TotalPressure(p) => n * -p(x, t),
        _ => SVector::zeros(),
    })
}

/// What makes of the form `2 mu D(u)` that of `(mu grad u - p) n` on open sides.
///
/// The forms differ on a side by `mu (grad u)^T n . v = mu d_i u_j n_j v_i`, which is not symmetric.
/// For a velocity without divergence its part along the normal is `-mu (div_s u_s) v . n`, with the
/// tangential part `u_s` and the divergence along the side; integrated by parts along the side it
/// becomes
///
/// `B(u, v) = int mu (u_s . grad(v . n) + v_s . grad(u . n)) ds - int mu (u . m) (v . n) dl`,
///
/// where the last integral is over the edges of the facets (in the plane: their ends) and `m` is the
/// normal of an edge in its facet. `B` holds tangential derivatives only, and is symmetric where the
/// edges meet walls or facets of the same kind. It equals the null Lagrangian
/// `int mu (grad u^T : grad v - div u div v)`, also for velocities with divergence: less it,
/// `2 mu (D(u), D(v))` is `mu (grad u, grad v) + mu (div u, div v)`. So the matrix stays symmetric,
/// constant and positive, and no stress is extrapolated in time.
///
/// Where the viscosity varies, `mu` is that of the fluid outside of all structures.
///
/// Source of the condition: J. G. Heywood, R. Rannacher and S. Turek, Artificial boundaries and flux
/// and pressure conditions, Int. J. Numer. Methods Fluids 22 (1996) 325.
pub struct GradientForm<const D: usize> {
    /// Quadrature points on the facets, then on their edges; `q` counts them.
    points: Vec<At<D>>,
    /// Outward normal, and on an edge its normal in the facet.
    sites: Vec<(SVector<f64, D>, Option<SVector<f64, D>>)>,
    viscosity: f64,
}

impl<const D: usize> GradientForm<D> {
    /// The term on these facets in a fluid of this viscosity.
    pub fn new(mesh: &Mesh<D>, mut facets: Vec<u32>, viscosity: f64) -> GradientForm<D> {
        facets.sort_by_key(|f| mesh.facets()[*f as usize].cell);
        let (mut points, mut sites): (Vec<At<D>>, Vec<_>) = (Vec::new(), Vec::new());
        for &number in &facets {
            let mut add = |facet: &Facet, l: [f64; 4], weight: f64, m| {
                points.push(point(mesh, facet, l, weight, points.len()));
                sites.push((mesh.facet_normal(facet).0, m));
            };
            over_boundary(mesh, &[number], |facet, l, weight| add(facet, *l, weight, None));
            let facet = &mesh.facets()[number as usize];
            over_edges(mesh, facet, |l, weight, m| add(facet, l, weight, Some(m)));
        }
        GradientForm { points, sites, viscosity }
    }
    /// True if no side has this form.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }
    /// Power of the stress that a flow with the velocity `u` has on these sides beside that given.
    pub fn power(&self, space: &Space<D>, u: &[SVector<f64, D>]) -> f64 {
        let of = |at: &At<D>| {
            let (v, grad) = (
                space.value(u, at.cell, &at.barycentric),
                space.jacobian(u, at.cell, &at.barycentric),
            );
            let (f0, f1) = self.stiffness(at, &v, &grad);
            -at.weight * (f0.dot(&v) + f1.dot(&grad))
        };
        self.points.iter().map(of).sum()
    }
}

impl<const D: usize> MomentumTerm<D> for GradientForm<D> {
    fn support(&self) -> Support<'_, D> {
        Support::Points(&self.points)
    }
    fn force(&self, _at: &At<D>) -> VectorForm<D> {
        (SVector::zeros(), SMatrix::zeros())
    }
    fn is_implicit(&self) -> bool {
        true
    }
    /// `-B(u, v)`.
    fn stiffness(
        &self,
        at: &At<D>,
        u: &SVector<f64, D>,
        grad_u: &SMatrix<f64, D, D>,
    ) -> VectorForm<D> {
        let ((n, edge), mu) = (&self.sites[at.q], self.viscosity);
        match edge {
            None => {
                let along = |v: &SVector<f64, D>| v - n * n.dot(v);
                let (slope, tangential) = (along(&grad_u.tr_mul(n)), along(u));
                (slope * -mu, n * tangential.transpose() * -mu)
            }
            // The symmetric part: the rest cancels between the facets of an edge.
            Some(m) => ((n * u.dot(m) + m * u.dot(n)) * (0.5 * mu), SMatrix::zeros()),
        }
    }
}

/// A quadrature point on a facet.
fn point<const D: usize>(
    mesh: &Mesh<D>,
    facet: &Facet,
    barycentric: [f64; 4],
    weight: f64,
    q: usize,
) -> At<D> {
    let x = mesh.point_at(&Location { cell: facet.cell, barycentric });
    At { cell: facet.cell as usize, q, barycentric, x, weight }
}

/// Calls `f(barycentric, weight * size, m)` at the quadrature points of the edges of a facet (in the
/// plane: its ends), `m` being the outward normal of the edge in the plane of the facet.
fn over_edges<const D: usize>(
    mesh: &Mesh<D>,
    facet: &Facet,
    mut f: impl FnMut([f64; 4], f64, SVector<f64, D>),
) {
    let corners: Vec<usize> = (0..=D).filter(|i| *i as u32 != facet.opposite).collect();
    let x = |i: usize| mesh.points()[mesh.cell(facet.cell as usize)[i] as usize];
    let rule = Rule::simplex(1, DEGREE);
    for &across in &corners {
        let ends: Vec<usize> = corners.iter().copied().filter(|i| *i != across).collect();
        let mut outward = x(ends[0]) - x(across);
        match ends[..] {
            [a, b] => {
                let (edge, size) = ((x(b) - x(a)).normalize(), (x(b) - x(a)).norm());
                outward -= edge * edge.dot(&outward);
                for (point, w) in rule.points.iter().zip(&rule.weights) {
                    let mut l = [0.0; 4];
                    (l[a], l[b]) = (point[0], point[1]);
                    f(l, w * size, outward.normalize());
                }
            }
            _ => {
                let mut l = [0.0; 4];
                l[ends[0]] = 1.0;
                f(l, 1.0, outward.normalize());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::{Basis, Cells, Element, integrate};
    use crate::mesh::{Diagonals, box_mesh, rectangle};
    use std::sync::Arc;

    /// `B(u, v)` over the facets of a mesh for which `on` is true, and the integral over the mesh of
    /// `grad u^T : grad v - div u div v`.
    fn both_sides<const D: usize>(
        mesh: &Arc<Mesh<D>>,
        u: fn(&Point<D>) -> SVector<f64, D>,
        v: fn(&Point<D>) -> SVector<f64, D>,
    ) -> [f64; 2] {
        let facets = (0..mesh.facets().len() as u32).collect();
        let form = GradientForm::new(mesh, facets, 1.0);
        let space = Arc::new(Space::new(mesh, Element::P2));
        let [u, v] = [u, v].map(|f| space.interpolate(f));
        let of = |at: &At<D>| {
            let value = |f: &[SVector<f64, D>]| {
                let (c, l) = (at.cell, &at.barycentric);
                (space.value(f, c, l), space.jacobian(f, c, l))
            };
            let ((u, grad_u), (v, grad_v)) = (value(&u), value(&v));
            let (f0, f1) = form.stiffness(at, &u, &grad_u);
            -at.weight * (f0.dot(&v) + f1.dot(&grad_v))
        };
        let on_sides = form.support().points().iter().map(of).sum();
        let basis = Basis::new(&space, &Arc::new(Rule::simplex(D, 2)));
        let [inside] = integrate(&basis, Cells::All, |at| {
            let [u, v] = [&u, &v].map(|f| basis.jacobian(at, f));
            [(u * v).trace() - u.trace() * v.trace()]
        });
        [on_sides, inside]
    }

    /// The form on all sides of a domain is a null Lagrangian, for any velocities of the space, also
    /// where facets meet at corners and edges.
    #[test]
    fn the_form_on_the_sides_is_a_null_lagrangian() {
        let shear = |p: &Point<2>| Point::<2>::new(p[0] + 0.3 * p[1], p[1] - 0.2 * p[0] * p[1]);
        let plain = rectangle([0.0; 2], [2.0, 1.0], [5, 4], Diagonals::Right).unwrap();
        let cells = (0..plain.cell_count()).flat_map(|c| plain.cell(c).to_vec()).collect();
        let plane = Mesh::new(plain.points().iter().map(shear).collect(), cells).unwrap();
        let [on_sides, inside] = both_sides(
            &Arc::new(plane),
            |x| Point::<2>::new(x[0] * x[1] + x[1], x[0] * x[0] - 0.7 * x[1]),
            |x| Point::<2>::new(x[1] * x[1] - 0.2 * x[0], 0.4 * x[0] * x[1] + x[0] * x[0]),
        );
        assert!((on_sides - inside).abs() < 1e-12 && inside.abs() > 0.1, "{on_sides} {inside}");
        let space = box_mesh([0.0; 3], [1.0, 2.0, 1.0], [2, 3, 2]).unwrap();
        let [on_sides, inside] = both_sides(
            &Arc::new(space),
            |x| Point::<3>::new(x[0] * x[1], x[0] * x[2] - x[1], x[1] * x[1] + x[2]),
            |x| Point::<3>::new(x[1] * x[2], x[0] * x[0] + x[1], x[0] * x[2] - 2.0 * x[1]),
        );
        assert!((on_sides - inside).abs() < 1e-12 && inside.abs() > 0.1, "{on_sides} {inside}");
    }

    /// The force of a pressure on a side is `-P n`, and its power that on the flow through it.
    #[test]
    fn a_given_stress_has_the_power_of_what_it_drives() {
        let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 4], Diagonals::Left).unwrap();
        let conditions: Conditions<2> = vec![
            ("left".into(), Condition::Pressure(std::sync::Arc::new(|x, t| 3.0 * x[1] + t))),
            ("right".into(), Condition::Open),
        ];
        let facets = |name: &str, k| mesh.boundary(name).unwrap().iter().map(move |f| (*f, k));
        let facets: Vec<_> = facets("left", 0).chain(facets("right", 1)).collect();
        let mut given = GivenStress::new(&mesh, &facets, &conditions);
        given.prepare(&conditions, 2.0);
        let space = Space::new(&Arc::new(mesh.clone()), Element::P2);
        let u = space.interpolate(|x| Point::<2>::new(x[1], 0.5));
        // int (3 y + 2) y dy; the open side has none.
        assert!((given.power(&space, &u) - 2.0).abs() < 1e-13);
        assert!(given.not_finite().is_none());
        given.prepare(&conditions, f64::NAN);
        assert!(given.not_finite().is_some());
    }
}
