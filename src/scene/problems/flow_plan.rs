//! The plan of an immersed flow.

use crate::base::length;
use crate::fem::Element;
use crate::flow::STABILISED;
use crate::output::rounded;
use crate::scene::Scene;
use crate::scene::plan::{self, Section};
use crate::scene::problem::{ElasticWave, FIRST_STRETCH, Limits};
use crate::scene::redistance::in_words;
use crate::scene::schema::Contrast;
use crate::scene::view::View;
use crate::sim::{ConvectionScheme, Coupling, Simulation};
use crate::transport::Method;

/// The data for the plan of an immersed flow.
pub(super) struct FlowPlan<'a, const D: usize> {
    pub scene: &'a Scene,
    pub sim: &'a Simulation<D>,
    pub view: View<'a, D>,
    pub limits: Limits,
    /// Elastic waves at the start.
    pub waves: Vec<ElasticWave>,
    /// Numbers without units, with their definitions.
    pub numbers: Vec<String>,
    /// Velocity scale from which grad-div was derived, if it was.
    pub velocity_scale: Option<f64>,
    /// Where the flow starts from, if another run.
    pub start: Option<String>,
}

impl<const D: usize> FlowPlan<'_, D> {
    /// All sections except that of the mesh.
    pub fn sections(self) -> impl Iterator<Item = Section> {
        [
            ("Solved", self.solved()),
            ("Numbers", self.numbers.clone()),
            ("Unknowns", self.unknowns()),
            ("Numerics", self.numerics()),
            ("Left out", self.left_out()),
            ("Steps", self.steps()),
        ]
        .into_iter()
        .filter(|section| !section.1.is_empty())
    }

    fn solved(&self) -> Vec<String> {
        let (scene, sim) = (self.scene, self.sim);
        let equations = match (sim.is_stokes(), sim.settings().convection) {
            (true, _) => "Stokes flow (density 0): -div(2 mu D(u)) + grad p = F, div u = 0",
            (false, Some(_)) => {
                "Navier-Stokes flow (3.20)-(3.21): rho Du/Dt - div(2 mu D(u)) + grad p = F, div u \
                 = 0"
            }
            (false, None) => {
                "unsteady Stokes flow (convection = false): rho du/dt - div(2 mu D(u)) + grad p = \
                 F, div u = 0"
            }
        };
        let (density, viscosity) = (both(scene.fluid.density), both(scene.fluid.viscosity));
        let mut lines = vec![equations.into(), format!("density {density}, viscosity {viscosity}")];
        lines.extend(plan::structures(scene));
        lines.extend(plan::boundaries(scene));
        lines.extend(self.start.clone());
        if !sim.flow().numbering().is_open() {
            lines.push("no boundary is open: the pressure has zero mean".into());
        }
        lines
    }

    fn unknowns(&self) -> Vec<String> {
        let (sim, flow) = (self.sim, self.sim.flow());
        let velocity = flow.numbering().first_pressure();
        let pressure = flow.numbering().order() - velocity;
        let element = if sim.settings().pressure == Element::P1P0 { "P1 + P0" } else { "P1" };
        let mut lines = vec![format!("velocity {velocity} (P2), pressure {pressure} ({element})")];
        lines.extend(plan::level_sets(&self.view));
        if self.view.has_backward_map() {
            lines.push(format!("backward characteristics {} x {} (P2)", D, sim.space().len()));
        }
        lines.extend(plan::map_memory(&self.view));
        let implicit =
            sim.structures().iter().any(|s| s.acts() && s.coupling() == Coupling::Implicit);
        let constant = flow.density().is_constant() && flow.viscosity().is_constant();
        let unsymmetric =
            !sim.is_stokes() && sim.settings().convection == Some(ConvectionScheme::Implicit);
        let (kind, why) = match (constant, implicit) {
            (true, false) if sim.has_backflow() && !unsymmetric => (
                "constant while no fluid comes in through an open side",
                "factored once".to_string(),
            ),
            (true, false) if !unsymmetric => ("constant", "factored once".to_string()),
            (true, true) => {
                ("changes with the interface (implicit coupling)", flow.solver_description())
            }
            (true, false) => ("changes with convection", flow.solver_description()),
            (false, _) => ("changes with density or viscosity", flow.solver_description()),
        };
        lines.push(format!("matrix {kind}: {why}"));
        lines.extend(flow.solver_summary());
        if let Some((_, factor)) = flow.solver_size() {
            lines.push(format!(
                "matrix {} entries (one triangle), {} factor {} entries; memory about {:.0} \
                 MB, of which factors {:.0} MB",
                flow.matrix_nonzeros(),
                if unsymmetric { "LDU" } else { "LDL^T" },
                factor.entries,
                sim.bytes() as f64 / 1e6,
                sim.factor_bytes() as f64 / 1e6
            ));
        }
        lines
    }

    fn numerics(&self) -> Vec<String> {
        let (scene, s) = (self.scene, self.sim.settings());
        let mut lines = vec![match (self.sim.is_stokes(), s.convection) {
            (true, _) => {
                format!("no time derivative in the flow, step {} of order {}", s.dt, s.order)
            }
            (false, Some(scheme)) => {
                let convection = match scheme {
                    ConvectionScheme::Characteristics => "along characteristics",
                    ConvectionScheme::Implicit => {
                        "with implicit convection by the extrapolated velocity (baker1982)"
                    }
                    ConvectionScheme::Explicit => {
                        "with extrapolated explicit convection (karniadakis1991)"
                    }
                };
                let stabilised = match scheme {
                    ConvectionScheme::Implicit => format!(
                        ", stabilised along streamlines (SUPG) in cells whose Reynolds number \
                         rho |u| h/(2 mu) is above {STABILISED}"
                    ),
                    _ => String::new(),
                };
                format!("BDF{} {convection}, step {}{stabilised}", s.order, s.dt)
            }
            (false, None) => format!("BDF{}, step {}", s.order, s.dt),
        }];
        let derived = self
            .velocity_scale
            .map(|u| format!(" (derived from the velocity scale {})", length(u)));
        lines.push(format!(
            "grad-div {}{}: keeps the divergence small, which else feeds energy into a membrane",
            length(s.grad_div),
            derived.unwrap_or_default()
        ));
        if let (Some(eps), Some([fine, coarse])) = (self.limits.thickness, self.limits.band_edges) {
            let given = if scene.numerics.thickness.is_some() { "" } else { " (derived)" };
            let edge = match coarse - fine > 1e-12 * coarse {
                true => format!("{} to {}", length(fine), length(coarse)),
                false => length(fine),
            };
            if self.is_stepped() || scene.acting().any(|s| !s.traits().on_interface) {
                let edges = eps / coarse;
                lines.push(format!(
                    "band half-width {}{given} on edges of {edge}: {edges:.2} edges; the error it \
                     makes is of first order in it",
                    length(eps)
                ));
            } else {
                let own = scene.numerics.thickness.filter(|_| scene.adapt.is_none());
                let unused = own.map(|_| "thickness").into_iter();
                lines.extend(unused.chain(scene.numerics.keys_of_band()).map(|key| {
                    format!(
                        "numerics.{key} is not used: nothing is spread over a band (force = \
                         \"smeared\" is)"
                    )
                }));
            }
            lines.extend(scene.structures().iter().filter_map(|s| s.numerics(scene)));
            lines.push(plan::transport(scene, &self.view));
            lines.push(self.coupling());
        }
        lines.extend(in_words(scene));
        lines.push(format!("quadrature of degree {}", s.quadrature));
        lines
    }

    /// The coupling of the forces in words.
    fn coupling(&self) -> String {
        match self.scene.numerics.coupling {
            Coupling::Explicit if self.scene.numerics.has_continuum_force() => {
                "surface tension as a continuum force (1.32), explicit, with the curvature from \
                 recovered second derivatives"
                    .into()
            }
            Coupling::Explicit => "membrane force explicit".into(),
            Coupling::FullyExplicit => "membrane force explicit, and the interface carried by the \
                old velocity (remark 1.12)"
                .into(),
            Coupling::SemiImplicit => {
                let constant = !self.is_stiff() && self.sim.flow().density().is_constant();
                let factored = if constant { "once" } else { "in each step" };
                format!(
                    "membrane force semi-implicit (3.62)-(3.64): of a level set predicted by \
                     implicit diffusion, its matrix factored {factored}"
                )
            }
            Coupling::Implicit => "membrane force implicit in the velocity".into(),
        }
    }

    fn left_out(&self) -> Vec<String> {
        let (scene, mut lines) = (self.scene, Vec::new());
        if self.sim.is_stokes() {
            lines.push("inertia and convection: the density is 0");
        }
        if scene.acting().next().is_none() {
            lines.push("level sets and elastic forces: no structure is immersed");
        } else {
            if !self.view.has_backward_map() {
                lines.push(match scene.acting().any(|s| s.traits().carries_strain) {
                    true => "backward characteristics: the strain is carried along the interface",
                    false => {
                        "backward characteristics: no shear and no bulk elasticity is asked for"
                    }
                });
            }
            if !scene.output.curvature && !scene.numerics.has_continuum_force() {
                lines.push(
                    "curvature: no bending is asked for, and the stress form of the tension does \
                     not need it",
                );
            }
            if in_words(scene).is_none() {
                let drops = !scene.acting().any(|s| s.traits().stretches);
                let stretch =
                    "redistancing: the slope of the level set is the stretch of the membrane";
                lines.push(if drops { "redistancing: it is not asked for" } else { stretch });
            }
            if scene.numerics.transport == Method::Nodal {
                lines.push("the mass matrix of the level set: nodal transport does not project");
            }
        }
        if scene.fluids().all(|f| f == scene.outside()) {
            lines.push("variable density and viscosity: both sides are the same");
        } else if scene.fluid.boussinesq {
            lines.push(
                "variable inertia: the Boussinesq form, in which densities differ in gravity alone",
            );
        }
        lines.into_iter().map(String::from).chain(plan::third_dimension(D)).collect()
    }

    fn steps(&self) -> Vec<String> {
        let (scene, mut lines) = (self.scene, vec![plan::steps(self.scene)]);
        let dt = scene.time.step;
        lines.extend(self.waves.iter().map(|w| {
            let (period, steps) = (rounded(w.period, 3), rounded(w.period / dt, 3));
            format!("elastic wave of `{}` at the start: period {period}, {steps} steps", w.name)
        }));
        let Limits { explicit_limit: now, stretched_limit: stretched, .. } = self.limits;
        let Some(limit) = now.into_iter().chain(stretched).reduce(f64::min) else { return lines };
        let ratio = dt / limit;
        let said =
            |limit: f64| format!("{limit:.3e}; the step is {} of it", rounded(dt / limit, 3));
        lines.push(match now {
            Some(limit) => format!("explicit step limit (1.54) at the start: {}", said(limit)),
            None => "explicit step limit (1.54): none at the start, no tension yet".into(),
        });
        lines.extend(stretched.map(|limit| {
            let strain = 100.0 * FIRST_STRETCH;
            format!("explicit step limit (1.54) at a stretch of {strain} %: {}", said(limit))
        }));
        let sheared = scene.acting().any(|s| s.traits().resists_shear);
        lines.extend(match scene.numerics.coupling {
            Coupling::Explicit if ratio > 1.0 && sheared => Some(
                "with shear the explicit coupling was found stable to 1.4 to 4.1 times this: if \
                 the energy rises, take a smaller step, or coupling = \"implicit\"",
            ),
            Coupling::Explicit if ratio > 1.0 => {
                Some("the explicit coupling will be unstable: take a smaller step, or coupling \
                    = \"implicit\"")
            }
            Coupling::FullyExplicit => {
                Some("the fully explicit coupling is unstable without viscosity, with any step: \
                    remark 1.12")
            }
            Coupling::Explicit if scene.numerics.has_continuum_force() => {
                Some("the continuum force is not the derivative of an energy: with little \
                    viscosity it wins energy with any step")
            }
            Coupling::Explicit => None,
            Coupling::SemiImplicit if self.is_stiff() => {
                Some("the semi-implicit coupling is made for constant tension: with another law \
                    prefer coupling = \"implicit\"")
            }
            Coupling::SemiImplicit => Some("the semi-implicit coupling is not bound by it"),
            Coupling::Implicit => Some("the implicit coupling is not bound by it"),
        }.map(String::from));
        lines
    }

    /// True if density or viscosity jump across an interface, which needs a band.
    fn is_stepped(&self) -> bool {
        let outside = self.scene.outside();
        self.scene.fluids().any(|f| f != outside)
            || self.scene.acting().any(|s| s.traits().mass > 0.0)
    }
    /// True if some structure has more than a constant tension.
    fn is_stiff(&self) -> bool {
        self.scene.acting().any(|s| !s.traits().constant_tension)
    }
}

fn both(c: Contrast) -> String {
    match c.is_uniform() {
        true => c.outside.to_string(),
        false => format!("{} inside, {} outside", c.inside, c.outside),
    }
}
