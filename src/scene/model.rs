//! From a scene to a simulation: the mesh, the smallest model that answers the scene, and every value that the scene left open.

use super::Scene;
use super::adapt::Lengths;
use super::checks::{check_motion_is_fixed, unreached_profiles};
use super::dimension::{Dimension, In, coordinates};
use super::expression::Expression;
use super::image::segmenting;
use super::pacing::pacing;
use super::passive::{Placed, check_inflow, nearest_image, prescribed};
use super::redistance::redistance;
use super::schema::{self, Condition, MeshSource};
use super::sheared::{check_map, check_rest_map};
use crate::base::{Error, Kind, Result, Warning};
use crate::elastic::{AreaLaw, Band, ContinuumForce, Force, Membrane, SharpMembrane, SurfaceLaw};
use crate::fem::{self, Conditions, Element, Space};
use crate::levelset::{Shape, band_edges, check_band};
use crate::mesh::{self, Mesh, Point};
use crate::sim::{self, InitialFunction, Simulation, Structure, Transfer};
use nalgebra::SVector;
use std::sync::Arc;

/// Widths of the band in edges of the mesh when the scene does not say.
pub(super) const BAND: f64 = 2.5;
/// Weight of the grad-div term over `rho U L` when the scene does not say: of a flow with a membrane, which the divergence
/// would feed with energy, and of a flow alone, where more of it costs accuracy (driven cavity on 32 x 32, error of u_min:
/// 6e-3 with a weight of 5, 2e-4 with 0.1).
const GRAD_DIV: [f64; 2] = [5.0, 0.1];
/// The same with a sharp membrane: the currents about a drop at rest fall like its inverse (n = 30: 9e-3 at 5, 9e-4 at 50).
const GRAD_DIV_SHARP: f64 = 50.0;
/// Weight of the grad-div term over the viscosity in a flow without inertia: with a band, and with a sharp membrane (lambda = 10, mu = 0.01,
/// n = 20: 14 % of the energy from nowhere at 10, 2.8 % at 500).
const GRAD_DIV_STOKES: [f64; 2] = [10.0, 500.0];
/// Times at which prescribed velocities are sampled for the velocity scale.
const SAMPLES: usize = 64;
/// Degree of the quadrature rule when the scene does not say: FreeFEM's.
const QUADRATURE: usize = 5;

/// Level sets at time 0 as functions.
type Functions<const D: usize> = Vec<Arc<InitialFunction<D>>>;

/// A scene brought to the point where it can run.
pub struct Model<const D: usize = 2> {
    /// The simulation at time 0.
    pub simulation: Simulation<D>,
    /// What the user should know before it runs.
    pub warnings: Vec<Warning>,
    /// Largest stable step of the explicit coupling (1.54) at the start, if there is one.
    pub explicit_limit: Option<f64>,
    /// Shortest and longest edge in the bands at the start.
    pub band_edges: Option<[f64; 2]>,
    /// The half-width of the bands.
    pub thickness: Option<f64>,
    /// The velocity scale that grad-div was derived from, if it was.
    pub velocity_scale: Option<f64>,
    /// What was found about the mesh.
    pub quality: mesh::Quality<D>,
    /// Nodes on the boundary, periodic sides left aside.
    pub(super) wall_nodes: Vec<u32>,
    /// What an adapted mesh keeps to.
    pub(super) lengths: Option<Lengths>,
}

impl<const D: usize> Model<D>
where
    In<D>: Dimension<D>,
{
    /// Builds the model of a scene.
    ///
    /// # Errors
    /// Of kind `Scene` or `Input`: whatever cannot be run, with its place; a scene that has not `D` dimensions.
    pub fn new(scene: &Scene) -> Result<Model<D>> {
        if scene.dimension() != D {
            let e = Error::scene(format!("a scene of {} dimensions has no model of {D}", scene.dimension()));
            return Err(scene.blame(&["mesh"], e.remedy("build the model of the dimension of its mesh")));
        }
        let (mesh, mut warnings) = In::<D>::mesh(scene)?;
        // `walls` names every side: whether one lacks a condition is told by name and place when the unknowns are numbered.
        let given = with_walls(mesh);
        let lengths = scene.adapt.as_ref().map(|a| Lengths::new(scene, a, &given)).transpose()?;
        let mesh = Arc::new(match &lengths {
            Some(lengths) => In::<D>::adapted_start(scene, given, lengths)?,
            None => given,
        });
        let (quality, found) = mesh::check(&mesh);
        warnings.extend(found);
        if quality.parts > 1 {
            let file = if let MeshSource::File { path, .. } = &scene.mesh {
                path.display().to_string()
            } else {
                String::new()
            };
            let what = "the mesh falls into parts that are not connected, and one pressure cannot be fixed in each";
            return Err(Error::input(what)
                .at(file)
                .value(format!("{} parts", quality.parts))
                .remedy("run each part on its own, or join them (gmsh: Coherence; before meshing)"));
        }
        warnings.extend(unreached_profiles(scene));
        let conditions = conditions(scene, &mesh)?;
        check_motion_is_fixed(scene)?;
        let space = Space::new(&mesh, Element::P2);
        let pairs = fem::periodic_pairs(&mesh, &conditions).map_err(|e| scene.blame(&["boundary"], e))?;
        warnings.extend(check_inflow(scene, &mesh, &pairs)?);
        check_map(scene, !pairs.is_empty())?;
        check_slice(scene, mesh.bounding_box())?;
        let mut model = Draft { scene, mesh: &mesh, space: &space, pairs, warnings };
        if let Some(image) = &scene.image {
            return segmenting(scene, image, model, conditions, quality);
        }
        if scene.fluid.is_prescribed() {
            return prescribed(scene, model, conditions, quality, lengths);
        }
        let (distances, functions) = model.distances()?;
        let thickness = model.thickness(&distances)?;
        let structures = model.structures(distances, &functions, thickness)?;
        let edges = edges_in_bands(&space, structures.iter().map(|s| (s, &s.phi[..])));
        let scales = [model.velocity_scale(), model.size()];
        let velocity_scale = scene.numerics.grad_div.is_none().then(|| model.velocity_scale());
        let grad_div = scene.numerics.grad_div.unwrap_or_else(|| model.grad_div(velocity_scale.unwrap_or(0.0)));
        let settings = model.settings(conditions, grad_div);
        settings.check_coupling(&structures).map_err(|e| scene.blame(&["numerics", "coupling"], e))?;
        let level_sets = model.level_sets()?;
        model.check_finite("initial_velocity", &scene.fluid.initial_velocity)?;
        model.check_finite("force", &scene.fluid.force)?;
        let wall_nodes = wall_nodes(&space, &model.pairs);
        let warnings = model.warnings;
        let initial = vector(&scene.fluid.initial_velocity);
        let mut simulation = Simulation::new(&mesh, settings, structures, move |x| initial(x, 0.0))
            .map_err(|e| if e.kind() == Kind::Scene { scene.blame(&["boundary"], e) } else { e })?
            .with_passive(level_sets)?;
        simulation.compose(functions.clone(), scene.numerics.remap);
        redistance(scene, &mut simulation);
        if scene.output.backward_map {
            simulation.carry_backward_map();
        }
        if scene.membranes.iter().any(|m| m.mapped) {
            let mapped = scene.membranes.iter().zip(functions).map(|(m, f)| m.mapped.then_some(f)).collect();
            simulation.map_level_sets(mapped)?;
        }
        let mut model = Model {
            simulation,
            warnings,
            explicit_limit: None,
            band_edges: edges,
            thickness,
            velocity_scale,
            quality,
            wall_nodes,
            lengths,
        };
        model.explicit_limit = model.step_limit();
        if let Some(tolerance) = scene.time.tolerance {
            let pacing = pacing(scene, tolerance, scales);
            model.simulation.pace(pacing).map_err(|e| scene.blame(&["time", "tolerance"], e))?;
        }
        Ok(model)
    }

    /// Makes the mesh anew where it no longer fits interfaces or fields, and goes on upon it. Returns whether it did.
    ///
    /// # Errors
    /// Those of [`Simulation::on_mesh`].
    pub fn follow(&mut self, scene: &Scene) -> Result<bool> {
        In::<D>::follow(self, scene)
    }

    /// Goes on upon another mesh of the domain.
    ///
    /// # Errors
    /// Those of [`Simulation::on_mesh`].
    pub(super) fn go_on(&mut self, mesh: Mesh<D>, transfer: Transfer) -> Result<()> {
        In::<D>::go_on(self, mesh, transfer)
    }
}

impl<const D: usize> Model<D> {
    /// Whether the band of structure number `k` has reached the boundary: the stress is cut off there.
    pub fn band_is_cut(&self, k: usize) -> bool {
        let (s, phi) = (&self.simulation.structures()[k], &self.simulation.state().phi[k]);
        self.wall_nodes.iter().any(|&n| phi[n as usize].abs() < s.reach())
    }

    /// The limit (1.54) for the current tension, with the finest edge of the bands; `None` without tension.
    pub fn step_limit(&self) -> Option<f64> {
        let [edge, _] = self.band_edges?;
        let viscosity = self.simulation.least_viscosity();
        self.simulation
            .structures()
            .iter()
            .map(|s| s.step_limit(viscosity, edge))
            .filter(|limit| limit.is_finite())
            .reduce(f64::min)
    }
}

/// What the steps of [`Model::new`] share.
pub(super) struct Draft<'a, const D: usize> {
    pub scene: &'a Scene,
    pub mesh: &'a Arc<Mesh<D>>,
    pub space: &'a Space<D>,
    /// Pairs of facets on periodic sides.
    pub pairs: Vec<fem::Translation<D>>,
    pub warnings: Vec<Warning>,
}

impl<const D: usize> Draft<'_, D>
where
    In<D>: Dimension<D>,
{
    fn size(&self) -> f64 {
        let (lo, hi) = self.mesh.bounding_box();
        0.5 * (hi - lo).min()
    }

    /// Signed distances of all membranes at the nodes, and the level sets at time 0 as functions.
    fn distances(&self) -> Result<(Vec<Vec<f64>>, Functions<D>)> {
        let (mut all, mut functions) = (Vec::new(), Vec::new());
        for (k, m) in self.scene.membranes.iter().enumerate() {
            let Placed { nodal, function } =
                self.placed(&m.shape, &shape_keys(self.scene, k).each_ref().map(String::as_str))?;
            all.push(nodal);
            functions.push(self.level_set_of(m, function));
        }
        Ok((all, functions))
    }

    /// Signed distances of all interfaces at the nodes, those of membranes first.
    pub(super) fn all_distances(&self) -> Result<Vec<Vec<f64>>> {
        let mut all = self.distances()?.0;
        for (k, s) in self.scene.level_sets.iter().enumerate() {
            all.push(self.placed(&s.shape, &["level_set", &k.to_string(), "shape"])?.nodal);
        }
        Ok(all)
    }

    /// The distance to the nearest of the images that periodic sides make of a shape, so that the level set is periodic too.
    pub(super) fn with_images(&self, mut distance: Vec<f64>, shape: &dyn Shape<D>, shifts: &[Point<D>]) -> Vec<f64> {
        for (d, x) in distance.iter_mut().zip(self.space.nodes()).filter(|_| shifts.len() > 1) {
            let images = shifts.iter().skip(1).map(|shift| shape.distance(&(x + shift)));
            *d = nearest_image(std::iter::once(*d).chain(images));
        }
        distance
    }

    /// The half-width of the bands: the scene's, or a multiple of the longest edge on the interfaces.
    fn thickness(&self, distances: &[Vec<f64>]) -> Result<Option<f64>> {
        if distances.is_empty() {
            return Ok(None);
        }
        let mut longest: f64 = 0.0;
        for (k, d) in distances.iter().enumerate() {
            let Some(edges) = band_edges(self.space, d, 0.0) else {
                let e = Error::scene("no part of the interface lies on the mesh")
                    .remedy("move the shape onto the mesh (does it lie in a hole?), or refine the mesh");
                return Err(self.scene.blame(&shape_keys(self.scene, k).each_ref().map(String::as_str), e));
            };
            longest = longest.max(edges.largest);
        }
        // Edges on the interface first, then those in the band that they make, which on a graded mesh are longer.
        let eps = BAND * longest;
        let longest =
            distances.iter().filter_map(|d| band_edges(self.space, d, eps)).map(|e| e.largest).fold(longest, f64::max);
        Ok(Some(self.scene.numerics.thickness.unwrap_or(BAND * longest)))
    }

    /// A warning when two bands overlap: their stresses are added, and the fluid between them is not resolved.
    fn warn_of_overlaps(&mut self, distances: &[Vec<f64>], eps: f64) {
        for (k, a) in distances.iter().enumerate() {
            for (l, b) in distances.iter().enumerate().skip(k + 1) {
                let (first, second) = (&self.scene.membranes[k], &self.scene.membranes[l]);
                // What pulls at nothing may lie where another one is.
                let pulls = first.area.modulus() > 0.0 && second.area.modulus() > 0.0;
                let near = (0..a.len()).find(|&n| a[n].abs() < eps && b[n].abs() < eps);
                if let Some(n) = near.filter(|_| pulls) {
                    let (first, second) = (&first.name, &second.name);
                    let at = self.space.nodes()[n];
                    self.warnings.push(Warning::new(
                        format!("the bands of `{first}` and `{second}` overlap, for example at {:.4?}", at.as_slice()),
                        "move the shapes apart by two band half-widths, or give a smaller thickness",
                    ));
                }
            }
        }
    }

    /// Refuses an expression of `[fluid]` that has no finite value at some node at time 0.
    pub(super) fn check_finite(&self, key: &str, v: &[Expression]) -> Result<()> {
        let f = vector(v);
        let bad = self.space.nodes().iter().find(|x| !f(x, 0.0).iter().all(|c| c.is_finite()));
        let Some(x) = bad else { return Ok(()) };
        let e = Error::scene(format!("`fluid.{key}` has no finite value everywhere"))
            .value(format!("{:?} at {:?}, t = 0", f(x, 0.0).as_slice(), x.as_slice()))
            .remedy("write an expression that is finite on the whole mesh");
        Err(self.scene.blame(&["fluid", key], e))
    }

    fn structures(
        &mut self,
        distances: Vec<Vec<f64>>,
        functions: &Functions<D>,
        thickness: Option<f64>,
    ) -> Result<Vec<Structure<D>>> {
        let mut structures = Vec::new();
        let (kernel, norm) = (self.scene.numerics.kernel, self.scene.numerics.width);
        let walls = wall_nodes(self.space, &self.pairs);
        self.warn_of_overlaps(&distances, thickness.unwrap_or(0.0));
        for (k, (m, distance)) in self.scene.membranes.iter().zip(distances).enumerate() {
            let eps = thickness.unwrap_or(0.0);
            // A sharp force needs no band; a fluid that changes across the interface does.
            let banded = m.force == Force::Smeared || m.mass > 0.0 || self.scene.inside(k).is_some();
            let renormalised = m.force == Force::Smeared && band_of(self.scene, m) == Band::Renormalised;
            let widest = if renormalised { norm.largest(D) } else { 1.0 };
            let adapts = self.scene.adapt.is_some();
            let remedy = "give a larger thickness, or shorter mesh.adapt.edge and along (adapted edges reach 1.4 times what is asked for), \
                          or a mesh.adapt.width above the thickness";
            let check = if banded { check_band(self.space, &distance, eps) } else { Ok(None) };
            let check = check.map_err(|e| if adapts { e.remedy(remedy) } else { e });
            let check = check.and_then(|warning| {
                let adapted = |w: Warning| if adapts { Warning::new(w.what, remedy) } else { w };
                self.warnings.extend(warning.map(adapted));
                let reach = if banded { eps * widest } else { 0.0 };
                let margin = walls.iter().map(|&n| distance[n as usize].abs()).fold(f64::INFINITY, f64::min);
                if margin > reach {
                    return Ok(());
                }
                Err(Error::scene(format!("the band of `{}` reaches the boundary of the mesh", m.name))
                    .value(format!("half-width {reach}, distance to the boundary {margin:.4}"))
                    .remedy("give a smaller thickness, move the shape, or enlarge the mesh"))
            });
            let [list, _] = self.scene.structure_keys(k);
            let key =
                if self.scene.numerics.thickness.is_some() { vec!["numerics", "thickness"] } else { vec![&list[..]] };
            check.map_err(|e| self.scene.blame(&key, e))?;
            let phi: Vec<f64> = match m.map.is_empty() {
                true => distance.iter().map(|d| d * m.stretch).collect(),
                false => self.space.interpolate(|x| functions[k](x)),
            };
            check_rest_map(self.scene, (k, m), self.space, &phi, &distance, eps)?;
            structures.push(Structure {
                name: self.scene.membranes[k].name.clone(),
                phi,
                membrane: Membrane::new(m.area, eps)
                    .with_band(band_of(self.scene, m), m.stretch)
                    .with_kernel(kernel, norm),
                sharp: self.sharp(k, m),
                continuum: self.continuum(m, eps),
                shear: m.surface.map(|law| self.sheared(m, law, eps)),
                inside: self.scene.inside(k),
                stretch: m.stretch,
                surface_mass: m.mass,
            });
        }
        Ok(structures)
    }

    /// The membrane on the interface itself, if the scene asks for it.
    fn sharp(&self, k: usize, membrane: &schema::Membrane) -> Option<SharpMembrane<D>> {
        let outside = self.scene.outside();
        let inside = self.scene.inside(k).unwrap_or(outside);
        let mean = 0.5 * (inside.viscosity + outside.viscosity);
        (membrane.force == Force::Sharp).then(|| SharpMembrane::new(membrane.area, mean, In::<D>::surface))
    }

    /// Surface tension as a continuum force, if the scene asks for it.
    fn continuum(&self, membrane: &schema::Membrane, eps: f64) -> Option<ContinuumForce<D>> {
        let band = band_of(self.scene, membrane);
        let (kernel, norm) = (self.scene.numerics.kernel, self.scene.numerics.width);
        let force = ContinuumForce::new(membrane.area.modulus(), eps).with_band(band, membrane.stretch);
        self.scene.numerics.has_continuum_force().then(|| force.with_kernel(kernel, norm))
    }

    /// The largest of the speeds that walls, the start, gravity and the elastic waves of the membranes give.
    fn velocity_scale(&self) -> f64 {
        let (fluid, length) = (&self.scene.fluid, self.size());
        let density = self.heaviest();
        let initial = vector(&fluid.initial_velocity);
        let mut speed = self.mesh.points().iter().map(|x| initial(x, 0.0).norm()).fold(0.0, f64::max);
        for b in &self.scene.boundaries {
            if let (Condition::Velocity(v), Ok(facets)) = (&b.condition, self.mesh.boundary(&b.name)) {
                let v = vector(v);
                for &f in facets {
                    for n in self.space.facet_nodes(&self.mesh.facets()[f as usize]) {
                        // Multiples of the golden ratio meet no period of an oscillation.
                        for k in 0..SAMPLES {
                            let t = self.scene.time.end * (k as f64 * 0.618_033_988_749_895).fract();
                            speed = speed.max(v(&self.space.nodes()[n as usize], t).norm());
                        }
                    }
                }
            }
        }
        if density > 0.0 {
            for m in &self.scene.membranes {
                let modulus = m.surface.map_or(m.area.modulus(), SurfaceLaw::modulus);
                speed = speed.max((modulus / (density * length)).sqrt());
            }
            let gravity = SVector::<f64, D>::from_iterator(fluid.gravity.iter().copied()).norm();
            speed = speed.max((gravity * length).sqrt());
            let force = vector(&fluid.force);
            let force = self.mesh.points().iter().map(|x| force(x, 0.0).norm()).fold(0.0, f64::max);
            speed = speed.max((force * length / density).sqrt());
        }
        speed
    }

    /// `gamma` in units where `rho U L = 1`, at least the viscosity.
    fn grad_div(&self, speed: f64) -> f64 {
        let viscosity = self.scene.fluids().map(|f| f.viscosity).fold(0.0, f64::max);
        let sharp = self.scene.membranes.iter().any(schema::Membrane::is_sharp);
        if !self.scene.has_inertia() {
            return GRAD_DIV_STOKES[usize::from(sharp)] * viscosity;
        }
        let density = self.heaviest();
        let weight = if sharp { GRAD_DIV_SHARP } else { GRAD_DIV[usize::from(self.scene.membranes.is_empty())] };
        (weight * density * speed * self.size()).max(viscosity)
    }

    /// The largest density that inertia has.
    fn heaviest(&self) -> f64 {
        let outside = self.scene.outside().density;
        if self.scene.fluid.boussinesq {
            outside
        } else {
            self.scene.fluids().map(|f| f.density).fold(outside, f64::max)
        }
    }

    pub(super) fn settings(&self, conditions: Conditions<D>, grad_div: f64) -> sim::Settings<D> {
        let (fluid, numerics) = (&self.scene.fluid, &self.scene.numerics);
        let body_force = fluid.has_force().then(|| {
            let f = vector(&fluid.force);
            Arc::new(move |x: &Point<D>, t: f64| f(x, t)) as Arc<crate::flow::BodyForce<D>>
        });
        sim::Settings {
            dt: self.scene.time.step,
            order: self.scene.time.order,
            transport: numerics.transport,
            coupling: numerics.coupling,
            convection: numerics.convection.unwrap_or(self.scene.has_inertia()),
            grad_div,
            solve_tolerance: numerics.solve_tolerance,
            solving: numerics.solving,
            quadrature: numerics.quadrature.unwrap_or(QUADRATURE),
            fluid: self.scene.outside(),
            boussinesq: fluid.boussinesq,
            pressure: numerics.pressure,
            conditions,
            gravity: SVector::<f64, D>::from_iterator(fluid.gravity.iter().copied()),
            body_force,
        }
    }
}

/// Where the shape of structure number `k` is written.
fn shape_keys(scene: &Scene, k: usize) -> [String; 3] {
    let [list, number] = scene.structure_keys(k);
    [list, number, "shape".into()]
}

/// Shortest and longest edge in the bands of structures with these level sets.
pub(super) fn edges_in_bands<'a, const D: usize>(
    space: &Space<D>,
    bands: impl Iterator<Item = (&'a Structure<D>, &'a [f64])>,
) -> Option<[f64; 2]> {
    let edges = bands.filter_map(|(s, phi)| band_edges(space, phi, s.membrane.thickness()));
    edges.map(|e| [e.smallest, e.largest]).reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
}

/// Nodes on the boundary, periodic sides left aside.
pub(super) fn wall_nodes<const D: usize>(space: &Space<D>, pairs: &[fem::Translation<D>]) -> Vec<u32> {
    let facets = space.mesh().facets();
    let mut wall = vec![true; facets.len()];
    pairs.iter().for_each(|p| wall[p.facet as usize] = false);
    let facets = facets.iter().zip(wall).filter(|(_, wall)| *wall);
    facets.flat_map(|(f, _)| space.facet_nodes(f).collect::<Vec<_>>()).collect()
}

/// Adds the name `walls` for the whole boundary to a mesh that does not have it.
fn with_walls<const D: usize>(mut mesh: Mesh<D>) -> Mesh<D> {
    if !mesh.boundaries().contains_key(schema::WALLS) {
        let all = (0..mesh.facets().len() as u32).collect();
        mesh.set_boundary(schema::WALLS, all);
    }
    mesh
}

pub(super) fn conditions<const D: usize>(scene: &Scene, mesh: &Mesh<D>) -> Result<Conditions<D>> {
    let mut list = Conditions::new();
    for b in &scene.boundaries {
        let place = |e| scene.blame(&["boundary", &b.name], e);
        mesh.boundary(&b.name).map_err(place)?;
        let condition = match &b.condition {
            Condition::Velocity(v) => {
                let v = vector(v);
                fem::Condition::Velocity(Arc::new(move |x, t| v(x, t)))
            }
            Condition::NoSlip => fem::Condition::NoSlip,
            Condition::Slip => fem::Condition::Slip,
            Condition::Open => fem::Condition::Open,
            Condition::Periodic(other) => {
                mesh.boundary(other).map_err(place)?;
                fem::Condition::Periodic(other.clone())
            }
        };
        list.push((b.name.clone(), condition));
    }
    Ok(list)
}

/// Refuses pictures on a plane that misses the domain.
fn check_slice<const D: usize>(scene: &Scene, (low, high): (Point<D>, Point<D>)) -> Result<()> {
    let Some((axis, at)) = scene.output.picture.slice.and_then(|s| Some((s.axis, s.at?))) else { return Ok(()) };
    if axis < D && (low[axis]..=high[axis]).contains(&at) {
        return Ok(());
    }
    let e = Error::scene("the plane of the pictures misses the domain")
        .value(at)
        .remedy(format!("give a coordinate from {} to {}", low[axis], high[axis]));
    Err(scene.blame(&["output", "picture", "slice"], e))
}

/// The band of a membrane: the scene's, or the book's, but one that is carried where the tension is constant, which with the
/// other would feed the currents about a drop at rest.
pub(super) fn band_of(scene: &Scene, membrane: &schema::Membrane) -> Band {
    let tension = matches!(membrane.area, AreaLaw::Tension { .. });
    scene.numerics.band.unwrap_or(if tension { Band::Carried } else { Band::Renormalised })
}

/// Expressions as a vector function, one a component.
pub(super) fn vector<const D: usize>(
    v: &[Expression],
) -> impl Fn(&Point<D>, f64) -> SVector<f64, D> + Send + Sync + 'static {
    let v = v.to_vec();
    move |x, t| SVector::<f64, D>::from_fn(|i, _| v.get(i).map_or(0.0, |e| e.eval(coordinates(x), t)))
}
