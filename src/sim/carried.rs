//! Structures, their fields and their transport: common to all problems.

use crate::base::{Cause, Error, Phase, Phases, Result};
use crate::fem::{Basis, Projector, Rule, Space, Translation};
use crate::levelset::{Interface, Redistancing, Sample, slopes};
use crate::mesh::{Mesh, Point};
use crate::structure::{
    Carrier, DISPLACEMENT, Data, Declaration, FieldId, Fields, Host, LevelSet, Moved,
    Rule as FieldRule, Structure, Velocity,
};
use crate::transport::{Method, Tracer};
use nalgebra::SVector;
use std::borrow::Cow;
use std::sync::Arc;

/// Options of the transport of fields.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transport {
    /// The method.
    pub method: Method,
    /// Gradient of the displacement of a submap beyond which the next one begins; `None` for the
    /// default.
    pub remap: Option<f64>,
    /// Degree of the quadrature rule of projected transport without a flow.
    pub quadrature: usize,
    /// True to transport the backward characteristics even if no structure needs them.
    pub backward_map: bool,
}

impl Default for Transport {
    fn default() -> Transport {
        Transport { method: Method::Nodal, remap: None, quadrature: 5, backward_map: false }
    }
}

/// When level sets are redistanced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum When {
    /// All level sets, after every so many steps.
    Every(u64),
    /// Those whose slope has [no meaning](Structure::keeps_distance), as soon as it differs on the
    /// interface from that at time 0 by this fraction.
    Slope(f64),
}

/// Structures on a mesh, and the transport of their fields.
pub struct Carried<const D: usize> {
    pub(super) space: Arc<Space<D>>,
    pub(super) translations: Vec<Translation<D>>,
    pub(super) carrier: Carrier<D>,
    pub(super) transport: Transport,
    pub(super) rules: Vec<FieldRule<D>>,
    pub(super) structures: Vec<Box<dyn Structure<D>>>,
    /// Redistancing of all level sets that are asked for.
    pub(super) redistancing: Option<(When, Redistancing)>,
}

impl<const D: usize> Carried<D> {
    /// Declares the fields of the structures on a mesh; `kept` are earlier fields, which replace
    /// those of time 0. `basis` is that of a flow, if there is one.
    ///
    /// # Errors
    /// A matrix that does not fit into the memory.
    pub(super) fn new(
        space: &Arc<Space<D>>,
        translations: Vec<Translation<D>>,
        transport: Transport,
        mut structures: Vec<Box<dyn Structure<D>>>,
        (basis, kept): (Option<&Basis<D>>, &Fields<D>),
    ) -> Result<(Carried<D>, Fields<D>)> {
        let host = Host { space, basis, translations: &translations };
        let mut declared = Declaration::new(space.len(), kept);
        structures.iter_mut().try_for_each(|s| s.begin(&host, &mut declared))?;
        if transport.backward_map {
            declared.backward_map(false);
        }
        let (mut fields, rules) = declared.finish()?;
        let projected = transport.method == Method::Projected && !structures.is_empty();
        let own = || Basis::new(space, &Arc::new(Rule::simplex(D, transport.quadrature)));
        let projector = match projected {
            true => Some(Projector::new(basis.cloned().unwrap_or_else(own), &translations)?),
            false => None,
        };
        let mut carrier = Carrier::new(Tracer::new(space, &translations), projector);
        if transport.method == Method::Composed {
            carrier.compose(&mut fields, &rules);
        }
        carrier.remap = transport.remap.unwrap_or(carrier.remap);
        let space = Arc::clone(space);
        let redistancing = None;
        let carried =
            Carried { space, translations, carrier, transport, rules, structures, redistancing };
        Ok((carried, fields))
    }

    /// P2 space of velocity and level sets.
    pub fn space(&self) -> &Arc<Space<D>> {
        &self.space
    }
    /// The mesh.
    pub fn mesh(&self) -> &Arc<Mesh<D>> {
        self.space.mesh()
    }
    /// Pairs of facets on periodic sides.
    pub fn translations(&self) -> &[Translation<D>] {
        &self.translations
    }
    /// The structures.
    pub fn structures(&self) -> &[Box<dyn Structure<D>>] {
        &self.structures
    }
    /// The transport.
    pub fn carrier(&self) -> &Carrier<D> {
        &self.carrier
    }
    /// Options of the transport.
    pub fn transport(&self) -> &Transport {
        &self.transport
    }
    /// Redistances level sets. Steps are counted by the state, also in a resumed run. For
    /// interfaces whose slope has no physical meaning: a membrane whose stretch is the slope would
    /// lose it.
    pub fn redistance_when(&mut self, when: When, method: Redistancing) {
        self.redistancing = Some((when, method));
    }

    /// True if level sets whose slope has no meaning are redistanced when it has changed.
    pub fn keeps_distances(&self) -> bool {
        matches!(self.redistancing, Some((When::Slope(_), _)))
    }

    /// Predicts the fields with an effect on the flow at the end, `time`, of a step of length `dt`
    /// in the velocity at its start.
    ///
    /// # Errors
    /// A projection that fails, a level set that is not finite.
    pub(super) fn predict(
        &mut self,
        from: &Fields<D>,
        velocity: Velocity<'_, D>,
        (dt, time): (f64, f64),
        to: &mut Fields<D>,
    ) -> Result<()> {
        self.carrier.carry((from, &self.rules), &velocity.advecting(dt), dt, true, to)?;
        self.advance(from, velocity, (dt, time, true), &[], to)
    }
    /// Transports `from` over step number `step` (counted from 1) of length `dt` that ends at
    /// `time` into `to`, and redistances the level sets that are due; `blocks` are the values of
    /// unknowns of structures in the step.
    ///
    /// # Errors
    /// A projection that fails, a level set that is not finite.
    pub(super) fn carry(
        &mut self,
        from: &Fields<D>,
        velocity: Velocity<'_, D>,
        (dt, time, step): (f64, f64, u64),
        (blocks, phases): (&[Vec<f64>], &mut Phases),
        to: &mut Fields<D>,
    ) -> Result<()> {
        self.carrier.carry((from, &self.rules), &velocity.advecting(dt), dt, false, to)?;
        phases.end(Phase::Transport);
        if self.redistance(step, to)? {
            phases.end(Phase::Redistance);
        }
        self.advance(from, velocity, (dt, time, false), blocks, to)?;
        phases.end(Phase::Transport);
        Ok(())
    }
    /// Updates the fields that structures transport themselves.
    fn advance(
        &mut self,
        from: &Fields<D>,
        velocity: Velocity<'_, D>,
        (dt, time, ahead): (f64, f64, bool),
        mut blocks: &[Vec<f64>],
        to: &mut Fields<D>,
    ) -> Result<()> {
        for s in self.structures.iter_mut().filter(|s| s.acts() || !ahead) {
            let mut list = Vec::new();
            s.blocks(&mut list);
            let (own, rest) = blocks.split_at(list.len().min(blocks.len()));
            blocks = rest;
            let carrier = &mut self.carrier;
            let mut by = Moved { carrier, velocity, before: from, blocks: own, dt, time, ahead };
            s.advance(&mut by, to)?;
        }
        Ok(())
    }

    /// Redistances each level set once after step number `step` (counted from 1), if it is due.
    /// Returns true if it was done.
    pub(super) fn redistance(&mut self, step: u64, fields: &mut Fields<D>) -> Result<bool> {
        let Some((when, method)) = self.redistancing else { return Ok(false) };
        let mut done = Vec::new();
        for s in &self.structures {
            let Some(id) = s.level_set().filter(|id| !done.contains(id)) else { continue };
            let due = match when {
                When::Every(every) => step.is_multiple_of(every),
                When::Slope(change) => {
                    let off = |slope: f64| (slope / s.slope() - 1.0).abs() > change;
                    s.keeps_distance()
                        && slopes(&self.space, fields.scalar(id))?.iter().copied().any(off)
                }
            };
            if !due {
                continue;
            }
            done.push(id);
            let mut phi = fields.scalar(id).to_vec();
            method.apply(&self.carrier.tracer, &self.translations, s.slope(), &mut phi)?;
            fields.scalar_mut(id).copy_from_slice(&phi);
        }
        Ok(!done.is_empty())
    }

    /// Level set of structure number `k` at the nodes; empty for one without.
    pub fn level_set<'a>(&self, fields: &'a Fields<D>, k: usize) -> Cow<'a, [f64]> {
        match self.structures.get(k).and_then(|s| s.level_set()) {
            Some(id) => self.nodal(fields, id),
            None => Cow::Borrowed(&[]),
        }
    }
    /// Nodal values of scalar field `id`; composed transport evaluates passive fields on demand.
    fn nodal<'a>(&self, fields: &'a Fields<D>, id: FieldId) -> Cow<'a, [f64]> {
        let nodal = fields.scalar(id);
        match &fields.map {
            Some(map) if nodal.is_empty() => {
                let composed = self.carrier.composed(map, id.index());
                composed.map_or(Cow::Borrowed(&[]), Cow::Owned)
            }
            _ => Cow::Borrowed(nodal),
        }
    }
    /// Names and nodal values of the scalar fields that field files contain.
    pub fn written_scalars<'a>(
        &'a self,
        fields: &'a Fields<D>,
    ) -> impl Iterator<Item = (&'a str, Cow<'a, [f64]>)> {
        let all = fields.iter().zip(&self.rules).enumerate();
        let written = all.filter(|(_, (f, r))| r.written && matches!(f.data, Data::Scalar(_)));
        written.map(|(k, (f, _))| (&*f.name, self.nodal(fields, FieldId::at(k))))
    }
    /// Names and nodal values of the vector fields that field files contain.
    pub fn written_vectors<'a>(
        &'a self,
        fields: &'a Fields<D>,
    ) -> impl Iterator<Item = (&'a str, &'a [SVector<f64, D>])> {
        fields.iter().zip(&self.rules).filter(|(_, r)| r.written).filter_map(|(f, _)| {
            let Data::Vector(values) = &f.data else { return None };
            Some((&*f.name, &values[..]))
        })
    }
    /// True if the backward characteristics are transported.
    pub fn has_backward_map(&self, fields: &Fields<D>) -> bool {
        fields.find(DISPLACEMENT).is_some()
    }
    /// Number of submaps of composed transport, and error of the map by its determinant, (3.68).
    pub fn map_error(&self, fields: &Fields<D>) -> Option<(usize, f64)> {
        let map = fields.map.as_ref()?;
        Some((map.submaps().len(), map.determinant_error(&self.carrier.tracer)))
    }
    /// Checks that no particle crosses the whole domain in a step.
    ///
    /// # Errors
    /// A velocity that is too large or not finite.
    pub(super) fn check_speed(&self, u: &[SVector<f64, D>], dt: f64, time: f64) -> Result<()> {
        let (lo, hi) = self.space.mesh().bounding_box();
        let (size, speed) = ((hi - lo).norm(), largest(u));
        if speed.is_finite() && speed * dt < size {
            return Ok(());
        }
        Err(Error::computation(
            "the computation blew up: a particle would cross the whole domain in one step",
        )
        .at(format!("time {time:.6}"))
        .value(format!("largest velocity {speed:.3e}"))
        .remedy("take a shorter step, implicit coupling, or a larger grad-div weight")
        .because(Cause::BlowUp))
    }
    /// L2 norm of the divergence of a velocity, by a rule that is exact for P2.
    pub fn divergence(&self, u: &[SVector<f64, D>]) -> f64 {
        let basis = Basis::new(&self.space, &Arc::new(Rule::simplex(D, 2)));
        let [square] = crate::fem::integrate(&basis, crate::fem::Cells::All, |at| {
            [basis.jacobian(at, u).trace().powi(2)]
        });
        square.sqrt()
    }
    /// Bytes of fields and mesh, with `vectors` nodal vector fields.
    pub(super) fn field_bytes(&self, vectors: usize) -> usize {
        let word = size_of::<f64>();
        let (cells, nodes) = (self.space.mesh().cell_count(), self.space.len());
        let local = self.space.local_count();
        let fields =
            word * nodes * (vectors * D + 3 * self.structures.len()) + word * cells * local * D;
        fields + cells * (2 * word + word * (D * D + D + 1) + 4 * local)
    }
    /// Bytes of factors that the transport and the structures hold.
    pub(super) fn factor_bytes(&self) -> usize {
        let projector = self.carrier.projector.as_ref().map_or(0, Projector::bytes);
        projector + self.structures.iter().map(|s| s.bytes()).sum::<usize>()
    }

    /// The interface of structure number `k`. With composed transport in the plane it is cut on
    /// halved cells where the mesh is too coarse for the backward map.
    ///
    /// # Errors
    /// A value that is not finite.
    pub fn interface<'a>(&'a self, fields: &'a Fields<D>, k: usize) -> Result<Interface<'a, D>> {
        let id =
            self.structures.get(k).and_then(|s| s.level_set()).map_or(usize::MAX, |id| id.index());
        let initial = self.carrier.initial_depth_and_slope(id);
        let halved = fields.map.as_ref().zip(initial).and_then(|(map, [depth, slope])| {
            Interface::of_function(&self.space, depth, |at| {
                let (value, slope) = self.carrier.sample(map, id, slope, at);
                Sample { value, slope }
            })
        });
        halved.unwrap_or_else(|| Interface::cut(&self.space, self.level_set(fields, k)))
    }
    /// Positions of the markers of structure number `k`, in the order of a closed polygon.
    pub fn markers<'a>(&self, fields: &'a Fields<D>, k: usize) -> &'a [Point<D>] {
        let name = self.structures.get(k).map(|s| LevelSet::<D>::markers_field(s.name()));
        name.and_then(|name| fields.find(&name)).map_or(&[], |id| fields.vector(id))
    }
}

/// Largest norm; NaN if any is NaN.
pub(super) fn largest<const D: usize>(u: &[SVector<f64, D>]) -> f64 {
    let larger = |m: f64, v: f64| if v.is_nan() { v } else { m.max(v) };
    let square = u.iter().map(|v| v.norm_squared()).fold(0.0, larger);
    let is_nan = u.iter().any(|v| v.iter().any(|c| c.is_nan()));
    if is_nan { f64::NAN } else { square.sqrt() }
}
