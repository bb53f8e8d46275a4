//! Convection that is not along characteristics: linearised implicit, or extrapolated explicit.

use crate::base::{Result, parallel};
use crate::fem::{At, Basis, Cells, MAX_LOCAL, Numbering, Space, VectorForm, assemble_local};
use crate::flow::Coefficient;
use crate::linalg::{Addition, Operator, SymmetricMatrix};
use nalgebra::{SMatrix, SVector};

/// A scheme for the convection of velocity; all are of second order in time with BDF2, of first
/// with backward Euler; the implicit one is of third with BDF3.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConvectionScheme {
    /// Along characteristics: O. Pironneau, On the transport-diffusion algorithm and its
    /// applications to the Navier-Stokes equations, Numer. Math. 38 (1982) 309.
    Characteristics,
    /// Implicit, linearised with the extrapolated velocity: G. A. Baker, V. A. Dougalis and O. A.
    /// Karakashian, On a higher order accurate fully discrete Galerkin approximation to the
    /// Navier-Stokes equations, Math. Comp. 39 (1982) 339.
    Implicit,
    /// Explicit, extrapolated: G. E. Karniadakis, M. Israeli and S. A. Orszag, High-order splitting
    /// methods for the incompressible Navier-Stokes equations, J. Comput. Phys. 97 (1991) 414.
    Explicit,
}

/// How a step takes the convection of velocity into account.
#[derive(Clone, Copy, Debug, Default)]
pub enum Convection<'a, const D: usize> {
    /// Not at all, or by the feet of [`History`](super::History).
    #[default]
    InHistory,
    /// By the form `int rho ((w . grad) u + (div w) u / 2) . v` with a velocity `w` that is known.
    Implicit(&'a [SVector<f64, D>]),
    /// By the force `-sum_k w_k rho ((u_k . grad) u_k + (div u_k) u_k / 2)` of earlier velocities.
    Explicit(&'a [(f64, &'a [SVector<f64, D>])]),
}

/// The bilinear form `C(u, v) = int rho ((w . grad) u + (div w) u / 2) . v` with a given velocity
/// `w`: the convection of Navier-Stokes, linearised.
///
/// `C(u, u) = int rho (w . n) |u|^2 / 2 ds` on the boundary alone if the density is constant, so
/// that it makes no energy whatever `w` is (R. Temam, Une methode d'approximation de la solution
/// des equations de Navier-Stokes, Bull. SMF 96 (1968) 115). No integration by parts: the condition
/// on open sides stays what it is. Its matrix acts on each component alike; one of `n x n` numbers
/// a cell is kept, for `n` velocity functions.
///
/// In cells too coarse for the stream the residual of the momentum equation is tested with
/// `tau (w . grad) v` too, which stabilises along streamlines (SUPG) and is consistent, for the
/// exact solution has no residual: A. N. Brooks and T. J. R. Hughes, Streamline
/// upwind/Petrov-Galerkin formulations for convection dominated flows, Comput. Methods Appl. Mech.
/// Eng. 32 (1982) 199. The gradient of the pressure in it is that from the start of the step, which
/// keeps the pressure out of the nonsymmetric part of the matrix.
#[derive(Default)]
pub(super) struct Transport {
    /// `C(phi_b, phi_a)` of cell `c` at `(c n + a) n + b`; empty if there is no convection.
    locals: Vec<f64>,
    /// `tau` of each cell, if any has one.
    delays: Vec<f64>,
}

/// Cell Reynolds number `rho |w| h/(2 mu)`, `h` along the stream, from which on a cell is
/// stabilised.
pub const STABILISED: f64 = 200.0;

/// The delay `tau = 1/sqrt((weight/2 dt)^2 + (4 |w|/h)^2)` of a cell where the velocity is `w` and
/// the length along it `h`; it falls to 0 at the cell Reynolds number [`STABILISED`].
fn delay(kinematic_viscosity: f64, speed: f64, length: f64, rate: f64) -> f64 {
    let reynolds = speed * length / (2.0 * kinematic_viscosity);
    if reynolds.is_nan() || reynolds <= STABILISED {
        return 0.0;
    }
    (1.0 - STABILISED / reynolds) / (0.5 * rate).hypot(4.0 * speed / length)
}

impl Transport {
    /// Integrates the form for the velocity `w`, `None` for no convection, and stabilises it for
    /// steps with `rate` = `weight/dt`, if there is one.
    pub fn prepare<const D: usize>(
        &mut self,
        velocity: &Basis<D>,
        (density, viscosity): (&Coefficient, &Coefficient),
        w: Option<&[SVector<f64, D>]>,
        rate: Option<f64>,
    ) {
        self.delays.clear();
        let Some(w) = w else { return self.locals.clear() };
        if let Some(rate) = rate {
            self.stabilise(velocity, (density, viscosity), w, rate);
        }
        let rate = rate.unwrap_or_default();
        let delays = &self.delays;
        let (space, n) = (velocity.space(), velocity.space().local_count());
        let mesh = space.mesh();
        self.locals.resize(mesh.cell_count() * n * n, 0.0);
        parallel::fill(&mut self.locals, n * n, |first, part| {
            for (i, local) in part.chunks_exact_mut(n * n).enumerate() {
                let c = first + i;
                let (wind, inverse) = (space.on_cell(w, c), &mesh.map(c).inverse);
                local.fill(0.0);
                let tau = delays.get(c).copied().unwrap_or(0.0);
                let laplacians = if tau > 0.0 { laplacians(space, c) } else { [0.0; MAX_LOCAL] };
                for q in 0..velocity.rule().len() {
                    let (values, gradients) = (velocity.values(q), velocity.reference_gradients(q));
                    let weight = velocity.weight(c, q) * density.value(c, q);
                    let half = 0.5 * (wind.reference_jacobian(gradients) * inverse).trace();
                    // Along the wind, in coordinates of the reference cell.
                    let along = inverse * wind.combined(values);
                    for b in 0..n {
                        let slope = weight * (along.dot(&gradients[b]) + half * values[b]);
                        for a in 0..n {
                            local[a * n + b] += values[a] * slope;
                        }
                    }
                    if tau == 0.0 {
                        continue;
                    }
                    let diffusion = viscosity.value(c, q) / density.value(c, q);
                    for b in 0..n {
                        let residual = along.dot(&gradients[b]) + (half + rate) * values[b]
                            - diffusion * laplacians[b];
                        for a in 0..n {
                            let test = tau * along.dot(&gradients[a]);
                            local[a * n + b] += weight * test * residual;
                        }
                    }
                }
            }
        });
    }

    /// Finds the stabilisation of each cell.
    fn stabilise<const D: usize>(
        &mut self,
        velocity: &Basis<D>,
        (density, viscosity): (&Coefficient, &Coefficient),
        w: &[SVector<f64, D>],
        rate: f64,
    ) {
        let space = velocity.space();
        let mesh = space.mesh();
        let middle = [1.0 / (D as f64 + 1.0); 4];
        self.delays.resize(mesh.cell_count(), 0.0);
        parallel::fill(&mut self.delays, 1, |first, part| {
            for (i, tau) in part.iter_mut().enumerate() {
                let c = first + i;
                let w = space.value(w, c, &middle);
                // The rates at which barycentric coordinates change along `w`.
                let along = mesh.map(c).inverse * w;
                let rates = along.lp_norm(1) + along.sum().abs();
                let nu = viscosity.value(c, 0) / density.value(c, 0);
                *tau = delay(nu, w.norm(), 2.0 * w.norm() / rates, rate);
            }
        });
        if self.delays.iter().all(|tau| *tau == 0.0) {
            self.delays.clear();
        }
    }

    /// `tau w` at a quadrature point, for the part of the residual that is known; zero where
    /// nothing is stabilised.
    pub fn shift<const D: usize>(
        &self,
        velocity: &Basis<D>,
        w: &[SVector<f64, D>],
        at: &At<D>,
    ) -> SVector<f64, D> {
        match self.delays.get(at.cell) {
            Some(tau) if *tau > 0.0 => velocity.value(at, w) * *tau,
            _ => SVector::zeros(),
        }
    }

    /// True if any cell is stabilised.
    pub fn is_stabilised(&self) -> bool {
        !self.delays.is_empty()
    }

    /// True if there is convection.
    pub fn is_active(&self) -> bool {
        !self.locals.is_empty()
    }

    /// Adds `C(u, v)`, for all `v`, to `out`, one vector per node.
    pub fn add<const D: usize>(
        &self,
        velocity: &Basis<D>,
        cells: Cells<'_>,
        u: &[SVector<f64, D>],
        (out, scratch): (&mut [SVector<f64, D>], &mut Vec<SVector<f64, D>>),
    ) {
        if !self.is_active() {
            return;
        }
        let (space, n) = (velocity.space(), velocity.space().local_count());
        assemble_local(velocity, cells, out, scratch, SVector::<f64, D>::zeros(), |c, sums| {
            let (nodes, local) = (space.cell_nodes(c), &self.locals[c * n * n..][..n * n]);
            for (row, sum) in local.chunks_exact(n).zip(sums) {
                for (&node, v) in nodes.iter().zip(row) {
                    *sum += u[node as usize] * *v;
                }
            }
        });
    }
}

/// Laplacians of the velocity functions of a cell, constant for degree 2: their gradients are
/// linear, with the values at the corners.
fn laplacians<const D: usize>(space: &Space<D>, cell: usize) -> [f64; MAX_LOCAL] {
    let (inverse, mut sums) = (&space.mesh().map(cell).inverse, [0.0; MAX_LOCAL]);
    for corner in 0..=D {
        let mut at = [0.0; 4];
        at[corner] = 1.0;
        // The gradient of the barycentric coordinate of the corner.
        let slope: SVector<f64, D> = match corner {
            0 => -inverse.row_sum().transpose(),
            k => inverse.row(k - 1).transpose(),
        };
        let gradients = space.element().reference_gradients::<D>(&at);
        for (sum, g) in sums.iter_mut().zip(&gradients).take(space.local_count()) {
            *sum += slope.dot(&inverse.tr_mul(g));
        }
    }
    sums
}

/// The force of [`Convection::Explicit`] at a point.
pub(super) fn explicit_force<const D: usize>(
    velocity: &Basis<D>,
    density: &Coefficient,
    earlier: &[(f64, &[SVector<f64, D>])],
    at: &At<D>,
) -> VectorForm<D> {
    let of = |(weight, u): &(f64, &[SVector<f64, D>])| {
        let (value, gradient) = (velocity.value(at, u), velocity.jacobian(at, u));
        (gradient * value + value * (0.5 * gradient.trace())) * (-weight * density.at(at))
    };
    (earlier.iter().map(of).sum(), SMatrix::zeros())
}

/// The form on the unknowns of a system.
pub(super) struct OnUnknowns<'a, const D: usize> {
    pub transport: &'a Transport,
    pub velocity: &'a Basis<D>,
    pub numbering: &'a Numbering<D>,
    pub work: &'a mut OnNodes<D>,
}

/// Buffers of a product.
#[derive(Default)]
pub(super) struct OnNodes<const D: usize> {
    zero: Vec<SVector<f64, D>>,
    u: Vec<SVector<f64, D>>,
    p: Vec<f64>,
    product: Vec<SVector<f64, D>>,
    scratch: Vec<SVector<f64, D>>,
    rows: Vec<f64>,
}

impl<const D: usize> OnUnknowns<'_, D> {
    /// The operator of a step: a matrix, with convection if there is any.
    pub fn beside<'a>(&'a mut self, matrix: &'a SymmetricMatrix) -> Operator<'a> {
        let active = self.transport.is_active();
        Operator { matrix, addition: if active { Some(self) } else { None } }
    }
}

impl<const D: usize> Addition for OnUnknowns<'_, D> {
    fn add_product(&mut self, x: &[f64], y: &mut [f64]) {
        let (nodes, zero) = (self.velocity.space().len(), SVector::<f64, D>::zeros());
        let OnNodes { zero: lift, u, p, product, scratch, rows } = &mut *self.work;
        lift.resize(nodes, zero);
        u.resize(nodes, zero);
        p.resize(self.numbering.pressure_unknowns().len(), 0.0);
        product.clear();
        product.resize(nodes, zero);
        rows.resize(x.len(), 0.0);
        self.numbering.scatter(x, lift, u, p);
        self.transport.add(self.velocity, Cells::All, u, (product, scratch));
        self.numbering.gather(product, &[], rows);
        y.iter_mut().zip(rows).for_each(|(y, r)| *y += *r);
    }

    fn add_halves(
        &self,
        symmetric: &mut SymmetricMatrix,
        skew: &mut SymmetricMatrix,
    ) -> Result<()> {
        let (space, n) = (self.velocity.space(), self.velocity.space().local_count());
        let m = D * n;
        let (mut unknowns, mut halves) = (Vec::new(), [vec![0.0; m * m], vec![0.0; m * m]]);
        for (c, local) in self.transport.locals.chunks_exact(n * n).enumerate() {
            let nodes = space.cell_nodes(c);
            self.numbering.cell_unknowns(nodes, None, &mut unknowns);
            for (half, sign) in halves.iter_mut().zip([1.0, -1.0]) {
                half.fill(0.0);
                for (a, b, i) in (0..n * n * D).map(|k| (k / D / n, k / D % n, k % D)) {
                    let value = 0.5 * (local[a * n + b] + sign * local[b * n + a]);
                    half[(D * a + i) * m + D * b + i] = value;
                }
                self.numbering.rotate_local(nodes, m, half);
            }
            symmetric.add_group(&unknowns, &halves[0])?;
            skew.add_group(&unknowns, &halves[1])?;
        }
        Ok(())
    }
}
