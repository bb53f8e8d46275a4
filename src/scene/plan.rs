//! The plan: the equations that a scene solves, the terms it omits with reasons, and their size.

use super::Scene;
use super::adapt::Lengths;
use super::meshing::cells;
use super::schema::{Adapt, BallInBox, Block, Condition, MeshSource, Opening, Rectangle};
use super::script::Script;
use super::view::View;
use crate::base::length;
use crate::mesh::{Point, Quality};
use crate::transport::Method;
use std::fmt;

/// A heading of the plan with its lines.
pub(super) type Section = (&'static str, Vec<String>);

/// What a scene solves and what it leaves out, in words; prints as plain text.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan(Vec<Section>);

impl Plan {
    /// A plan of these sections.
    pub(super) fn new(sections: impl IntoIterator<Item = Section>) -> Plan {
        Plan(sections.into_iter().collect())
    }
    /// Headings with their lines.
    pub fn sections(&self) -> impl Iterator<Item = (&'static str, &[String])> {
        self.0.iter().map(|(heading, lines)| (*heading, &lines[..]))
    }
}

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (heading, lines) in &self.0 {
            writeln!(f, "{heading}")?;
            lines.iter().try_for_each(|line| writeln!(f, "  {line}"))?;
        }
        Ok(())
    }
}

/// The section of the plan about the mesh.
pub(super) fn mesh<const D: usize>(
    script: &Script,
    view: &View<'_, D>,
    (q, lengths): (&Quality<D>, Option<&Lengths>),
) -> Section {
    let mesh = view.carried.mesh();
    let (lo, hi) = mesh.bounding_box();
    let names: Vec<&str> = mesh.boundaries().keys().map(String::as_str).collect();
    let adapted = script.adapt.as_ref().zip(lengths);
    let made = if adapted.is_some() { ", adapted" } else { "" };
    let (source, count) = (source::<D>(script), mesh.cell_count());
    let mut lines = vec![
        format!("{source}{made}: {count} {}, {} points", cells(D), mesh.points().len()),
        format!("from ({}) to ({})", listed(&lo), listed(&hi)),
        format!(
            "edges up to {}, smallest angle {:.1} degrees",
            length(q.greatest_diameter.value),
            q.smallest_angle.value
        ),
        format!("boundary names: {}", names.join(", ")),
    ];
    lines.extend(adapted.map(|(adapt, lengths)| follows(adapt, lengths)));
    ("Mesh", lines)
}

/// Source of the mesh in words.
fn source<const D: usize>(script: &Script) -> String {
    match &script.mesh {
        MeshSource::File { path, refine: 0, .. } => format!("{}", path.display()),
        MeshSource::File { path, refine, .. } => {
            let (cell, parts) = if D == 2 { ("triangle", 4usize) } else { ("tetrahedron", 8) };
            format!(
                "{}, every {cell} cut into {}",
                path.display(),
                parts.saturating_pow(*refine as u32)
            )
        }
        MeshSource::Rectangle(Rectangle { cells, .. }) => {
            format!("rectangle of {} x {} squares", cells[0], cells[1])
        }
        MeshSource::Disc(disc) => format!("disc with {} cells along a radius", disc.cells),
        MeshSource::Box(Block { cells: [x, y, z], .. }) => format!("box of {x} x {y} x {z} boxes"),
        MeshSource::BallInBox(BallInBox { cells: [x, y, z], edge, .. }) => {
            format!("box of {x} x {y} x {z} boxes, cut to edges of {edge} about a sphere")
        }
    }
}

/// The coordinates of a point, with commas.
fn listed<const D: usize>(x: &Point<D>) -> String {
    x.iter().map(f64::to_string).collect::<Vec<_>>().join(", ")
}

/// Adaptation of the mesh in words.
fn follows(adapt: &Adapt, lengths: &Lengths) -> String {
    let Lengths { edge, along, width, longest } = lengths;
    let when = adapt.every.map_or("at the start alone".into(), |every| {
        format!("at the start and looked at every {every}")
    });
    let growth = adapt.gradation;
    let mut text = format!(
        "adapted {when}: edges of {} across and {} along, up to {} from the interfaces, then \
         growing by {growth} each to {}",
        length(*edge),
        length(*along),
        length(*width),
        length(*longest)
    );
    if !adapt.fields.is_empty() {
        let target = match adapt.vertices {
            Some(count) => format!("{count} points"),
            None => format!("an interpolation error of {}", adapt.error),
        };
        text += &format!(
            "; by the second derivatives of {} field kinds for {target}",
            adapt.fields.len()
        );
    }
    text
}

/// Boundary conditions, for the plan.
pub(super) fn boundaries(script: &Script) -> Vec<String> {
    let condition = |condition: &Condition| match condition {
        Condition::Velocity(v) => {
            let v: Vec<&str> = v.iter().map(super::Expression::text).collect();
            format!("velocity ({})", v.join(", "))
        }
        Condition::NoSlip => "no slip".into(),
        Condition::Slip => "slip".into(),
        Condition::Open(Opening::Stress) => "open (no stress where fluid leaves)".into(),
        Condition::Open(Opening::Gradient) => {
            "open, (mu grad u - p) n = 0 where fluid leaves".into()
        }
        Condition::Pressure(p) => format!("pressure {}", p.text()),
        Condition::TotalPressure(p) => format!(
            "pressure {} where fluid leaves, total pressure {0} where it comes in",
            p.text()
        ),
        Condition::Traction(t) => {
            let t: Vec<&str> = t.iter().map(super::Expression::text).collect();
            format!("traction ({}) where fluid leaves", t.join(", "))
        }
        Condition::Periodic(other) => format!("periodic with {other}"),
    };
    let line =
        |b: &super::schema::Boundary| format!("boundary {}: {}", b.name, condition(&b.condition));
    script.boundaries.iter().map(line).collect()
}

/// Lines of the structures, for the plan.
pub(super) fn structures(scene: &Scene) -> impl Iterator<Item = String> + '_ {
    scene.structures().iter().flat_map(|s| s.words())
}

/// Number of unknowns of the level sets.
pub(super) fn level_sets<const D: usize>(view: &View<'_, D>) -> Option<String> {
    let count = view.carried.structures().iter().filter(|s| s.level_set().is_some()).count();
    (count > 0).then(|| format!("level sets {count} x {} (P2)", view.space().len()))
}

/// Memory of the chain of submaps, which grows by one vector field per restart.
pub(super) fn map_memory<const D: usize>(view: &View<'_, D>) -> Option<String> {
    let submap = view.state.fields.map.as_ref()?.bytes() as f64 / 1e6;
    Some(format!(
        "backward map: {submap:.2} MB a submap (P2); their number grows with the time and is the \
         column `submaps`"
    ))
}

/// The transport in words.
pub(super) fn transport<const D: usize>(script: &Script, view: &View<'_, D>) -> String {
    match script.numerics.transport {
        Method::Nodal => "level set carried to the nodes (nodal)".into(),
        Method::Projected => "level set projected at the quadrature points (projected)".into(),
        Method::Composed => format!(
            "level set composed with the backward map (composed): a new submap when the gradient \
             of its displacement exceeds {}{}",
            view.carried.carrier().remap,
            if script.numerics.remap.is_some() { "" } else { " (measured default)" }
        ),
    }
}

/// Line about the third dimension, which is omitted in the plane.
pub(super) fn third_dimension(dimension: usize) -> Option<String> {
    (dimension == 2).then(|| "the third dimension: the mesh is plane".into())
}

/// Number and lengths of the steps.
pub(super) fn steps(script: &Script) -> String {
    let time = &script.time;
    match time.tolerance {
        Some(tolerance) => {
            format!(
                "steps that follow the error, tolerance {tolerance}, the first {}, to t = {}",
                time.step, time.end
            )
        }
        None => format!("{} steps of {} to t = {}", time.steps(), time.step, time.end),
    }
}
