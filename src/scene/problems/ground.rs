//! Common construction of problems: mesh, conditions and structures of a scene.

use crate::base::{Error, Result, Warning};
use crate::elastic::Band;
use crate::fem::Translation;
use crate::levelset::band_edges;
use crate::mesh::{self, Mesh, Point, Quality};
use crate::scene::Scene;
use crate::scene::adapt::{Lengths, adapted_start};
use crate::scene::checks::unreached_profiles;
use crate::scene::expression::Expression;
use crate::scene::keys::Tabled;
use crate::scene::meshing;
pub(super) use crate::scene::placing::place;
use crate::scene::schema::{Boundary, Condition, MeshSource, Window};
use crate::scene::script::Script;
use crate::scene::sides;
use crate::scene::site::{BAND, Placed, Site, vector, wall_facets};
use crate::scene::structures::{Build, Traits, band_of, kind_in};
use crate::sim::Transport;
use crate::structure::Structure;
use crate::transport::Method;
use std::any::Any;
use std::sync::Arc;

/// A mesh, if it is plane.
pub(super) fn plane<const D: usize>(mesh: &Mesh<D>) -> Option<&Mesh<2>> {
    let mesh: &dyn Any = mesh;
    mesh.downcast_ref()
}

/// Number of times at which a time-dependent velocity is sampled for checks.
const SAMPLES: usize = 16;
/// A normal velocity below this fraction of the largest speed is a rounding error, such as sin(pi).
const ROUNDING: f64 = 1e-9;
/// Default degree of the quadrature rule, the same as in FreeFEM.
pub(super) const QUADRATURE: usize = 5;

/// Builds and checks the mesh of a scene, with adaptation if requested. Returns the target lengths
/// of an adapted mesh.
///
/// # Errors
/// A scene of another dimension; a mesh that cannot be built or is not connected; names and
/// conditions that do not fit the mesh.
pub(super) fn site<const D: usize>(scene: &Scene) -> Result<(Site<'_, D>, Option<Lengths>)> {
    if scene.dimension() != D {
        let e = Error::scene(format!(
            "a scene of {} dimensions has no model of {D}",
            scene.dimension()
        ));
        return Err(
            scene.blame(&["mesh"], e.remedy("build the model of the dimension of its mesh"))
        );
    }
    let (mesh, mut warnings) = meshing::mesh::<D>(scene)?;
    // `walls` covers every side. A side without a condition is reported by name and position when
    // the unknowns are numbered.
    let given = meshing::with_walls(mesh);
    let lengths = scene.adapt.as_ref().map(|a| Lengths::new(scene, a, &given)).transpose()?;
    let mesh = Arc::new(match &lengths {
        Some(lengths) => adapted_start(scene, given, lengths)?,
        None => given,
    });
    let (quality, found) = mesh::check(&mesh);
    warnings.extend(found);
    check_parts(scene, &quality)?;
    warnings.extend(unreached_profiles(scene));
    let mut site = Site::new(scene, mesh, quality)?;
    warnings.extend(check_inflow(scene, &site.mesh, &site.pairs)?);
    warnings.extend(sides::check(scene, &site)?);
    check_map(scene, !site.pairs.is_empty())?;
    check_pictures(scene, site.mesh.bounding_box())?;
    site.warnings = warnings;
    Ok((site, lengths))
}

/// Half-width of the bands: given by the scene, or a multiple of the longest edge on the acting
/// interfaces; `None` if there is none.
///
/// # Errors
/// An interface that does not intersect the mesh.
pub(super) fn thickness<const D: usize>(
    scene: &Scene,
    site: &Site<'_, D>,
    placed: &[Option<Placed<D>>],
) -> Result<Option<f64>> {
    let mut longest: f64 = 0.0;
    let acting = |k: &usize| scene.structures()[*k].traits().acts;
    let distances =
        || (0..placed.len()).filter(acting).filter_map(|k| Some((k, &placed[k].as_ref()?.nodal)));
    for (k, d) in distances() {
        let Some(edges) = band_edges(&site.space, d, 0.0) else {
            let e = Error::scene("no part of the interface lies on the mesh").remedy(
                "move the shape onto the mesh (does it lie in a hole?), or refine the mesh",
            );
            let [list, number] = scene.structure_keys(k);
            return Err(scene.blame(&[&list, &number, "shape"], e));
        };
        longest = longest.max(edges.largest);
    }
    if distances().next().is_none() {
        return Ok(None);
    }
    // The edges on the interface count: longer ones in the band of a graded mesh would make it
    // wider, until it meets the coarsest ones. They are warned of when the band is checked.
    Ok(Some(scene.numerics.thickness.unwrap_or(BAND * longest)))
}

/// Builds the structures of a scene.
///
/// # Errors
/// Values that do not fit the mesh, with their position.
pub(super) fn structures<const D: usize>(
    scene: &Scene,
    site: &mut Site<'_, D>,
    placed: Vec<Option<Placed<D>>>,
    thickness: Option<f64>,
) -> Result<Vec<Box<dyn Structure<D>>>> {
    let (walls, eps) = (site.wall_nodes(), thickness.unwrap_or(0.0));
    warn_of_overlaps(scene, site, &placed, eps);
    let mut all = Vec::new();
    for (k, (kind, placed)) in scene.structures().iter().zip(placed).enumerate() {
        let (keys, inside) = (scene.structure_keys(k), scene.inside(&**kind));
        check_sign(scene, site, k, placed.as_ref())?;
        let mut build = Build { site, keys, placed, thickness: eps, inside, walls: &walls };
        all.push(kind_in::<D>(&**kind)?.build(&mut build)?);
    }
    Ok(all)
}

/// Checks that a shape is not inside out: negative on the whole boundary. An interface that acts is
/// closed, and this is an error; one that is passive, or ends at periodic sides, may have two
/// insides along the walls.
///
/// # Errors
/// Such a shape.
fn check_sign<const D: usize>(
    scene: &Scene,
    site: &mut Site<'_, D>,
    k: usize,
    placed: Option<&Placed<D>>,
) -> Result<()> {
    let walls = site.wall_nodes();
    let Some(Placed { nodal, .. }) = placed.filter(|_| !walls.is_empty()) else { return Ok(()) };
    if !walls.iter().all(|&n| nodal[n as usize] < 0.0) {
        return Ok(());
    }
    let kind = &scene.structures()[k];
    let what =
        format!("the shape of `{}` is inside out: negative on the whole boundary", kind.name());
    let remedy = "change the sign of shape.expression: it is negative inside, positive outside";
    if !kind.traits().acts || !site.pairs.is_empty() {
        site.warnings.push(Warning::new(what, remedy));
        return Ok(());
    }
    let [list, number] = scene.structure_keys(k);
    let value = kind.shape().map(|s| s.inline()).unwrap_or_default();
    Err(scene.blame(&[&list, &number, "shape"], Error::scene(what).value(value).remedy(remedy)))
}

/// For each structure, the slope that its band is measured with, if the band is carried.
pub(super) fn carried_bands(scene: &Scene) -> Vec<Option<f64>> {
    let slope = |traits: Traits| {
        let carried = band_of(&scene.numerics, traits.constant_tension) == Band::Carried;
        (traits.acts && carried).then_some(traits.slope)
    };
    scene.structures().iter().map(|s| slope(s.traits())).collect()
}

/// Options of the transport.
pub(super) fn transport(scene: &Scene) -> Transport {
    let numerics = &scene.numerics;
    Transport {
        method: numerics.transport,
        remap: numerics.remap,
        quadrature: numerics.quadrature.unwrap_or(QUADRATURE),
        backward_map: scene.output.backward_map,
    }
}

/// A warning if two bands overlap: their stresses are added, and the fluid between them is not
/// resolved.
fn warn_of_overlaps<const D: usize>(
    scene: &Scene,
    site: &mut Site<'_, D>,
    placed: &[Option<Placed<D>>],
    eps: f64,
) {
    // A structure without force may overlap with others.
    let has_band = |t: &Traits| t.pulls && (!t.on_interface || t.mass > 0.0);
    let pulling = scene.structures().iter().zip(placed).filter(|(s, _)| has_band(&s.traits()));
    let pulling: Vec<_> = pulling.filter_map(|(s, p)| Some((s, &p.as_ref()?.nodal))).collect();
    for (k, (first, a)) in pulling.iter().enumerate() {
        for (second, b) in pulling.iter().skip(k + 1) {
            let near = (0..a.len()).find(|&n| a[n].abs() < eps && b[n].abs() < eps);
            if let Some(n) = near {
                let (first, second, at) = (first.name(), second.name(), site.space.nodes()[n]);
                let what = format!(
                    "the bands of `{first}` and `{second}` overlap, for example at {:.4?}",
                    at.as_slice()
                );
                let advice =
                    "move the shapes apart by two band half-widths, or give a smaller thickness";
                site.warnings.push(Warning::new(what, advice));
            }
        }
    }
}

/// Rejects features of backward characteristics that do not work with particles crossing periodic
/// sides: a map to the position at rest, a level set computed from the map, and composed transport.
fn check_map(scene: &Scene, periodic: bool) -> Result<()> {
    let composed = scene.numerics.transport == Method::Composed;
    if scene.output.backward_map && composed && (periodic || scene.structures().is_empty()) {
        let what = "composed transport tells the backward characteristics of a scene with \
            interfaces and without periodic sides";
        let e = Error::scene(what)
            .value("backward_map = true")
            .remedy("take numerics.transport = \"nodal\"");
        return Err(scene.blame(&["output", "backward_map"], e));
    }
    for (k, s) in scene.structures().iter().enumerate().filter(|_| periodic) {
        let traits = s.traits();
        let sheared = (traits.resists_shear && composed)
            .then_some(("shear", "shear with composed transport"));
        if let Some((key, what)) = traits.not_periodic.or(sheared) {
            let e = Error::scene(format!(
                "{what} cannot be had where particles pass periodic sides"
            ))
            .remedy(
                "give walls or prescribed velocities in place of periodic sides, or leave it out",
            );
            let [list, number] = scene.structure_keys(k);
            return Err(scene.blame(&[&list, &number, key], e));
        }
    }
    Ok(())
}

fn check_parts<const D: usize>(script: &Script, quality: &Quality<D>) -> Result<()> {
    if quality.parts <= 1 {
        return Ok(());
    }
    let file = match &script.mesh {
        MeshSource::File { path, .. } => path.display().to_string(),
        _ => String::new(),
    };
    let what = "the mesh falls into parts that are not connected, and one pressure cannot be \
        fixed in each";
    Err(Error::input(what)
        .at(file)
        .value(format!("{} parts", quality.parts))
        .remedy("run each part on its own, or join them (gmsh: Coherence; before meshing)"))
}

/// Rejects pictures of what is outside the domain.
fn check_pictures<const D: usize>(
    script: &Script,
    (low, high): (Point<D>, Point<D>),
) -> Result<()> {
    let window = script.output.picture.window.as_ref();
    let misses = |w: &&Window| (0..D).any(|k| w.max[k] <= low[k] || w.min[k] >= high[k]);
    if let Some(Window { min, max }) = window.filter(misses) {
        let e = Error::scene("the window of the pictures misses the domain")
            .value(format!("{min:?} to {max:?}"))
            .remedy(format!(
                "give corners in the domain, which spans {:?} to {:?}",
                low.as_slice(),
                high.as_slice()
            ));
        return Err(script.blame(&["output", "picture", "window"], e));
    }
    let Some((axis, at)) = script.output.picture.slice.and_then(|s| Some((s.axis, s.at?))) else {
        return Ok(());
    };
    if axis < D && (low[axis]..=high[axis]).contains(&at) {
        return Ok(());
    }
    let e = Error::scene("the plane of the pictures misses the domain")
        .value(at)
        .remedy(format!("give a coordinate from {} to {}", low[axis], high[axis]));
    Err(script.blame(&["output", "picture", "slice"], e))
}

/// Rejects composed transport with inflow: a particle that was outside at time 0 has no value
/// there. Warns of projected transport with inflow, which amplifies the values that characteristics
/// carry in from the boundary.
fn check_inflow<const D: usize>(
    scene: &Scene,
    mesh: &Mesh<D>,
    pairs: &[Translation<D>],
) -> Result<Option<Warning>> {
    if scene.structures().is_empty() || scene.numerics.transport == Method::Nodal {
        return Ok(None);
    }
    let Some(side) = inflow(scene, mesh, pairs) else { return Ok(None) };
    if scene.numerics.transport == Method::Composed {
        let e = Error::scene(format!(
            "composed transport cannot be used where fluid comes in, as it may through {side}"
        ))
        .value("transport = \"composed\"")
        .remedy(
            "use transport = \"nodal\": a particle that was outside at time 0 has no value to \
             bring along",
        );
        return Err(scene.blame(&["numerics", "transport"], e));
    }
    let what =
        format!("projected transport is unstable where fluid comes in, as it may through {side}");
    Ok(Some(Warning::new(
        what,
        "use transport = \"nodal\" unless that side only moves along itself",
    )))
}

/// A part of the boundary with possible inflow.
pub(super) fn inflow<const D: usize>(
    scene: &Scene,
    mesh: &Mesh<D>,
    pairs: &[Translation<D>],
) -> Option<String> {
    let enters = |facets: &[u32], v: &[Expression]| {
        let v = vector(v);
        let times = |k: usize| scene.time.end * k as f64 / (SAMPLES - 1) as f64;
        let mut fastest: f64 = 0.0;
        let mut inward: f64 = 0.0;
        for &f in facets {
            let facet = &mesh.facets()[f as usize];
            let (n, _) = mesh.facet_normal(facet);
            let ends: Vec<Point<D>> =
                mesh.facet_points(facet).map(|p| mesh.points()[p as usize]).collect();
            let middle = ends.iter().fold(Point::<D>::zeros(), |s, x| s + x) / ends.len() as f64;
            for x in ends.iter().chain([&middle]) {
                for u in (0..SAMPLES).map(|k| v(x, times(k))) {
                    fastest = fastest.max(u.norm());
                    inward = inward.max(-u.dot(&n));
                }
            }
        }
        inward > ROUNDING * fastest
    };
    if let Some(v) = &scene.fluid.prescribed_velocity {
        let facets: Vec<u32> = wall_facets(mesh, pairs).map(|(f, _)| f).collect();
        return enters(&facets, v).then(|| "the boundary of the mesh".to_string());
    }
    let lets_in = |b: &&Boundary| match (&b.condition, mesh.boundary(&b.name)) {
        (condition, _) if condition.is_open() => true,
        (Condition::Velocity(v), Ok(facets)) => enters(facets, v),
        _ => false,
    };
    scene.boundaries.iter().find(lets_in).map(|b| format!("boundary `{}`", b.name))
}
