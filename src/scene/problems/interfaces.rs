//! Files of the interfaces and of the boundary.

use crate::base::Result;
use crate::fem::{Space, SurfacePoint};
use crate::levelset::Skeleton;
use crate::mesh::{Mesh, Point};
use crate::output::{FieldData, Mark, write_vtp};
use crate::scene::geometry;
use crate::scene::view::View;
use crate::structure::{Density, Structure};
use nalgebra::SVector;
use std::path::Path;

/// All interfaces at one time: their pieces with what lives on them.
struct Interfaces<const D: usize> {
    points: Vec<Point<D>>,
    pieces: Vec<[u32; D]>,
    velocity: Vec<SVector<f64, D>>,
    /// Names and values at the points; NaN on the interfaces that lack them.
    columns: Vec<(String, Vec<f64>)>,
    marks: Vec<Mark>,
}

/// Writes every interface as lines in the plane and triangles in space, with the velocity, and as
/// far as the interface has them `stretch`, `tension`, `concentration`, `area_change`, `shear`,
/// `curvature` and `gauss_curvature`. The cell field `interface NAME` is 1 on an interface.
///
/// # Errors
/// A level set that is not finite; a file that cannot be written.
pub(super) fn write<const D: usize>(path: &Path, view: &View<'_, D>) -> Result<()> {
    let mut all = Interfaces {
        points: Vec::new(),
        pieces: Vec::new(),
        velocity: Vec::new(),
        columns: Vec::new(),
        marks: Vec::new(),
    };
    for (k, s) in view.carried.structures().iter().enumerate() {
        if s.level_set().is_some() {
            let skeleton = Skeleton::new(view.space(), &view.level_set(k))?;
            let values = values(view, k, &**s, &skeleton.points);
            all.add(view, s.name(), &skeleton, values);
        }
    }
    let columns = all.columns.iter().map(|(name, v)| (&**name, FieldData::Scalar(v)));
    let mut fields = vec![("velocity", FieldData::Vector(&all.velocity))];
    fields.extend(columns);
    write_vtp(path, view.state.time, (&all.points, &all.pieces), &fields, &all.marks)
}

impl<const D: usize> Interfaces<D> {
    fn add(
        &mut self,
        view: &View<'_, D>,
        name: &str,
        skeleton: &Skeleton<D>,
        values: Vec<(&str, Vec<f64>)>,
    ) {
        let (first, pieces) = (self.points.len(), self.pieces.len());
        let (space, u) = (view.space(), &view.state.flow.u);
        let velocity = |p: &SurfacePoint<D>| space.value(u, p.at.cell, &p.at.barycentric);
        self.points.extend(skeleton.points.iter().map(|p| p.at.x));
        self.velocity.extend(skeleton.points.iter().map(|p| match u.is_empty() {
            true => SVector::zeros(),
            false => velocity(p),
        }));
        self.pieces.extend(skeleton.pieces.iter().map(|p| p.map(|v| v + first as u32)));
        for (what, values) in values {
            let known = self.columns.iter().position(|(n, _)| n == what);
            let k = known.unwrap_or_else(|| {
                self.columns.push((what.to_string(), vec![f64::NAN; first]));
                self.columns.len() - 1
            });
            self.columns[k].1.extend(values);
        }
        let points = self.points.len();
        self.columns.iter_mut().for_each(|(_, v)| v.resize(points, f64::NAN));
        let mut mark = vec![0; pieces];
        mark.resize(self.pieces.len(), 1);
        self.marks.push((format!("interface {name}"), mark));
        let pieces = self.pieces.len();
        self.marks.iter_mut().for_each(|(_, m)| m.resize(pieces, 0));
    }
}

/// What structure number `k` knows of its interface, at points on it.
fn values<const D: usize>(
    view: &View<'_, D>,
    k: usize,
    s: &dyn Structure<D>,
    points: &[SurfacePoint<D>],
) -> Vec<(&'static str, Vec<f64>)> {
    let (space, fields) = (view.space(), &view.state.fields);
    let at_points = |f: &[f64]| -> Vec<f64> {
        points.iter().map(|p| space.value(f, p.at.cell, &p.at.barycentric)).collect()
    };
    let mut found = Vec::new();
    let strained = D == 3 && (view.has_backward_map() || s.carries_strain());
    if strained {
        let strain = view.carried.surface_strain(fields, k, points);
        found.push(("area_change", strain.iter().map(|s| s.z1).collect()));
        found.push(("shear", strain.iter().map(|s| s.z2).collect()));
    }
    let carried = s.surface_density().filter(|_| !s.carries_strain());
    let stretch: Option<Vec<f64>> = match carried {
        Some((id, _)) => Some(at_points(fields.scalar(id)).iter().map(|m| 1.0 / m).collect()),
        // The slope of the level set is a stretch where the force takes it for one.
        None if s.acts() && !s.keeps_distance() && !s.resists_shear() => {
            Some(at_points(&slopes(space, &view.level_set(k), points)))
        }
        None => None,
    };
    if let Some(stretch) = stretch {
        let tension: Option<Vec<f64>> = stretch.iter().map(|r| s.tension_at(*r)).collect();
        found.push(match carried {
            Some((_, Density::Concentration)) => {
                ("concentration", stretch.iter().map(|r| 1.0 / r).collect())
            }
            _ => ("stretch", stretch),
        });
        found.extend(tension.map(|t| ("tension", t)));
    }
    if view.tables.output.curvature {
        found.extend(geometry::fields(view, k).into_iter().map(|(name, f)| {
            let mesh = space.mesh();
            let at = |p: &SurfacePoint<D>| {
                let corners = mesh.cell(p.at.cell).iter().zip(&p.at.barycentric);
                corners.map(|(&v, l)| l * f[v as usize]).sum()
            };
            (name, points.iter().map(at).collect())
        }));
    }
    found
}

/// `|grad phi|` at the nodes of the cells with the points, the gradient being the mean over the
/// cells around a node; elsewhere it means nothing.
fn slopes<const D: usize>(space: &Space<D>, phi: &[f64], points: &[SurfacePoint<D>]) -> Vec<f64> {
    let mut wanted = vec![false; space.len()];
    for p in points {
        space.cell_nodes(p.at.cell).iter().for_each(|&n| wanted[n as usize] = true);
    }
    let near = |c: usize| space.cell_nodes(c).iter().any(|&n| wanted[n as usize]);
    let gradient = |c: usize, l: &[f64; 4]| match near(c) {
        true => space.gradient(phi, c, l),
        false => SVector::zeros(),
    };
    space.means(gradient).iter().map(|g| g.norm()).collect()
}

/// Writes the boundary of a mesh; the cell field `boundary NAME` is 1 on a named part.
///
/// # Errors
/// A file that cannot be written.
pub(super) fn write_boundaries<const D: usize>(path: &Path, mesh: &Mesh<D>) -> Result<()> {
    let (mut points, mut numbers) = (Vec::new(), vec![u32::MAX; mesh.points().len()]);
    let mut pieces = vec![[0; D]; mesh.facets().len()];
    for (facet, piece) in mesh.facets().iter().zip(&mut pieces) {
        for (v, corner) in mesh.facet_points(facet).zip(piece) {
            let number = &mut numbers[v as usize];
            if *number == u32::MAX {
                *number = points.len() as u32;
                points.push(mesh.points()[v as usize]);
            }
            *corner = *number;
        }
    }
    let mark = |(name, members): (&String, &Vec<u32>)| {
        let mut mark = vec![0; pieces.len()];
        members.iter().for_each(|&f| mark[f as usize] = 1);
        (format!("boundary {name}"), mark)
    };
    let marks: Vec<Mark> = mesh.boundaries().iter().map(mark).collect();
    write_vtp(path, 0.0, (&points, &pieces), &[], &marks)
}
