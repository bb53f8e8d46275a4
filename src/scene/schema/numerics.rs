//! `[numerics]`: how the equations are solved.

use super::redistance::{self, Redistance};
use crate::base::Result;
use crate::elastic::Band;
use crate::fem::Element;
use crate::levelset::{Kernel, Norm};
use crate::scene::keys::Item;
use crate::scene::keys::{Absent::*, Keys, Kind::*, row, words};
use crate::scene::keys::{Writer, name, number, or_auto};
use crate::sim::{Coupling, SolverKind, SolverOptions};
use crate::transport::Method;

/// Settings of the method; `None` means that the plan decides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Numerics {
    /// Half width of the band around an interface, a length.
    pub thickness: Option<f64>,
    /// Over which values of its level set a membrane is spread; `None` lets its law decide.
    pub band: Option<Band>,
    /// The cut-off function of bands.
    pub kernel: Kernel,
    /// What a renormalised band measures slopes with.
    pub width: Norm,
    /// Weight of the grad-div term, in units of viscosity.
    pub grad_div: Option<f64>,
    /// How level sets are carried.
    pub transport: Method,
    /// With composed transport, the steepness `|grad d|` of a short map `x + d(x)` beyond which the next one begins.
    pub remap: Option<f64>,
    /// How the force of a membrane enters a step.
    pub coupling: Coupling,
    /// The published scheme of surface tension, where the scene names one; [`coupling`](Self::coupling) is then its coupling.
    pub surface_tension: Option<TensionScheme>,
    /// The elements of the pressure.
    pub pressure: Element,
    /// Whether velocity carries itself.
    pub convection: Option<bool>,
    /// Relative residual of iterations with an old factor; 0 factors every matrix.
    pub solve_tolerance: f64,
    /// How the linear systems of the flow are solved, and in how much memory.
    pub solving: SolverOptions,
    /// Degree of polynomials that quadrature integrates exactly.
    pub quadrature: Option<usize>,
    /// How and when level sets become distances again; `None` for never.
    pub redistance: Option<Redistance>,
}

/// A published scheme of surface tension.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TensionScheme {
    /// Whether the force is the continuum force `-lambda H n delta`, with the curvature, and not a stress.
    pub continuum: bool,
    /// How it enters a step.
    pub coupling: Coupling,
}

const TENSIONS: [(&str, TensionScheme); 4] = [
    ("brackbill1992", TensionScheme { continuum: true, coupling: Coupling::Explicit }),
    ("lafaurie1994", TensionScheme { continuum: false, coupling: Coupling::Explicit }),
    ("baensch2001", TensionScheme { continuum: false, coupling: Coupling::Implicit }),
    ("cottet2016", TensionScheme { continuum: false, coupling: Coupling::SemiImplicit }),
];
const TENSION_WORDS: [&str; TENSIONS.len()] = words(&TENSIONS);
const PRESSURES: [(&str, Element); 2] = [("P1", Element::P1), ("P1+P0", Element::P1P0)];
const PRESSURE_WORDS: [&str; PRESSURES.len()] = words(&PRESSURES);
const BANDS: [(&str, Band); 2] = [("renormalised", Band::Renormalised), ("carried", Band::Carried)];
const KERNELS: [(&str, Kernel); 2] = [("cosine", Kernel::Cosine), ("hat", Kernel::Hat)];
const NORMS: [(&str, Norm); 2] = [("l2", Norm::L2), ("l1", Norm::L1)];
const TRANSPORTS: [(&str, Method); 3] =
    [("nodal", Method::Nodal), ("projected", Method::Projected), ("composed", Method::Composed)];
const COUPLINGS: [(&str, Coupling); 4] = [
    ("fully-explicit", Coupling::FullyExplicit),
    ("explicit", Coupling::Explicit),
    ("semi-implicit", Coupling::SemiImplicit),
    ("implicit", Coupling::Implicit),
];
const WAYS: [(&str, Option<SolverKind>); 4] = [
    ("auto", None),
    ("direct", Some(SolverKind::Direct)),
    ("single", Some(SolverKind::Single)),
    ("schur", Some(SolverKind::Schur)),
];
const BAND_WORDS: [&str; BANDS.len()] = words(&BANDS);
const KERNEL_WORDS: [&str; KERNELS.len()] = words(&KERNELS);
const NORM_WORDS: [&str; NORMS.len()] = words(&NORMS);
const TRANSPORT_WORDS: [&str; TRANSPORTS.len()] = words(&TRANSPORTS);
const COUPLING_WORDS: [&str; COUPLINGS.len()] = words(&COUPLINGS);
const WAY_WORDS: [&str; WAYS.len()] = words(&WAYS);
const GIGABYTE: f64 = 1e9;
const MOST_DEGREE: usize = 20;
const SOLVE_TOLERANCE: f64 = 1e-10;
const LARGEST_SOLVE_TOLERANCE: f64 = 1e-6;

pub(in crate::scene) static KEYS: Keys = Keys {
    about: "How the equations are solved. What \"auto\" stands for is printed by `immersa explain SCENE`.",
    keys: &[
        row(
            "thickness",
            Value("number > 0"),
            "m",
            Auto,
            "Half width of the band around an interface. The error it makes is of first order in it.",
        ),
        row(
            "band",
            Choice(&BAND_WORDS),
            "",
            Auto,
            "Over which values of its level set a membrane is spread: of the same width \
            whatever the stretch, or carried with the fluid. \"auto\" carries it for constant tension.",
        ),
        row(
            "kernel",
            Choice(&KERNEL_WORDS),
            "",
            Default("\"cosine\""),
            "The cut-off function that spreads the force of a membrane over its band: (1 + cos(pi s))/2 or 1 - |s|. Density and viscosity keep the first.",
        ),
        row(
            "width",
            Choice(&NORM_WORDS),
            "",
            Default("\"l2\""),
            "What a renormalised band measures the slope of its level set with: the length of the gradient, or the sum of the moduli of its \
             components, which makes the band up to sqrt(2) times as wide, in space sqrt(3), where the interface is not along an axis.",
        ),
        row(
            "grad_div",
            Value("number >= 0"),
            "Pa s",
            Auto,
            "Weight of the grad-div term, which keeps the divergence small.",
        ),
        row(
            "transport",
            Choice(&TRANSPORT_WORDS),
            "",
            Default("\"nodal\""),
            "How level sets are carried: by values at the nodes, projected, or composed with a chain of short backward maps, which never \
             interpolates them but needs a domain that nothing flows into.",
        ),
        row(
            "remap",
            Value("number > 0"),
            "",
            Auto,
            "With composed transport, the gradient of the displacement of a short map beyond which the next one begins.",
        ),
        row(
            "coupling",
            Choice(&COUPLING_WORDS),
            "",
            Default("\"implicit\""),
            "How the force of a membrane enters a step: at the old interface, at one that is predicted by implicit \
            diffusion (the book's semi-implicit scheme, for constant tension and `time.order = 1`), or linearised in the new velocity. \
            \"fully-explicit\" carries the interface with the old velocity as well (remark 1.12): unstable without viscosity, there to show it.",
        ),
        row(
            "surface_tension",
            Choice(&TENSION_WORDS),
            "",
            Derived("the stress of \"lafaurie1994\", entering a step as `coupling` says"),
            "For scenes of constant tension, the published scheme that force and coupling are taken from: the continuum surface force (1.32) \
             of Brackbill, Kothe and Zemach 1992, which takes the curvature from second derivatives; the stress in divergence form of \
             Lafaurie et al. 1994, explicit; the same implicit in the velocity after Baensch 2001, as \"implicit\" coupling; the semi-implicit \
             scheme (1.60)-(1.62) of Cottet and Maitre 2016. In place of `coupling`.",
        ),
        row(
            "pressure",
            Choice(&PRESSURE_WORDS),
            "",
            Default("\"P1\""),
            "Elements of the pressure: continuous and linear, or with a constant of each cell added, which can jump and conserves the volume \
             of each cell; in the plane alone.",
        ),
        row(
            "convection",
            Value("true or false"),
            "",
            Auto,
            "Whether velocity carries itself. \"auto\": where there is inertia.",
        ),
        row(
            "solve_tolerance",
            Value("number from 0 to 1e-6"),
            "",
            Default("1e-10"),
            "Where the matrix changes from step to step, it is solved for by GMRES with an older factor, to this relative residual, as long \
             as that costs less than factoring. 0 factors every matrix.",
        ),
        row(
            "solver",
            Choice(&WAY_WORDS),
            "",
            Default("\"auto\""),
            "How the linear systems of the flow are solved: with a factor of the whole matrix; by iterations with one in single precision, half as \
             large; or by more iterations with scalar factors and a Schur complement, in a fifth of the memory (in space). \"auto\" takes the first that fits into the memory.",
        ),
        row(
            "memory",
            Value("number > 0"),
            "GB",
            Auto,
            "Memory that the factors of the flow may take. \"auto\": what the machine can give when the run begins. A run that is to be the same \
             everywhere names `solver`.",
        ),
        row(
            "quadrature",
            Value("whole number from 1 to 20"),
            "",
            Auto,
            "Degree of the polynomials that quadrature integrates exactly.",
        ),
        row(
            "redistance",
            Table(&redistance::KEYS),
            "",
            Optional,
            "Makes level sets distances again. Not for elastic membranes, whose stretch is the slope of their level set.",
        ),
    ],
};

impl Numerics {
    /// Whether surface tension is a continuum force, and no stress.
    pub fn has_continuum_force(&self) -> bool {
        self.surface_tension.is_some_and(|s| s.continuum)
    }

    pub(in crate::scene) fn read(item: Option<Item>) -> Result<Numerics> {
        let mut numerics = Numerics {
            thickness: None,
            band: None,
            kernel: Kernel::default(),
            width: Norm::default(),
            grad_div: None,
            transport: Method::Nodal,
            remap: None,
            coupling: Coupling::Implicit,
            surface_tension: None,
            pressure: Element::P1,
            convection: None,
            solve_tolerance: SOLVE_TOLERANCE,
            solving: SolverOptions::default(),
            quadrature: None,
            redistance: None,
        };
        let Some(item) = item else { return Ok(numerics) };
        let table = item.table(&KEYS)?;
        let degree = |i: &Item| i.count(1, MOST_DEGREE);
        numerics.thickness = table.optional("thickness", |i| i.unless_auto(Item::positive))?.flatten();
        numerics.band = table.optional("band", |i| i.unless_auto(|i| i.choice(&BANDS)))?.flatten();
        numerics.kernel = table.optional("kernel", |i| i.choice(&KERNELS))?.unwrap_or_default();
        numerics.width = table.optional("width", |i| i.choice(&NORMS))?.unwrap_or_default();
        numerics.grad_div = table.optional("grad_div", |i| i.unless_auto(Item::non_negative))?.flatten();
        numerics.transport = table.optional("transport", |i| i.choice(&TRANSPORTS))?.unwrap_or(numerics.transport);
        numerics.remap = table.optional("remap", |i| i.unless_auto(Item::positive))?.flatten();
        numerics.coupling = table.optional("coupling", |i| i.choice(&COUPLINGS))?.unwrap_or(numerics.coupling);
        numerics.surface_tension = table.optional("surface_tension", |i| i.choice(&TENSIONS))?;
        if let Some(scheme) = numerics.surface_tension {
            if let Some(item) = table.get("coupling") {
                return Err(item
                    .key_error("`surface_tension` says how the force enters a step, and so does `coupling`")
                    .remedy("keep one of the two"));
            }
            numerics.coupling = scheme.coupling;
        }
        numerics.pressure = table.optional("pressure", |i| i.choice(&PRESSURES))?.unwrap_or(numerics.pressure);
        numerics.convection = table.optional("convection", |i| i.unless_auto(Item::boolean))?.flatten();
        numerics.solve_tolerance = table.optional("solve_tolerance", solve_tolerance)?.unwrap_or(SOLVE_TOLERANCE);
        numerics.solving.kind = table.optional("solver", |i| i.choice(&WAYS))?.flatten();
        let memory = table.optional("memory", |i| i.unless_auto(Item::positive))?.flatten();
        numerics.solving.memory = memory.map(|gigabytes| (gigabytes * GIGABYTE) as usize);
        numerics.quadrature = table.optional("quadrature", |i| i.unless_auto(degree))?.flatten();
        numerics.redistance = table.optional("redistance", Redistance::read)?;
        Ok(numerics)
    }

    pub(in crate::scene) fn write(&self, out: &mut Writer) {
        out.header("[numerics]");
        out.entry("thickness", or_auto(self.thickness, number));
        out.entry("band", or_auto(self.band, |b| name(b, &BANDS).to_string()));
        out.entry("kernel", name(self.kernel, &KERNELS));
        out.entry("width", name(self.width, &NORMS));
        out.entry("grad_div", or_auto(self.grad_div, number));
        out.entry("transport", name(self.transport, &TRANSPORTS));
        out.entry("remap", or_auto(self.remap, number));
        match self.surface_tension {
            Some(scheme) => out.entry("surface_tension", name(scheme, &TENSIONS)),
            None => out.entry("coupling", name(self.coupling, &COUPLINGS)),
        }
        out.entry("pressure", name(self.pressure, &PRESSURES));
        out.entry("convection", or_auto(self.convection, |c| c.to_string()));
        out.entry("solve_tolerance", number(self.solve_tolerance));
        out.entry("solver", name(self.solving.kind, &WAYS));
        out.entry("memory", or_auto(self.solving.memory, |bytes| number(bytes as f64 / GIGABYTE)));
        out.entry("quadrature", or_auto(self.quadrature, |d| d.to_string()));
        self.redistance.iter().for_each(|r| r.write(out));
    }
}

fn solve_tolerance(item: &Item) -> Result<f64> {
    let tolerance = item.non_negative()?;
    if tolerance <= LARGEST_SOLVE_TOLERANCE {
        return Ok(tolerance);
    }
    Err(item
        .error(format!("a relative residual of {tolerance} is too large: it would be the largest error of a step"))
        .remedy(format!("give a number up to {LARGEST_SOLVE_TOLERANCE:e}, or leave it out for {SOLVE_TOLERANCE:e}")))
}
