//! What a simulation is told, and what changes in it.

use super::budget::{Budget, Energies};
use super::carrier::InitialFunction;
use super::clock::Clock;
use crate::base::{Error, Result};
use crate::elastic::{ContinuumForce, Membrane, SharpMembrane, ShearMembrane, explicit_step_limit};
use crate::fem::{Conditions, Element};
use crate::flow::term::MomentumTerm;
use crate::flow::{BodyForce, FlowState};
use crate::linalg::{Ledger, Solving};
use crate::mesh::Point;
use crate::transport::{CharacteristicMap, Method};
use nalgebra::SVector;
use std::sync::Arc;

/// Whether the force of a structure is taken at the old time level or with its change during the step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coupling {
    /// The force of the old (order 2: extrapolated) interface; stable below the limit (1.54).
    Explicit,
    /// The same with the interface carried by the old velocity too (remark 1.12): without viscosity unstable with any step. To show that.
    FullyExplicit,
    /// The force of an interface that is predicted by an implicit diffusion: the book's semi-implicit scheme (3.62)-(3.64).
    SemiImplicit,
    /// Linearised in the velocity of the new time level.
    Implicit,
}

impl Coupling {
    /// Whether the step is bound by (1.54) or less.
    pub fn is_explicit(self) -> bool {
        matches!(self, Coupling::Explicit | Coupling::FullyExplicit)
    }
}

/// A Newtonian fluid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fluid {
    /// Mass per volume; zero for all fluids stands for a flow without inertia.
    pub density: f64,
    /// Dynamic viscosity.
    pub viscosity: f64,
}

/// What a simulation is told.
#[derive(Clone)]
pub struct Settings<const D: usize> {
    /// Time step.
    pub dt: f64,
    /// Order in time, 1 or 2.
    pub order: usize,
    /// How level sets are carried.
    pub transport: Method,
    /// How elastic forces are coupled.
    pub coupling: Coupling,
    /// Whether the flow convects itself.
    pub convection: bool,
    /// Weight of the grad-div term, in units of viscosity.
    pub grad_div: f64,
    /// Relative residual at which iterations with an old factor stop, where the matrix changes from step to step; 0 factors each.
    pub solve_tolerance: f64,
    /// How the linear systems of the flow are solved, and in how much memory.
    pub solving: Solving,
    /// Degree of the quadrature rule.
    pub quadrature: usize,
    /// The fluid outside of all structures; what they hold is said by [`Structure::inside`].
    pub fluid: Fluid,
    /// The Boussinesq form (book, section 1.4.2): densities differ in gravity alone, inertia is that of [`fluid`](Self::fluid) everywhere.
    pub boussinesq: bool,
    /// The elements of the pressure: P1, or in the plane P1 + P0.
    pub pressure: Element,
    /// Boundary conditions.
    pub conditions: Conditions<D>,
    /// Force per mass.
    pub gravity: SVector<f64, D>,
    /// Force per volume.
    pub body_force: Option<Arc<BodyForce<D>>>,
}

impl<const D: usize> Settings<D> {
    /// All fluids, that outside of the structures first.
    pub fn fluids(&self, structures: &[Structure<D>]) -> impl Iterator<Item = Fluid> {
        std::iter::once(self.fluid).chain(structures.iter().filter_map(|s| s.inside))
    }
    /// Whether the density that the inertia of the flow has is the same everywhere at any time.
    pub fn has_constant_inertia(&self, structures: &[Structure<D>]) -> bool {
        structures.iter().all(|s| s.surface_mass == 0.0)
            && (self.boussinesq || self.fluids(structures).all(|f| f.density == self.fluid.density))
    }
    /// Whether the viscosity is the same everywhere at any time.
    pub fn has_constant_viscosity(&self, structures: &[Structure<D>]) -> bool {
        self.fluids(structures).all(|f| f.viscosity == self.fluid.viscosity)
    }
    /// Whether inertia and viscosity are the same everywhere at any time.
    pub fn has_constant_materials(&self, structures: &[Structure<D>]) -> bool {
        self.has_constant_inertia(structures) && self.has_constant_viscosity(structures)
    }
    /// Whether the coupling can be had with these settings.
    ///
    /// # Errors
    /// The semi-implicit scheme, which is of order 1 and whose predictor divides by the density, at order 2 or without inertia.
    pub fn check_coupling(&self, structures: &[Structure<D>]) -> Result<()> {
        if self.coupling == Coupling::FullyExplicit && self.order != 1 {
            return Err(Error::scene("the fully explicit scheme of remark 1.12 is of order 1 in time")
                .value(format!("order {}", self.order))
                .remedy("take time.order = 1, or coupling = \"explicit\""));
        }
        if self.coupling != Coupling::SemiImplicit || structures.is_empty() {
            return Ok(());
        }
        if structures.iter().any(|s| s.sharp.is_some()) {
            let what = "the semi-implicit scheme (3.62)-(3.64) predicts the interface by diffusion in its band, and a sharp one has none";
            return Err(Error::scene(what)
                .value("force = \"sharp\"")
                .remedy("take coupling = \"implicit\" or \"explicit\", or force = \"smeared\""));
        }
        if structures.iter().any(|s| s.shear.is_some()) {
            let what = "the semi-implicit scheme (3.62)-(3.64) predicts the level set, which knows nothing of shear";
            return Err(Error::scene(what)
                .value("coupling = \"semi-implicit\"")
                .remedy("take coupling = \"implicit\" or \"explicit\""));
        }
        let lightest = self.fluids(structures).map(|f| f.density).fold(f64::INFINITY, f64::min);
        let (what, value, remedy) = if self.order != 1 {
            (
                "the semi-implicit scheme (3.62)-(3.64) is of order 1 in time",
                format!("order {}", self.order),
                "time.order = 1",
            )
        } else if lightest <= 0.0 {
            let what = "the semi-implicit scheme (3.62)-(3.64) needs inertia: it predicts the velocity that the force gives to the fluid";
            (what, format!("density {lightest}"), "densities above 0")
        } else {
            return Ok(());
        };
        Err(Error::scene(what).value(value).remedy(format!("take {remedy}, or coupling = \"implicit\"")))
    }
}

/// A structure: its level set (one number a P2 node) and its law.
#[derive(Clone)]
pub struct Structure<const D: usize> {
    /// Name in the scene.
    pub name: String,
    /// Level set, negative inside; its slope at the interface is the stretch.
    pub phi: Vec<f64>,
    /// The elastic membrane on its zero level, spread over a band; its law and the thickness of the band count for a sharp one too.
    pub membrane: Membrane<D>,
    /// The membrane on the interface itself, which then acts in place of the smeared one.
    pub sharp: Option<SharpMembrane<D>>,
    /// The membrane that resists shear beside the change of its area, which then acts in place of the other two.
    pub shear: Option<ShearMembrane<D>>,
    /// The continuum force of surface tension, which then acts in place of the stress of the membrane.
    pub continuum: Option<ContinuumForce<D>>,
    /// The fluid that it encloses; `None` for that outside.
    pub inside: Option<Fluid>,
    /// Stretch at time 0, the same all over the interface.
    pub stretch: f64,
    /// Mass per area at rest.
    pub surface_mass: f64,
}

impl<const D: usize> Structure<D> {
    /// What acts on the flow.
    pub fn term(&self) -> &dyn MomentumTerm<D> {
        match (&self.shear, &self.sharp, &self.continuum) {
            (Some(shear), ..) => shear,
            (None, Some(sharp), _) => sharp,
            (None, None, Some(continuum)) => continuum,
            (None, None, None) => &self.membrane,
        }
    }
    /// Largest tension `E'(r)` on what was prepared last; 0 when nothing is under tension.
    pub fn largest_tension(&self) -> f64 {
        if self.continuum.is_some() {
            return self.membrane.law().tension(1.0);
        }
        match (&self.shear, &self.sharp) {
            (Some(shear), _) => shear.stiffest_waves()[0],
            (None, Some(sharp)) => sharp.largest_tension(),
            (None, None) => self.membrane.largest_tension(),
        }
    }
    /// Distance from the interface up to which the force acts: half-width of the band, 0 for a sharp one.
    pub fn reach(&self) -> f64 {
        if self.sharp.is_some() { 0.0 } else { self.membrane.thickness() }
    }
    /// Largest stable step of the explicit coupling (1.54) for the current tension, on edges of the length `edge`.
    pub fn step_limit(&self, viscosity: f64, edge: f64) -> f64 {
        if let Some(shear) = &self.shear {
            return shear.step_limit(viscosity, edge);
        }
        // A force on the interface acts on what is about it: an edge on each side.
        let thickness = if self.sharp.is_some() { edge } else { self.membrane.thickness() };
        explicit_step_limit(viscosity, thickness, self.largest_tension(), edge)
    }
}

/// All that the forces of structures are made of.
#[derive(Clone, Copy)]
pub(super) struct Configuration<'a, const D: usize> {
    /// Level sets of the structures.
    pub phi: &'a [Vec<f64>],
    /// Logarithms of the stretch, as in [`State::stretch`].
    pub stretch: &'a [Vec<f64>],
    /// As [`State::displacement`].
    pub displacement: &'a [SVector<f64, D>],
}

/// A level set that is carried and acts on nothing.
#[derive(Clone)]
pub struct LevelSet<const D: usize> {
    /// Name in the scene.
    pub name: String,
    /// Its values at the nodes, negative inside.
    pub phi: Vec<f64>,
    /// The function whose values these are, where it is known between the nodes: composed transport evaluates it.
    pub function: Option<Arc<InitialFunction<D>>>,
    /// Particles on the interface, in the order of a closed polygon; may be none.
    pub markers: Vec<Point<D>>,
}

/// Where steps are that follow the error.
#[derive(Clone, Debug, PartialEq)]
pub struct Pace<const D: usize> {
    /// The lengths of steps.
    pub clock: Clock,
    /// Velocity two steps earlier.
    pub earliest_u: Vec<SVector<f64, D>>,
}

/// What the matrix was made of whose factor is kept while the matrix changes: with it a resumed run has the same factor, and goes on
/// with the same bits.
#[derive(Clone, Debug, PartialEq)]
pub struct Factored<const D: usize> {
    /// Level sets of the structures.
    pub phi: Vec<Vec<f64>>,
    /// Their stretches, where they are carried apart.
    pub stretch: Vec<Vec<f64>>,
    /// The displacement back to time 0, where it is carried.
    pub displacement: Vec<SVector<f64, D>>,
    /// Coefficient of the new velocity in the discrete time derivative, over the step.
    pub weight: f64,
    /// The step.
    pub dt: f64,
    /// The books of the choice between iterations and a factorisation.
    pub ledger: Ledger,
}

/// All that changes in time; a checkpoint holds it.
#[derive(Clone, Debug, PartialEq)]
pub struct State<const D: usize> {
    /// Steps taken.
    pub steps: u64,
    /// The time.
    pub time: f64,
    /// Where steps are that follow the error; `None` with steps of one length.
    pub pace: Option<Pace<D>>,
    /// Velocity and pressure.
    pub flow: FlowState<D>,
    /// Level sets, one a structure, then the passive ones, which composed transport leaves empty:
    /// [`Simulation::level_set`](super::Simulation::level_set) evaluates them.
    pub phi: Vec<Vec<f64>>,
    /// Logarithms of the stretch at the nodes, one list a structure; empty for those that are not sharp.
    pub stretch: Vec<Vec<f64>>,
    /// The displacement `Y(x) - x` of the backward characteristics: from each node to where its particle was at time 0. Empty unless a
    /// structure resists shear or it was asked for.
    pub displacement: Vec<SVector<f64, D>>,
    /// Velocity one step earlier; empty when the velocity is prescribed.
    pub earlier_u: Vec<SVector<f64, D>>,
    /// The backward map, with composed transport.
    pub map: Option<CharacteristicMap<D>>,
    /// Markers, one list a passive level set.
    pub markers: Vec<Vec<Point<D>>>,
    /// What the factor of the flow was made of, where it outlives its matrix.
    pub factored: Option<Factored<D>>,
    /// Energies now.
    pub energies: Energies,
    /// The energy budget.
    pub budget: Budget,
}
