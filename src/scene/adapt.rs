//! Meshes adapted to the interfaces and the fields of a scene.

use super::Scene;
use super::placing::place;
use super::schema::{Adapt, AdaptField};
use super::site::Site;
use super::view::View;
use crate::base::{Error, Result, length, same};
use crate::fem::{self, Space};
use crate::levelset::band_edges;
use crate::mesh::adapt::{self, AdaptOptions, Metric};
use crate::mesh::{self, Mesh};
use crate::sim::Transfer;
use nalgebra::{SMatrix, SVector};
use std::sync::Arc;

/// Default number of edges at the interfaces per half-width of the band: well resolved.
const EDGES: f64 = 3.0;
/// Rounds of adaptation at the start; each uses the interfaces on the mesh of the previous one.
const ROUNDS: usize = 5;
/// Factors of tolerance. A mesh is rebuilt when the longest edge in a band exceeds both the target
/// length times the first (adapted edges reach `sqrt 2` times the target) and the longest one at
/// its construction times the second.
const TOLERATED: [f64; 2] = [1.6, 1.25];

/// Target edge lengths of an adapted mesh.
#[derive(Clone, Copy, Debug)]
pub struct Lengths {
    /// Target edge length across the interfaces.
    pub edge: f64,
    /// Target edge length along the interfaces.
    pub along: f64,
    /// Distance from the interfaces up to which these lengths apply.
    pub width: f64,
    /// Longest edge anywhere.
    pub longest: f64,
}

impl Lengths {
    /// Computes the lengths from the scene and the initial mesh.
    ///
    /// # Errors
    /// Neither an edge nor a thickness is given, or an edge is longer than the longest one allowed.
    pub(super) fn new<const D: usize>(
        scene: &Scene,
        adapt: &Adapt,
        mesh: &Mesh<D>,
    ) -> Result<Lengths> {
        let longest = (0..mesh.cell_count()).map(|c| mesh.diameter(c)).fold(0.0, f64::max);
        let thickness = scene.numerics.thickness;
        let edge = adapt.edge.or(thickness.map(|eps| eps / EDGES));
        let interfaces = !scene.structures().is_empty();
        let edge = match edge {
            Some(edge) => edge,
            None if !interfaces => longest,
            None => {
                let e = Error::scene(
                    "the mesh is to follow the interfaces, but how fine it shall be is not said",
                )
                .value("neither mesh.adapt.edge nor numerics.thickness is given")
                .remedy("give mesh.adapt.edge, or numerics.thickness, of which it is a third");
                return Err(scene.blame(&["mesh", "adapt"], e));
            }
        };
        let longest = adapt.h_max.unwrap_or(longest);
        if edge > longest {
            let e =
                Error::scene("the edges wanted at the interfaces are longer than any of the mesh")
                    .value(format!("edge {edge}, longest edge {}", length(longest)))
                    .remedy("give a shorter mesh.adapt.edge, or a longer mesh.adapt.h_max");
            return Err(scene.blame(&["mesh", "adapt"], e));
        }
        let width = adapt.width.unwrap_or(thickness.unwrap_or(EDGES * edge) + edge);
        Ok(Lengths { edge, along: adapt.along.unwrap_or(edge), width, longest })
    }
}

/// The initial mesh of a scene with adaptation, refined in rounds from the given mesh.
///
/// # Errors
/// Shapes that do not lie on the mesh.
pub(super) fn adapted_start<const D: usize>(
    scene: &Scene,
    given: Mesh<D>,
    lengths: &Lengths,
) -> Result<Mesh<D>> {
    // Without interfaces the given mesh is kept, as the fields are not known yet.
    let Some(adapt) = scene.adapt.as_ref().filter(|_| !scene.structures().is_empty()) else {
        return Ok(given);
    };
    let plane = same::<_, Mesh<2>>(given).ok_or_else(solid)?;
    same(adapted(scene, adapt, plane, lengths)?).ok_or_else(solid)
}

fn solid() -> Error {
    Error::internal("a mesh of tetrahedra was adapted")
}

fn adapted(scene: &Scene, adapt: &Adapt, given: Mesh<2>, lengths: &Lengths) -> Result<Mesh<2>> {
    let mut mesh = Arc::new(given);
    for _ in 0..ROUNDS {
        let (quality, _) = mesh::check(&mesh);
        let site = Site::new(scene, Arc::clone(&mesh), quality)?;
        let placed = place(scene, &site)?.into_iter().flatten();
        let distances: Vec<Vec<f64>> = placed.map(|p| p.nodal).collect();
        let distances: Vec<&[f64]> = distances.iter().map(Vec::as_slice).collect();
        let metric = Wanted { adapt, lengths, space: &site.space }.interfaces(&distances)?;
        let before = mesh.points().len();
        mesh = Arc::new(rebuilt(scene, &mesh, &metric, !site.pairs.is_empty())?);
        if mesh.points().len().abs_diff(before) * 50 < before {
            break;
        }
    }
    Ok(Arc::unwrap_or_clone(mesh))
}

fn rebuilt(scene: &Scene, mesh: &Mesh<2>, metric: &Metric, keep_boundary: bool) -> Result<Mesh<2>> {
    let options = AdaptOptions { keep_boundary, ..AdaptOptions::default() };
    let adapted = adapt::adapt(mesh, metric, &options).map_err(|e| {
        scene.blame(
            &["mesh", "adapt"],
            e.remedy("take longer edges (mesh.adapt.edge, along, h_min) or a larger error"),
        )
    })?;
    Ok(adapted.mesh)
}

/// The mesh of a scene as bytes for a checkpoint; empty unless it is adapted.
pub(super) fn mesh_to_bytes<const D: usize>(scene: &Scene, mesh: &Mesh<D>) -> Vec<u8> {
    scene.adapt.as_ref().map_or_else(Vec::new, |_| mesh.to_bytes())
}

/// The adapted mesh of a checkpoint, and the transfer of fields to it; `None` if the scene adapts
/// no mesh or the checkpoint has none.
///
/// # Errors
/// Corrupt bytes.
pub(super) fn mesh_from_bytes<const D: usize>(
    scene: &Scene,
    bytes: &[u8],
) -> Result<Option<(Mesh<D>, Transfer)>> {
    let Some(adapt) = scene.adapt.as_ref().filter(|_| !bytes.is_empty()) else { return Ok(None) };
    let mesh = Mesh::from_bytes(bytes).ok_or_else(|| {
        Error::input("the mesh of the checkpoint is damaged")
            .value(format!("{} bytes", bytes.len()))
            .remedy("start afresh in another folder with --out")
    })?;
    Ok(Some((mesh, adapt.transfer)))
}

/// The next mesh of a problem whose mesh no longer fits interfaces or fields, and the transfer of
/// fields to it; `None` if the mesh still fits. `band_edges` are the shortest and longest edge in the bands when the mesh was built.
///
/// # Errors
/// A mesh that cannot be built.
pub(super) fn outgrown(
    scene: &Scene,
    lengths: Option<&Lengths>,
    view: &View<'_, 2>,
    band_edges: Option<[f64; 2]>,
) -> Result<Option<(Mesh<2>, Transfer)>> {
    let (Some(adapt), Some(lengths)) = (&scene.adapt, lengths) else { return Ok(None) };
    if adapt.fields.is_empty() && !is_outgrown(view, lengths, band_edges) {
        return Ok(None);
    }
    let wanted = Wanted { adapt, lengths, space: view.space() };
    let mut metric = wanted.interfaces(&level_sets(view))?;
    if let Some(fields) = wanted.fields(view)? {
        metric = metric.intersect(&fields)?;
    }
    let keep_boundary = !view.carried.translations().is_empty();
    let mesh = rebuilt(scene, view.space().mesh(), &metric, keep_boundary)?;
    Ok(Some((mesh, adapt.transfer)))
}

/// Level sets of all structures that have one.
fn level_sets<'a>(view: &View<'a, 2>) -> Vec<&'a [f64]> {
    let ids = view.carried.structures().iter().filter_map(|s| s.level_set());
    ids.map(|id| view.state.fields.scalar(id)).collect()
}

/// True if some edge at an interface is too long.
fn is_outgrown(view: &View<'_, 2>, lengths: &Lengths, at_first: Option<[f64; 2]>) -> bool {
    let edges = view.carried.structures().iter().filter_map(|s| {
        // A sharp force has no reach, but the flow beside it is as fine as the metric makes it.
        let reach = Some(s.reach()).filter(|r| s.acts() && *r > 0.0);
        let reach = reach.unwrap_or(lengths.width - lengths.edge);
        band_edges(view.space(), view.state.fields.scalar(s.level_set()?), reach)
    });
    let at_first = at_first.map_or(0.0, |[_, largest]| largest);
    let tolerated = (TOLERATED[0] * lengths.edge).max(TOLERATED[1] * at_first);
    edges.into_iter().any(|e| e.largest > tolerated)
}

/// The metric required by interfaces and fields.
struct Wanted<'a> {
    adapt: &'a Adapt,
    lengths: &'a Lengths,
    space: &'a Space<2>,
}

impl Wanted<'_> {
    /// Metric of the target lengths across and along the interfaces, growing with the distance.
    fn interfaces(&self, level_sets: &[&[f64]]) -> Result<Metric> {
        let mesh = self.space.mesh();
        // Sums of n n^T over the cells near an interface that meet at a point, and their number.
        let mut normals = vec![(SMatrix::<f64, 2, 2>::zeros(), 0.0); mesh.points().len()];
        for c in 0..mesh.cell_count() {
            for gradient in level_sets.iter().filter_map(|phi| self.near(phi, c)) {
                let n = gradient
                    .try_normalize(f64::MIN_POSITIVE)
                    .unwrap_or_else(|| SVector::<f64, 2>::new(1.0, 0.0));
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

    /// The gradient of `phi` in cell `c` if the zero level is closer than the width.
    fn near(&self, phi: &[f64], c: usize) -> Option<SVector<f64, 2>> {
        let gradient = self.space.gradient(phi, c, &[1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0, 0.0]);
        let values = self.space.cell_nodes(c).iter().map(|&n| phi[n as usize]);
        let (low, high) =
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        let least = if low <= 0.0 && high >= 0.0 { 0.0 } else { low.abs().min(high.abs()) };
        (least <= self.lengths.width * gradient.norm()).then_some(gradient)
    }

    /// The metric of the second derivatives of one field; `None` while it is constant.
    fn field(&self, space: &Space<2>, values: &[f64]) -> Result<Option<Metric>> {
        let (low, high) = values
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &v| (l.min(v), h.max(v)));
        if high - low <= f64::MIN_POSITIVE {
            return Ok(None);
        }
        let hessians = fem::hessians(space, values);
        Ok(Some(Metric::from_hessians(&hessians, self.adapt.error * (high - low))))
    }

    /// The metric of the fields of the scene; `None` while all are constant.
    fn fields(&self, view: &View<'_, 2>) -> Result<Option<Metric>> {
        let state = view.state;
        let pressure = view.flow.map(|flow| flow.pressure().space());
        let mut all: Vec<(&Space<2>, Vec<f64>)> = Vec::new();
        for field in &self.adapt.fields {
            match field {
                AdaptField::Velocity => {
                    all.extend(
                        (0..2).map(|i| (self.space, state.flow.u.iter().map(|u| u[i]).collect())),
                    );
                }
                AdaptField::Pressure => {
                    all.extend(pressure.map(|space| (&**space, state.flow.p.clone())))
                }
                AdaptField::LevelSet => {
                    all.extend(level_sets(view).iter().map(|phi| (self.space, phi.to_vec())));
                }
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
            metric = metric
                .bounded(shortest, self.lengths.longest)
                .limited_anisotropy(self.adapt.anisotropy);
        }
        Ok(Some(metric.graded(mesh, self.adapt.gradation)?))
    }
}
