//! `[numerics]`: numerical methods.

use super::redistance::Redistance;
use crate::base::Result;
use crate::elastic::Band;
use crate::fem::Element;
use crate::levelset::{Kernel, Norm};
use crate::scene::keys::{
    Auto, Context, Count, Form, Item, Kind, Nested, NonNegative, Opt, OrFalse, Positive, Table,
    Tabled, Writer, kinds, table, words,
};
use crate::sim::{ConvectionScheme, Coupling, SolverKind, SolverOptions};
use crate::transport::Method;

table! {
    /// How the equations are solved. What "auto" stands for is printed by `immersa explain SCENE`.
    Numerics: Copy {
        /// Half width of the band around an interface. The error it makes is of first order in it.
        thickness: Option<f64> [Auto<Positive>, "m"],
        /// Over which values of its level set a membrane is spread: of the same width whatever the
        /// stretch, or carried with the fluid. "auto" carries it for constant tension.
        band: Option<Band> [Auto<Bands>],
        /// The cut-off function that spreads the force of a membrane over its band: (1 + cos(pi
        /// s))/2 or 1 - |s|. Density and viscosity keep the first.
        kernel: Kernel [Kernels, Default("cosine")],
        /// What a renormalised band measures the slope of its level set with: the length of the
        /// gradient, or the sum of the moduli of its components, which makes the band up to sqrt(2)
        /// times as wide, in space sqrt(3), where the interface is not along an axis.
        width: Norm [Norms, Default("l2")],
        /// Weight of the grad-div term, which keeps the divergence small.
        grad_div: Option<f64> [Auto<NonNegative>, "Pa s"],
        /// How level sets are carried: by values at the nodes, projected, or composed with a chain
        /// of short backward maps, which never interpolates them but needs a domain that nothing
        /// flows into.
        transport: Method [Transports, Default("nodal")],
        /// With composed transport, the gradient of the displacement of a short map beyond which
        /// the next one begins.
        remap: Option<f64> [Auto<Positive>],
        /// How the force of a membrane enters a step: at the old interface, at one that is
        /// predicted by implicit diffusion (the book's semi-implicit scheme, for constant tension
        /// and `time.order = 1`), or linearised in the new velocity. "fully-explicit" carries the
        /// interface with the old velocity as well (remark 1.12): unstable without viscosity, there
        /// to show it.
        coupling: Coupling [Couplings, Default("implicit")],
        /// For scenes of constant tension, the published scheme that force and coupling are taken
        /// from: the continuum surface force (1.32) of Brackbill, Kothe and Zemach 1992, which
        /// takes the curvature from second derivatives; the stress in divergence form of Lafaurie
        /// et al. 1994, explicit; the same implicit in the velocity after Baensch 2001, as
        /// "implicit" coupling; the semi-implicit scheme (1.60)-(1.62) of Cottet and Maitre 2016.
        /// In place of `coupling`.
        surface_tension: Option<TensionScheme> [Opt<Tensions>,
            Derived("the stress of \"lafaurie1994\", entering a step as `coupling` says")],
        /// Elements of the pressure: continuous and linear, or with a constant of each cell added,
        /// which can jump and conserves the volume of each cell; in the plane alone.
        pressure: Element [Pressures, Default("P1")],
        /// How velocity carries itself, after its source, or false for not at all: along
        /// characteristics (Pironneau 1982), stable for any step; implicit with the extrapolated
        /// velocity (Baker, Dougalis and Karakashian 1982), whose steady states do not depend on
        /// the step; or explicit, extrapolated (Karniadakis, Israeli and Orszag 1991), stable below a
        /// Courant number of about .3. "auto": nothing without inertia; implicit for a flow without
        /// structures above Reynolds number 10 or of order 3; along characteristics otherwise.
        convection: Option<Option<ConvectionScheme>> [Auto<OrFalse<Convections>>],
        /// Where the matrix changes from step to step, it is solved for by GMRES with an older
        /// factor, to this relative residual, as long as that costs less than factoring. 0 factors
        /// every matrix. "auto": 1e-10; 1e-6 with `convection = "baker1982"`, where it moves forces
        /// by 1e-5 of themselves.
        solve_tolerance: Option<f64> [Auto<SolveTolerance>],
        /// How the linear systems of the flow are solved: with a factor of the whole matrix; by
        /// iterations with one in single precision, half as large; or by more iterations with
        /// scalar factors and a Schur complement, in a fifth of the memory (in space). "auto" takes
        /// the first that fits into the memory.
        solver: Option<SolverKind> [Solvers, Default("auto")],
        /// Memory that the factors of the flow may take. "auto": what the machine can give when the
        /// run begins. A run that is to be the same everywhere names `solver`.
        memory: Option<f64> [Auto<Positive>, "GB"],
        /// Degree of the polynomials that quadrature integrates exactly.
        quadrature: Option<usize> [Auto<Count<1, 20>>],
        /// Makes level sets distances again. Not for smeared elastic membranes, whose stretch is the
        /// slope of their level set. Without it those of sharp forces are, when their slope changes.
        redistance: Option<Redistance> [Opt<Nested<Redistance>>],
    } check Numerics::check; hide Numerics::hides;
}

/// A published scheme of surface tension.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TensionScheme {
    /// True if the force is the continuum force `-lambda H n delta` with the curvature, no stress.
    pub by_curvature: bool,
    /// Its coupling to the flow in a step.
    pub coupling: Coupling,
}

words! {
    Tensions: TensionScheme {
        "brackbill1992" = TensionScheme { by_curvature: true, coupling: Coupling::Explicit },
        "lafaurie1994" = TensionScheme { by_curvature: false, coupling: Coupling::Explicit },
        "baensch2001" = TensionScheme { by_curvature: false, coupling: Coupling::Implicit },
        "cottet2016" = TensionScheme { by_curvature: false, coupling: Coupling::SemiImplicit },
    }
}
words! {
    Convections: ConvectionScheme {
        "pironneau1982" = ConvectionScheme::Characteristics,
        "baker1982" = ConvectionScheme::Implicit,
        "karniadakis1991" = ConvectionScheme::Explicit,
    }
}
words! { Pressures: Element { "P1" = Element::P1, "P1+P0" = Element::P1P0 } }
words! { Bands: Band { "renormalised" = Band::Renormalised, "carried" = Band::Carried } }
words! { Kernels: Kernel { "cosine" = Kernel::Cosine, "hat" = Kernel::Hat } }
words! { Norms: Norm { "l2" = Norm::L2, "l1" = Norm::L1 } }
words! {
    Transports: Method {
        "nodal" = Method::Nodal, "projected" = Method::Projected, "composed" = Method::Composed,
    }
}
words! {
    Couplings: Coupling {
        "fully-explicit" = Coupling::FullyExplicit,
        "explicit" = Coupling::Explicit,
        "semi-implicit" = Coupling::SemiImplicit,
        "implicit" = Coupling::Implicit,
    }
}
words! {
    Solvers: Option<SolverKind> {
        "auto" = None, "direct" = Some(SolverKind::Direct), "single" = Some(SolverKind::Single), "schur" = Some(SolverKind::Schur),
    }
}
kinds! {
    /// A relative residual.
    SolveTolerance: f64 = Kind::Value(
        "number from 0 to 1e-6",
        Form::Number { least: 0.0, most: LARGEST_SOLVE_TOLERANCE, open: false },
    ), solve_tolerance;
}
const GIGABYTE: f64 = 1e9;
const SOLVE_TOLERANCE: f64 = 1e-10;
const LARGEST_SOLVE_TOLERANCE: f64 = 1e-6;

impl Numerics {
    /// True if surface tension is a continuum force and not a stress.
    pub fn has_continuum_force(&self) -> bool {
        self.surface_tension.is_some_and(|s| s.by_curvature)
    }

    /// The key that only forces over a band have a use for, if one is given.
    pub fn key_of_band(&self) -> Option<&'static str> {
        self.keys_of_band().next()
    }
    /// The keys that only forces over a band have a use for, of those that are given.
    pub fn keys_of_band(&self) -> impl Iterator<Item = &'static str> {
        let keys = [
            ("surface_tension", self.surface_tension.is_some()),
            ("coupling", self.coupling == Coupling::SemiImplicit),
            ("band", self.band.is_some()),
            ("kernel", self.kernel != Kernel::default()),
            ("width", self.width != Norm::default()),
        ];
        keys.into_iter().filter_map(|(key, given)| given.then_some(key))
    }

    /// The solver for the linear systems of the flow, and its memory limit.
    pub fn solver(&self) -> SolverOptions {
        let memory = self.memory.map(|gigabytes| (gigabytes * GIGABYTE) as usize);
        SolverOptions { kind: self.solver, memory, ..SolverOptions::default() }
    }

    /// Sets the coupling of a published scheme, beside which no other one may be given.
    fn check(&mut self, table: &Table<'_>, _: &Context) -> Result<()> {
        let Some(scheme) = self.surface_tension else { return Ok(()) };
        self.coupling = scheme.coupling;
        table.get("coupling").map_or(Ok(()), |item| {
            Err(item
                .key_error(
                    "`surface_tension` says how the force enters a step, and so does `coupling`",
                )
                .remedy("keep one of the two"))
        })
    }

    /// True for keys that this table omits: redistancing, which has its own header, and the
    /// coupling of a published scheme.
    fn hides(&self, key: &str) -> bool {
        key == "redistance" || key == "coupling" && self.surface_tension.is_some()
    }

    pub(in crate::scene) fn write(&self, out: &mut Writer) {
        self.section("[numerics]", out);
        self.redistance.iter().for_each(|r| r.section("[numerics.redistance]", out));
    }
}

fn solve_tolerance(item: &Item, _: &Context) -> Result<f64> {
    let tolerance = item.non_negative()?;
    if tolerance <= LARGEST_SOLVE_TOLERANCE {
        return Ok(tolerance);
    }
    Err(item
        .error(format!(
            "a relative residual of {tolerance} is too large: it would be the largest error of a \
             step"
        ))
        .remedy(format!(
            "give a number up to {LARGEST_SOLVE_TOLERANCE:e}, or leave it out for \
             {SOLVE_TOLERANCE:e}"
        )))
}
