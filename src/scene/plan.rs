//! The plan: what a scene solves, what it leaves out and why, and how large that is.

use super::Scene;
use super::adapt::Lengths;
use super::diagnostics::has_backward_map;
use super::dimension::{Dimension, In};
use super::model::{Model, band_of};
use super::redistance::in_words;
use super::schema::{Adapt, Condition, Contrast, Image, Membrane, MeshSource};
use crate::base::Result;
use crate::elastic::{AreaFrom, AreaLaw, Band, Force, ShearLaw, SurfaceLaw};
use crate::fem::Element;
use crate::mesh::Point;
use crate::sim::Coupling;
use crate::transport::Method;
use std::fmt::Write;

impl<const D: usize> Model<D>
where
    In<D>: Dimension<D>,
{
    /// The plan of this model as plain text, ready to print. Analyses the matrix, but does not factor it.
    pub fn plan(&mut self, scene: &Scene) -> Result<String> {
        self.simulation.analyse()?;
        let mut text = String::new();
        for (heading, lines) in [
            ("Mesh", mesh(self, scene)),
            ("Solved", solved(self, scene)),
            ("Unknowns", unknowns(self)),
            ("Numerics", numerics(self, scene)),
            ("Left out", left_out(self, scene)),
            ("Steps", steps(self, scene)),
        ] {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{heading}");
            for line in lines {
                let _ = writeln!(text, "  {line}");
            }
        }
        Ok(text)
    }
}

fn mesh<const D: usize>(model: &Model<D>, scene: &Scene) -> Vec<String>
where
    In<D>: Dimension<D>,
{
    let mesh = model.simulation.space().mesh();
    let (lo, hi) = mesh.bounding_box();
    let source = match &scene.mesh {
        MeshSource::File { path, refine: 0, .. } => format!("{}", path.display()),
        MeshSource::File { path, refine, .. } => {
            let (cell, parts) = if D == 2 { ("triangle", 4usize) } else { ("tetrahedron", 8) };
            format!("{}, every {cell} cut into {}", path.display(), parts.saturating_pow(*refine as u32))
        }
        MeshSource::Rectangle { cells, .. } => format!("rectangle of {} x {} squares", cells[0], cells[1]),
        MeshSource::Disc { cells, .. } => format!("disc with {cells} cells along a radius"),
        MeshSource::Box { cells: [x, y, z], .. } => format!("box of {x} x {y} x {z} boxes"),
        MeshSource::BallInBox { cells: [x, y, z], edge, .. } => {
            format!("box of {x} x {y} x {z} boxes, cut to edges of {edge} about a sphere")
        }
    };
    let names: Vec<&str> = mesh.boundaries().keys().map(String::as_str).collect();
    let q = &model.quality;
    let adapted = scene.adapt.as_ref().zip(model.lengths.as_ref());
    let made = if adapted.is_some() { ", adapted" } else { "" };
    let mut lines = vec![
        format!("{source}{made}: {} {}, {} points", mesh.cell_count(), In::<D>::CELLS, mesh.points().len()),
        format!("from ({}) to ({})", listed(&lo), listed(&hi)),
        format!("edges up to {:.4}, smallest angle {:.1} degrees", q.greatest_diameter.value, q.smallest_angle.value),
        format!("boundary names: {}", names.join(", ")),
    ];
    lines.extend(adapted.map(|(adapt, lengths)| follows(adapt, lengths)));
    lines
}

/// The coordinates of a point, with commas.
fn listed<const D: usize>(x: &Point<D>) -> String {
    x.iter().map(f64::to_string).collect::<Vec<_>>().join(", ")
}

/// How the mesh follows, in words.
fn follows(adapt: &Adapt, lengths: &Lengths) -> String {
    let Lengths { edge, along, width, longest } = lengths;
    let when =
        adapt.every.map_or("at the start alone".into(), |every| format!("at the start and looked at every {every}"));
    let growth = adapt.gradation;
    let mut text = format!(
        "adapted {when}: edges of {edge:.4} across and {along:.4} along, up to {width:.4} from the interfaces, then growing by {growth} each to {longest:.4}"
    );
    if !adapt.fields.is_empty() {
        let target = match adapt.vertices {
            Some(count) => format!("{count} points"),
            None => format!("an interpolation error of {}", adapt.error),
        };
        text += &format!("; by the second derivatives of {} field kinds for {target}", adapt.fields.len());
    }
    text
}

fn solved<const D: usize>(model: &Model<D>, scene: &Scene) -> Vec<String> {
    let sim = &model.simulation;
    if let Some(image) = &scene.image {
        return segmentation(model, scene, image);
    }
    if let Some(velocity) = &scene.fluid.prescribed_velocity {
        return passive(scene, velocity);
    }
    let mut lines = Vec::new();
    lines.push(match (sim.is_stokes(), sim.settings().convection) {
        (true, _) => "Stokes flow (density 0): -div(2 mu D(u)) + grad p = F, div u = 0".to_string(),
        (false, true) => "Navier-Stokes flow (3.20)-(3.21): rho Du/Dt - div(2 mu D(u)) + grad p = F, div u = 0".into(),
        (false, false) => {
            "unsteady Stokes flow (convection = false): rho du/dt - div(2 mu D(u)) + grad p = F, div u = 0".into()
        }
    });
    lines.push(format!("density {}, viscosity {}", both(scene.fluid.density), both(scene.fluid.viscosity)));
    lines.extend(scene.membranes.iter().flat_map(membrane));
    lines.extend(level_sets(scene));
    for b in &scene.boundaries {
        let condition = match &b.condition {
            Condition::Velocity(v) => {
                let v: Vec<&str> = v.iter().map(super::Expression::text).collect();
                format!("velocity ({})", v.join(", "))
            }
            Condition::NoSlip => "no slip".into(),
            Condition::Slip => "slip".into(),
            Condition::Open => "open (no stress)".into(),
            Condition::Periodic(other) => format!("periodic with {other}"),
        };
        lines.push(format!("boundary {}: {condition}", b.name));
    }
    if sim.flow().is_some_and(|flow| !flow.numbering().is_open()) {
        lines.push("no boundary is open: the pressure has zero mean".into());
    }
    lines
}

/// What a membrane is, in words.
fn membrane(m: &Membrane) -> Vec<String> {
    let area = |law| match law {
        AreaLaw::Linear { modulus } => format!("E'(r) = {modulus} (r - 1)"),
        AreaLaw::OneSided { modulus } => format!("E'(r) = {modulus} max(r - 1, 0)"),
        AreaLaw::Tension { tension } => format!("constant tension {tension}"),
    };
    let mass = if m.mass > 0.0 { format!(", surface mass {} (3.19)", m.mass) } else { String::new() };
    let (name, stretch) = (&m.name, m.stretch);
    if let Some(drop) = &m.drop {
        let own = [("density", drop.density), ("viscosity", drop.viscosity)];
        let own = own.iter().filter_map(|(what, value)| Some(format!(", {what} {} inside", (*value)?)));
        let own: String = own.collect();
        return vec![format!("drop `{name}`: surface tension {}{own}; its level set by (1.34)", m.area.tension(1.0))];
    }
    let Some(law) = m.surface else {
        let law = area(m.area);
        return vec![format!(
            "membrane `{name}`: stress (3.16) with {law}, initial stretch {stretch}{mass}; its level set by (3.22)"
        )];
    };
    let law = match law {
        SurfaceLaw::Split { area: first, shear } => {
            let shear = match shear {
                ShearLaw::Linear { modulus } => format!("E2'(Z2) = {modulus} (Z2 - 1)"),
                ShearLaw::NeoHookean { modulus } => format!("E2'(Z2) = {modulus}"),
            };
            format!("{} and {shear}", area(first))
        }
        SurfaceLaw::NeoHookean { modulus } => format!("the neo-Hookean law, G = {modulus}"),
        SurfaceLaw::Skalak { modulus, area_ratio } => format!("Skalak's law, G = {modulus}, C = {area_ratio}"),
    };
    let level_set = if m.mapped { "phi0(Y) (3.32)" } else { "carried by (3.31)" };
    let from = match m.area_from {
        AreaFrom::Slope => "|grad phi| (3.42)",
        AreaFrom::Map => "the map (3.40)",
    };
    let mut lines = vec![
        format!("membrane `{name}`: forces F1 + F2 (3.47) with {law}, initial stretch {stretch}{mass}"),
        format!("its level set {level_set}, Z1 from {from}, Z2 from the backward characteristics Y by (3.38), (3.41)"),
    ];
    if !m.map.is_empty() {
        let map: Vec<&str> = m.map.iter().map(super::Expression::text).collect();
        lines.push(format!("at rest its material is at ({})", map.join(", ")));
    }
    lines
}

fn unknowns<const D: usize>(model: &Model<D>) -> Vec<String> {
    let sim = &model.simulation;
    let mut lines = Vec::new();
    let level_sets = sim.structures().len() + sim.passive().len();
    let level_sets = (level_sets > 0).then(|| format!("level sets {level_sets} x {} (P2)", sim.space().len()));
    let Some(flow) = sim.flow() else {
        lines.extend(level_sets);
        lines.extend(map_memory(model));
        lines.push(format!("no matrix of a flow; memory about {:.0} MB", sim.bytes() as f64 / 1e6));
        return lines;
    };
    let numbering = flow.numbering();
    let velocity = numbering.first_pressure();
    let pressure = numbering.order() - velocity;
    let element = if sim.settings().pressure == Element::P1P0 { "P1 + P0" } else { "P1" };
    lines.push(format!("velocity {velocity} (P2), pressure {pressure} ({element})"));
    lines.extend(level_sets);
    if sim.has_backward_map() {
        lines.push(format!("backward characteristics {} x {} (P2)", D, sim.space().len()));
    }
    lines.extend(map_memory(model));
    let implicit = sim.settings().coupling == Coupling::Implicit && !sim.structures().is_empty();
    let constant = flow.density().is_constant() && flow.viscosity().is_constant();
    let (kind, why) = match (constant, implicit) {
        (true, false) => ("constant", "factored once".to_string()),
        (true, true) => ("changes with the interface (implicit coupling)", flow.way_of_solving()),
        (false, _) => ("changes with density or viscosity", flow.way_of_solving()),
    };
    lines.push(format!("matrix {kind}: {why}"));
    lines.extend(flow.way_in_words());
    if let Some((_, factor)) = flow.solver_size() {
        lines.push(format!(
            "matrix {} entries (one triangle), LDL^T factor {} entries; memory about {:.0} MB, of which factors {:.0} MB",
            flow.matrix_nonzeros(),
            factor.entries,
            sim.bytes() as f64 / 1e6,
            sim.factor_bytes() as f64 / 1e6
        ));
    }
    lines
}

/// What is carried by a prescribed velocity.
fn passive(scene: &Scene, velocity: &[super::Expression]) -> Vec<String> {
    let v: Vec<&str> = velocity.iter().map(super::Expression::text).collect();
    let mut lines = vec![format!("no flow: the velocity is prescribed as ({})", v.join(", "))];
    lines.extend(level_sets(scene));
    for b in &scene.boundaries {
        if let Condition::Periodic(other) = &b.condition {
            lines.push(format!("boundary {}: periodic with {other}", b.name));
        }
    }
    lines
}

/// What is done to an image.
fn segmentation<const D: usize>(model: &Model<D>, scene: &Scene, image: &Image) -> Vec<String> {
    let names = scene.interfaces().map(|(name, _)| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    let (alpha, beta, eps) = (image.fidelity, image.length, model.thickness.unwrap_or(f64::NAN));
    vec![
        format!(
            "no flow: the level set {names} segments the image {}, side of a pixel {}",
            image.path.display(),
            image.pixel
        ),
        format!(
            "it descends along {alpha} E1 + {beta} E2, misfit and length, by (1.29) with c1 and c2 the mean levels inside and outside"
        ),
        format!("its zero line moves by {eps} in a step at most, and finds only objects that it comes by"),
    ]
}

fn level_sets(scene: &Scene) -> impl Iterator<Item = String> + '_ {
    scene.level_sets.iter().map(|s| {
        let markers = if s.markers > 0 { format!("; {} markers follow it", s.markers) } else { String::new() };
        format!("level set `{}`: carried by (1.2), acts on nothing{markers}", s.name)
    })
}

/// What the chain of submaps takes: it grows, by one vector field a restart.
fn map_memory<const D: usize>(model: &Model<D>) -> Option<String> {
    let sim = &model.simulation;
    let submap = sim.state().map.as_ref()?.bytes();
    Some(format!(
        "backward map: {:.2} MB a submap (P2); their number grows with the time and is the column `submaps`",
        submap as f64 / 1e6
    ))
}

fn transport<const D: usize>(model: &Model<D>, scene: &Scene) -> String {
    let sim = &model.simulation;
    match sim.settings().transport {
        Method::Nodal => "level set carried to the nodes (nodal)".into(),
        Method::Projected => "level set projected at the quadrature points (projected)".into(),
        Method::Composed => format!(
            "level set composed with the backward map (composed): a new submap when the gradient of its displacement exceeds {}{}",
            sim.remap(),
            if scene.numerics.remap.is_some() { "" } else { " (measured default)" }
        ),
    }
}

fn numerics<const D: usize>(model: &Model<D>, scene: &Scene) -> Vec<String> {
    let s = model.simulation.settings();
    if let (Some(image), Some(eps)) = (&scene.image, model.thickness) {
        let given = if scene.numerics.thickness.is_some() { "" } else { " (derived)" };
        return vec![
            format!("step {}, implicit in the length; one scalar matrix, factored in each step", s.dt),
            match image.rebuild {
                1 => format!("band half-width {eps:.4}{given}; a signed distance again after every step"),
                n => format!("band half-width {eps:.4}{given}; a signed distance again after every {n} steps"),
            },
        ];
    }
    if model.simulation.is_prescribed() {
        let mut lines = vec![
            format!(
                "step {}, characteristics by the Runge-Kutta rule of order 4 through the prescribed velocity",
                s.dt
            ),
            transport(model, scene),
        ];
        lines.extend(in_words(scene));
        return lines;
    }
    let derived = |given: bool| if given { "" } else { " (derived)" };
    let mut lines = vec![match (model.simulation.is_stokes(), s.convection) {
        (true, _) => format!("no time derivative in the flow, step {} of order {}", s.dt, s.order),
        (false, true) => format!("BDF{} along characteristics, step {}", s.order, s.dt),
        (false, false) => format!("BDF{}, step {}", s.order, s.dt),
    }];
    lines.push(format!(
        "grad-div {:.4}{}: keeps the divergence small, which else feeds energy into a membrane",
        s.grad_div,
        match model.velocity_scale {
            Some(u) => format!(" (derived from the velocity scale {u:.4})"),
            None => String::new(),
        }
    ));
    if let (Some(eps), Some([fine, coarse])) = (model.thickness, model.band_edges) {
        let given = derived(scene.numerics.thickness.is_some());
        let edge =
            if coarse - fine > 1e-12 * coarse { format!("{fine:.4} to {coarse:.4}") } else { format!("{fine:.4}") };
        let banded = is_stepped(scene) || scene.membranes.iter().any(|m| m.force == Force::Smeared);
        lines.extend(banded.then(|| {
            let edges = eps / coarse;
            format!("band half-width {eps:.4}{given} on edges of {edge}: {edges:.2} edges; the error it makes is of first order in it")
        }));
        for m in &scene.membranes {
            if m.force == Force::Sharp {
                let along = if m.drop.is_some() { "" } else { ", with the stretch carried along it" };
                lines.extend(
                    (m.area.modulus() > 0.0).then(|| format!("force of `{}` on the interface itself{along}", m.name)),
                );
                continue;
            }
            let given = derived(scene.numerics.band.is_some());
            let continuum = scene.numerics.has_continuum_force();
            lines.push(match band_of(scene, m) {
                Band::Renormalised => {
                    format!("band of `{}` renormalised{given}: of this half-width whatever the stretch", m.name)
                }
                Band::Carried => format!(
                    "band of `{}` carried with the fluid{given}:{} of this half-width at the start",
                    m.name,
                    if continuum { "" } else { " keeps the energy," }
                ),
            });
        }
        lines.push(transport(model, scene));
        lines.push(match s.coupling {
            Coupling::Explicit if scene.numerics.has_continuum_force() => {
                "surface tension as a continuum force (1.32), explicit, with the curvature from recovered second derivatives".into()
            }
            Coupling::Explicit => "membrane force explicit".into(),
            Coupling::FullyExplicit => "membrane force explicit, and the interface carried by the old velocity (remark 1.12)".into(),
            Coupling::SemiImplicit => format!(
                "membrane force semi-implicit (3.62)-(3.64): of a level set predicted by implicit diffusion, its matrix factored {}",
                if is_stiff(scene) || !model.simulation.flow().is_some_and(|flow| flow.density().is_constant()) { "in each step" } else { "once" }
            ),
            Coupling::Implicit => "membrane force implicit in the velocity".into(),
        });
    }
    lines.extend(in_words(scene));
    lines.push(format!("quadrature of degree {}", s.quadrature));
    lines
}

fn left_out<const D: usize>(model: &Model<D>, scene: &Scene) -> Vec<String> {
    let sim = &model.simulation;
    let mut lines = Vec::new();
    if sim.image().is_some() {
        lines.push("flow, pressure and boundary conditions: an image is segmented, and nothing flows");
        lines.extend(third_dimension(D));
        return lines.into_iter().map(String::from).collect();
    }
    if sim.is_prescribed() {
        lines.push("flow, pressure, boundary conditions and every matrix of them: the velocity is prescribed");
        if scene.numerics.redistance.is_none() {
            lines.push("redistancing: the slope of the level set is the stretch of the interface");
        }
        lines.extend(third_dimension(D));
        return lines.into_iter().map(String::from).collect();
    }
    if sim.is_stokes() {
        lines.push("inertia and convection: the density is 0");
    }
    if scene.membranes.is_empty() {
        lines.push("level sets and elastic forces: no structure is immersed");
    } else {
        if !has_backward_map(scene) {
            lines.push("backward characteristics: no shear and no bulk elasticity is asked for");
        }
        if !scene.output.curvature && !scene.numerics.has_continuum_force() {
            lines.push("curvature: no bending is asked for, and the stress form of the tension does not need it");
        }
        if scene.numerics.redistance.is_none() {
            let drops = scene.membranes.iter().all(|m| m.drop.is_some());
            let stretch = "redistancing: the slope of the level set is the stretch of the membrane";
            lines.push(if drops { "redistancing: it is not asked for" } else { stretch });
        }
        if sim.settings().transport == Method::Nodal {
            lines.push("the mass matrix of the level set: nodal transport does not project");
        }
    }
    let is_one_fluid = scene.fluids().all(|f| f == scene.outside());
    if is_one_fluid {
        lines.push("variable density and viscosity: both sides are the same");
    } else if scene.fluid.boussinesq {
        lines.push("variable inertia: the Boussinesq form, in which densities differ in gravity alone");
    }
    lines.extend(third_dimension(D));
    lines.into_iter().map(String::from).collect()
}

fn third_dimension(dimension: usize) -> Option<&'static str> {
    (dimension == 2).then_some("the third dimension: the mesh is plane")
}

fn steps<const D: usize>(model: &Model<D>, scene: &Scene) -> Vec<String> {
    let time = &scene.time;
    let mut lines = vec![match time.tolerance {
        Some(tolerance) => {
            format!("steps that follow the error, tolerance {tolerance}, the first {}, to t = {}", time.step, time.end)
        }
        None => format!("{} steps of {} to t = {}", time.steps(), time.step, time.end),
    }];
    let Some(limit) = model.explicit_limit else { return lines };
    let ratio = time.step / limit;
    let coupling = model.simulation.settings().coupling;
    lines.push(format!("explicit step limit (1.54) at the start: {limit:.3e}; the step is {ratio:.2} of it"));
    match coupling {
        Coupling::Explicit if ratio > 1.0 && scene.membranes.iter().any(|m| m.surface.is_some()) => {
            lines.push(
                "with shear the explicit coupling was found stable to 1.4 to 3.8 times this: if the energy rises, take a smaller step, or \
                 coupling = \"implicit\""
                    .into(),
            );
        }
        Coupling::Explicit if ratio > 1.0 => {
            lines
                .push("the explicit coupling will be unstable: take a smaller step, or coupling = \"implicit\"".into());
        }
        Coupling::FullyExplicit => {
            lines.push("the fully explicit coupling is unstable without viscosity, with any step: remark 1.12".into());
        }
        Coupling::Explicit if scene.numerics.has_continuum_force() => {
            lines.push("the continuum force is not the derivative of an energy: with little viscosity it wins energy with any step".into());
        }
        Coupling::Explicit => {}
        Coupling::SemiImplicit if is_stiff(scene) => {
            lines.push("the semi-implicit coupling is made for constant tension: with another law prefer coupling = \"implicit\"".into());
        }
        Coupling::SemiImplicit | Coupling::Implicit => {
            lines.push(format!(
                "the {} coupling is not bound by it",
                if coupling == Coupling::Implicit { "implicit" } else { "semi-implicit" }
            ));
        }
    }
    lines
}

/// Whether density or viscosity change across a membrane, which needs a band.
pub(super) fn is_stepped(scene: &Scene) -> bool {
    scene.fluids().any(|f| f != scene.outside()) || scene.membranes.iter().any(|m| m.mass > 0.0)
}

/// Whether some membrane has more than a constant tension.
fn is_stiff(scene: &Scene) -> bool {
    scene.membranes.iter().any(|m| !matches!(m.area, AreaLaw::Tension { .. }))
}

fn both(c: Contrast) -> String {
    if c.is_uniform() { c.outside.to_string() } else { format!("{} inside, {} outside", c.inside, c.outside) }
}
