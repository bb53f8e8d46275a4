//! Meshes that follow the interfaces and the fields of a scene.

use super::Scene;
use super::model::{Draft, Model, edges_in_bands, wall_nodes};
use super::schema::{Adapt, AdaptField};
use crate::base::{Error, Result};
use crate::fem::{self, Element, Space};
use crate::levelset::band_edges;
use crate::mesh::adapt::{self, AdaptOptions, Metric};
use crate::mesh::{self, Mesh};
use crate::sim::{Simulation, Structure, Transfer};
use nalgebra::{SMatrix, SVector};
use std::sync::Arc;

/// Edges at the interfaces in the half-width of the band, when the scene does not say: well resolved.
const EDGES: f64 = 3.0;
/// Rounds at the start: each sees the interfaces on the mesh of the one before.
const ROUNDS: usize = 5;
/// A mesh is made anew when the longest edge in a band exceeds the wanted one by this factor (adapted edges are up to `sqrt 2` of it),
/// and the longest that the mesh had when it was made by the other.
const TOLERATED: [f64; 2] = [1.6, 1.25];

/// The lengths that an adapted mesh keeps at interfaces.
#[derive(Clone, Copy, Debug)]
pub struct Lengths {
    /// Wanted edges across the interfaces.
    pub edge: f64,
    /// Wanted edges along them.
    pub along: f64,
    /// Distance up to which they are wanted.
    pub width: f64,
    /// Longest edge anywhere.
    pub longest: f64,
}

impl Lengths {
    /// From the scene and the mesh as given.
    ///
    /// # Errors
    /// Neither an edge nor a thickness is given; an edge that is longer than all others.
    pub(super) fn new<const D: usize>(scene: &Scene, adapt: &Adapt, mesh: &Mesh<D>) -> Result<Lengths> {
        let longest = (0..mesh.cell_count()).map(|c| mesh.diameter(c)).fold(0.0, f64::max);
        let thickness = scene.numerics.thickness;
        let edge = adapt.edge.or(thickness.map(|eps| eps / EDGES));
        let interfaces = scene.interfaces().next().is_some();
        let edge = match edge {
            Some(edge) => edge,
            None if !interfaces => longest,
            None => {
                let e = Error::scene("the mesh is to follow the interfaces, but how fine it shall be is not said")
                    .value("neither mesh.adapt.edge nor numerics.thickness is given")
                    .remedy("give mesh.adapt.edge, or numerics.thickness, of which it is a third");
                return Err(scene.blame(&["mesh", "adapt"], e));
            }
        };
        let longest = adapt.h_max.unwrap_or(longest);
        if edge > longest {
            let e = Error::scene("the edges wanted at the interfaces are longer than any of the mesh")
                .value(format!("edge {edge}, longest edge {longest:.4}"))
                .remedy("give a shorter mesh.adapt.edge, or a longer mesh.adapt.h_max");
            return Err(scene.blame(&["mesh", "adapt"], e));
        }
        let width = adapt.width.unwrap_or(thickness.unwrap_or(EDGES * edge) + edge);
        Ok(Lengths { edge, along: adapt.along.unwrap_or(edge), width, longest })
    }
}

/// The mesh of a scene that follows its interfaces, at the start: from the mesh as given, in rounds.
///
/// # Errors
/// Shapes that do not lie on the mesh.
pub(super) fn adapted_start(scene: &Scene, given: Mesh<2>, lengths: &Lengths) -> Result<Mesh<2>> {
    let Some(adapt) = &scene.adapt else { return Ok(given) };
    // Nothing is known of the fields yet: the mesh as given is as good as any.
    if scene.interfaces().next().is_none() {
        return Ok(given);
    }
    let conditions = super::model::conditions(scene, &given)?;
    let mut mesh = Arc::new(given);
    for _ in 0..ROUNDS {
        let space = Space::new(&mesh, Element::P2);
        let pairs = fem::periodic_pairs(&mesh, &conditions).map_err(|e| scene.blame(&["boundary"], e))?;
        let keep_boundary = !pairs.is_empty();
        let draft = Draft { scene, mesh: &mesh, space: &space, pairs, warnings: Vec::new() };
        let metric = Wanted { adapt, lengths, space: &space }.interfaces(&draft.all_distances()?)?;
        let before = mesh.points().len();
        mesh = Arc::new(made_anew(scene, &mesh, &metric, keep_boundary)?);
        if mesh.points().len().abs_diff(before) * 50 < before {
            break;
        }
    }
    Ok(Arc::unwrap_or_clone(mesh))
}

fn made_anew(scene: &Scene, mesh: &Mesh<2>, metric: &Metric, keep_boundary: bool) -> Result<Mesh<2>> {
    let options = AdaptOptions { keep_boundary, ..AdaptOptions::default() };
    let adapted = adapt::adapt(mesh, metric, &options).map_err(|e| {
        scene.blame(&["mesh", "adapt"], e.remedy("take longer edges (mesh.adapt.edge, along, h_min) or a larger error"))
    })?;
    Ok(adapted.mesh)
}

impl Model<2> {
    /// Makes the mesh anew where it no longer fits interfaces or fields, and goes on upon it. Returns whether it did.
    ///
    /// # Errors
    /// Those of [`Simulation::on_mesh`].
    pub(super) fn follow_fields(&mut self, scene: &Scene) -> Result<bool> {
        let (Some(adapt), Some(lengths)) = (&scene.adapt, &self.lengths) else { return Ok(false) };
        let sim = &self.simulation;
        if adapt.fields.is_empty() && !self.is_outgrown(lengths) {
            return Ok(false);
        }
        let wanted = Wanted { adapt, lengths, space: sim.space() };
        let mut metric = wanted.interfaces(&sim.state().phi)?;
        if let Some(fields) = wanted.fields(sim)? {
            metric = metric.intersect(&fields)?;
        }
        let mesh = made_anew(scene, sim.space().mesh(), &metric, !sim.translations().is_empty())?;
        self.go_on_upon(mesh, adapt.transfer)?;
        Ok(true)
    }

    /// Goes on upon another mesh of the domain.
    ///
    /// # Errors
    /// Those of [`Simulation::on_mesh`].
    pub(super) fn go_on_upon(&mut self, mesh: Mesh<2>, transfer: Transfer) -> Result<()> {
        self.simulation = self.simulation.on_mesh(&Arc::new(mesh), transfer)?;
        let sim = &self.simulation;
        let phi = sim.state().phi.iter().map(Vec::as_slice);
        self.band_edges = edges_in_bands(sim.space(), sim.structures().iter().zip(phi));
        (self.quality, _) = mesh::check(sim.space().mesh());
        self.wall_nodes = wall_nodes(sim.space(), sim.translations());
        Ok(())
    }

    /// Whether some edge at an interface is too long.
    fn is_outgrown(&self, lengths: &Lengths) -> bool {
        let sim = &self.simulation;
        let structures = sim.structures().iter().map(Structure::reach);
        let reaches = structures.chain(sim.passive().iter().map(|_| lengths.width - lengths.edge));
        let edges = sim.state().phi.iter().zip(reaches).filter_map(|(phi, reach)| band_edges(sim.space(), phi, reach));
        let at_first = self.band_edges.map_or(0.0, |[_, largest]| largest);
        let tolerated = (TOLERATED[0] * lengths.edge).max(TOLERATED[1] * at_first);
        edges.into_iter().any(|e| e.largest > tolerated)
    }
}

/// The metric that interfaces and fields ask for.
struct Wanted<'a> {
    adapt: &'a Adapt,
    lengths: &'a Lengths,
    space: &'a Space<2>,
}

impl Wanted<'_> {
    /// Edges of the wanted lengths across and along the interfaces, growing away from them.
    fn interfaces(&self, level_sets: &[Vec<f64>]) -> Result<Metric> {
        let mesh = self.space.mesh();
        // Sums of n n^T over the cells near an interface that meet at a point, and their number.
        let mut normals = vec![(SMatrix::<f64, 2, 2>::zeros(), 0.0); mesh.points().len()];
        for c in 0..mesh.cell_count() {
            for gradient in level_sets.iter().filter_map(|phi| self.near(phi, c)) {
                let n = gradient.try_normalize(f64::MIN_POSITIVE).unwrap_or_else(|| SVector::<f64, 2>::new(1.0, 0.0));
                for &v in mesh.cell(c) {
                    normals[v as usize].0 += n * n.transpose();
                    normals[v as usize].1 += 1.0;
                }
            }
        }
        let Lengths { edge, along, longest, .. } = *self.lengths;
        let [across, along, longest] = [edge, along, longest].map(|h| 1.0 / (h * h));
        let identity = SMatrix::<f64, 2, 2>::identity();
        let tensor = |&(sum, count): &(SMatrix<f64, 2, 2>, f64)| match count {
            0.0 => identity * longest,
            _ => sum * ((across - along) / count) + identity * along,
        };
        Metric { tensors: normals.iter().map(tensor).collect() }.graded(mesh, self.adapt.gradation)
    }

    /// The gradient of `phi` in cell `c` if that comes nearer to the zero level than the width.
    fn near(&self, phi: &[f64], c: usize) -> Option<SVector<f64, 2>> {
        let gradient = self.space.gradient(phi, c, &[1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0, 0.0]);
        let values = self.space.cell_nodes(c).iter().map(|&n| phi[n as usize]);
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        let least = if low <= 0.0 && high >= 0.0 { 0.0 } else { low.abs().min(high.abs()) };
        (least <= self.lengths.width * gradient.norm()).then_some(gradient)
    }

    /// The metric of the second derivatives of one field; `None` while it is constant.
    fn field(&self, space: &Space<2>, values: &[f64]) -> Result<Option<Metric>> {
        let (low, high) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &v| (l.min(v), h.max(v)));
        if high - low <= f64::MIN_POSITIVE {
            return Ok(None);
        }
        let hessians = fem::hessians(space, values);
        Ok(Some(Metric::from_hessians(&hessians, self.adapt.error * (high - low))))
    }

    /// The metric of the fields of the scene; `None` while all are constant.
    fn fields(&self, sim: &Simulation<2>) -> Result<Option<Metric>> {
        let state = sim.state();
        let pressure = sim.flow().map(|flow| flow.pressure().space());
        let mut all: Vec<(&Space<2>, Vec<f64>)> = Vec::new();
        for field in &self.adapt.fields {
            match field {
                AdaptField::Velocity => {
                    all.extend((0..2).map(|i| (self.space, state.flow.u.iter().map(|u| u[i]).collect())));
                }
                AdaptField::Pressure => all.extend(pressure.map(|space| (&**space, state.flow.p.clone()))),
                AdaptField::LevelSet => all.extend(state.phi.iter().map(|phi| (self.space, phi.clone()))),
            }
        }
        let mut metric: Option<Metric> = None;
        for (space, values) in &all {
            let Some(next) = self.field(space, values)? else { continue };
            metric = Some(match metric {
                Some(m) => m.intersect(&next)?,
                None => next,
            });
        }
        let Some(mut metric) = metric else { return Ok(None) };
        let mesh = self.space.mesh();
        let shortest = self.adapt.h_min.unwrap_or(self.lengths.edge / 4.0);
        for _ in 0..if self.adapt.vertices.is_some() { 3 } else { 1 } {
            if let Some(count) = self.adapt.vertices {
                metric = metric.scaled_to(mesh, count)?;
            }
            metric = metric.bounded(shortest, self.lengths.longest).limited_anisotropy(self.adapt.anisotropy);
        }
        Ok(Some(metric.graded(mesh, self.adapt.gradation)?))
    }
}
