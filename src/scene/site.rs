//! The mesh of a scene with spaces, links and conditions, on which problems are built.

use super::expression::Expression;
use super::images::Images;
use super::points::coordinates;
use super::schema::{Condition, Opening, Shape};
use super::script::Script;
use super::shapes;
use crate::base::{Error, Result, Warning};
use crate::fem::{self, Conditions, Element, Space};
use crate::levelset::check_inside;
use crate::mesh::{Facet, Mesh, Point, Quality};
use crate::structure::InitialFunction;
use nalgebra::SVector;
use std::sync::Arc;

/// Default half-width of the band in edges of the mesh.
pub(super) const BAND: f64 = 2.5;

/// The signed distance of a shape at time 0.
pub(super) struct Placed<const D: usize> {
    /// Values at the nodes.
    pub nodal: Vec<f64>,
    /// The distance as a function of the point.
    pub function: Arc<InitialFunction<D>>,
}

/// A scene with its mesh.
pub(super) struct Site<'a, const D: usize> {
    pub script: &'a Script,
    pub mesh: Arc<Mesh<D>>,
    /// P2 space.
    pub space: Arc<Space<D>>,
    /// Conditions on the boundary.
    pub conditions: Conditions<D>,
    /// Pairs of facets on periodic sides.
    pub pairs: Vec<fem::Translation<D>>,
    pub warnings: Vec<Warning>,
    /// Quality of the mesh.
    pub quality: Quality<D>,
}

impl<'a, const D: usize> Site<'a, D> {
    /// Builds the spaces and conditions of a scene on a mesh.
    ///
    /// # Errors
    /// Names and conditions that do not fit the mesh.
    pub fn new(script: &'a Script, mesh: Arc<Mesh<D>>, quality: Quality<D>) -> Result<Site<'a, D>> {
        let conditions = conditions(script, &mesh)?;
        let space = Arc::new(Space::new(&mesh, Element::P2));
        let pairs = fem::periodic_pairs(&mesh, &conditions);
        let pairs = pairs.map_err(|e| script.blame(&["boundary"], e))?;
        Ok(Site { script, mesh, space, conditions, pairs, warnings: Vec::new(), quality })
    }

    /// Half the shorter side of the domain.
    pub fn size(&self) -> f64 {
        let (lo, hi) = self.mesh.bounding_box();
        0.5 * (hi - lo).min()
    }

    /// The signed distance of the shape at `keys`. If it `may_end` on walls, it is given by a
    /// function that extends beyond them.
    ///
    /// # Errors
    /// A shape that does not lie on the mesh.
    pub fn placed(&self, shape: &Shape, keys: &[&str], may_end: bool) -> Result<Placed<D>> {
        let domain = self.mesh.bounding_box();
        let place = |e| self.script.blame(keys, e);
        let layered = matches!(shape, Shape::Expression(_));
        let open = may_end && layered;
        let shape = shapes::shape(shape, domain).map_err(place)?;
        let (mut low, mut high) = shape.bounds();
        // A shape continues periodically through a periodic side.
        for axis in (0..D).filter(|&axis| self.pairs.iter().any(|p| p.shift[axis] != 0.0)) {
            (low[axis], high[axis]) =
                (low[axis].max(domain.0[axis]), high[axis].min(domain.1[axis]));
        }
        if !open {
            let inside = check_inside((low, high), domain, 0.0);
            inside.map_err(|e| place(if layered { ends_on_walls(e) } else { e }))?;
        }
        let images = Images::new(shape, &self.space, &self.pairs);
        let nodal = images.nodal(&self.space, &self.pairs).map_err(place)?;
        Ok(Placed { nodal, function: Arc::new(move |x: &Point<D>| images.distance(x)) })
    }

    /// Nodes on the boundary without periodic sides.
    pub fn wall_nodes(&self) -> Vec<u32> {
        wall_nodes(&self.space, &self.pairs)
    }
}

/// The error for a function whose zero set meets the boundary: a layer, which no shift brings in.
fn ends_on_walls(e: Error) -> Error {
    let side = e.place().to_string();
    Error::scene(format!("the interface meets the boundary of the mesh, at the {side}"))
        .value(e.wrong_value().to_string())
        .remedy(
            "interfaces that exert forces end on no wall: make the sides that it meets periodic, \
             or write a function whose zero set is closed within the mesh",
        )
}

/// Nodes on the boundary without periodic sides.
pub(super) fn wall_nodes<const D: usize>(
    space: &Space<D>,
    pairs: &[fem::Translation<D>],
) -> Vec<u32> {
    wall_facets(space.mesh(), pairs).flat_map(|(_, f)| space.facet_nodes(f)).collect()
}

/// Facets on the boundary without periodic sides, with their numbers.
pub(super) fn wall_facets<'a, const D: usize>(
    mesh: &'a Mesh<D>,
    pairs: &[fem::Translation<D>],
) -> impl Iterator<Item = (u32, &'a Facet)> {
    let mut wall = vec![true; mesh.facets().len()];
    pairs.iter().for_each(|p| wall[p.facet as usize] = false);
    let numbered = (0..).zip(mesh.facets()).zip(wall);
    numbered.filter_map(|(facet, wall)| wall.then_some(facet))
}

/// Boundary conditions of a scene on a mesh.
///
/// # Errors
/// A name that the mesh does not have.
pub(super) fn conditions<const D: usize>(script: &Script, mesh: &Mesh<D>) -> Result<Conditions<D>> {
    let mut list = Conditions::new();
    for b in &script.boundaries {
        let place = |e| script.blame(&["boundary", &b.name], e);
        mesh.boundary(&b.name).map_err(place)?;
        let condition = match &b.condition {
            Condition::Velocity(v) => {
                let v = vector(v);
                fem::Condition::Velocity(Arc::new(move |x, t| v(x, t)))
            }
            Condition::NoSlip => fem::Condition::NoSlip,
            Condition::Slip => fem::Condition::Slip,
            Condition::Open(Opening::Stress) => fem::Condition::Open,
            Condition::Open(Opening::Gradient) => fem::Condition::Gradient,
            Condition::Pressure(p) => fem::Condition::Pressure(scalar(p)),
            Condition::TotalPressure(p) => fem::Condition::TotalPressure(scalar(p)),
            Condition::Traction(t) => {
                let t = vector(t);
                fem::Condition::Traction(Arc::new(move |x, time| t(x, time)))
            }
            Condition::Periodic(other) => {
                mesh.boundary(other).map_err(place)?;
                fem::Condition::Periodic(other.clone())
            }
        };
        list.push((b.name.clone(), condition));
    }
    Ok(list)
}

/// A function from an expression.
pub(super) fn scalar<const D: usize>(e: &Expression) -> fem::ScalarFunction<D> {
    let e = e.clone();
    Arc::new(move |x, t| e.eval(coordinates(x), t))
}

/// A vector function from expressions, one for each component.
pub(super) fn vector<const D: usize>(
    v: &[Expression],
) -> impl Fn(&Point<D>, f64) -> SVector<f64, D> + Send + Sync + 'static {
    let v = v.to_vec();
    move |x, t| {
        SVector::<f64, D>::from_fn(|i, _| v.get(i).map_or(0.0, |e| e.eval(coordinates(x), t)))
    }
}
