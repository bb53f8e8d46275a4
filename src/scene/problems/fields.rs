//! Field files of all problems.

use super::interfaces;
use crate::base::Result;
use crate::flow::nodal_pressure;
use crate::output::{FieldData, write_vtu};
use crate::scene::geometry;
use crate::scene::schema::Stored;
use crate::scene::view::View;
use crate::sim::Carried;
use crate::structure::{Density, Structure};
use nalgebra::SVector;
use std::path::Path;

/// A field computed for a file.
enum Made<const D: usize> {
    Scalar(Vec<f64>),
    Vector(Vec<SVector<f64, D>>),
}

impl<const D: usize> Made<D> {
    fn as_field(&self) -> FieldData<'_, D> {
        match self {
            Made::Scalar(values) => FieldData::Scalar(values),
            Made::Vector(values) => FieldData::Vector(values),
        }
    }
}

/// Writes velocity (or, for a segmentation, the image), pressure, the nodal fields of structures
/// that are [written](crate::structure::Rule::written), strains and curvatures to a VTU file, and
/// what else the scene wants to have stored; the interfaces to a VTP file beside it. A pressure
/// that is not known yet is NaN.
///
/// # Errors
/// A level set that is not finite; a file that cannot be written.
pub(super) fn write<const D: usize>(
    path: &Path,
    view: &View<'_, D>,
    image: Option<&[f64]>,
    materials: [Option<Vec<f64>>; 2],
) -> Result<()> {
    let (state, carried) = (view.state, view.carried);
    let stored = |what| view.tables.output.store.contains(&what);
    let pressure = view.flow.map(|flow| match state.has_pressure() {
        true => nodal_pressure(flow.pressure().space(), &state.flow.p),
        false => vec![f64::NAN; view.space().mesh().points().len()],
    });
    let rotates = image.is_none() && stored(Stored::Vorticity);
    let vorticity = rotates.then(|| view.space().vorticity(&state.flow.u));
    let mut fields = vec![match image {
        Some(image) => ("image", FieldData::Scalar(image)),
        None => ("velocity", FieldData::Vector(&state.flow.u)),
    }];
    fields.extend(pressure.iter().map(|p| ("pressure", FieldData::Scalar(p))));
    fields.extend(vorticity.iter().map(|w| ("vorticity", FieldData::Scalar(w))));
    let materials = ["density", "viscosity"].into_iter().zip(&materials);
    let materials = materials.filter(|_| stored(Stored::Materials));
    fields.extend(materials.filter_map(|(n, m)| Some((n, FieldData::Scalar(m.as_ref()?)))));
    let scalars: Vec<_> = carried.written_scalars(&state.fields).collect();
    fields.extend(scalars.iter().map(|(name, values)| (*name, FieldData::Scalar(values))));
    let (stretched, strained, curved) = (stretched(view), strained(view), curved(view));
    fields.extend(stretched.iter().map(|(name, made)| (&**name, made.as_field())));
    fields.extend(strained.iter().map(|(name, made)| (&**name, made.as_field())));
    let vectors = carried.written_vectors(&state.fields);
    fields.extend(vectors.map(|(name, values)| (name, FieldData::Vector(values))));
    fields.extend(curved.iter().map(|(name, made)| (&**name, made.as_field())));
    if stored(Stored::Interfaces) && carried.structures().iter().any(|s| s.level_set().is_some()) {
        interfaces::write(&path.with_extension("vtp"), view)?;
    }
    write_vtu(path, view.space(), state.time, &fields)
}

/// Stretches and concentrations that interfaces carry; they count near the interface.
fn stretched<const D: usize>(view: &View<'_, D>) -> Vec<(String, Made<D>)> {
    let structures = view.carried.structures().iter().map(|s| &**s);
    let of = |s: &dyn Structure<D>| {
        let (density, of) = s.surface_density()?;
        let density = view.state.fields.scalar(density);
        let (what, values) = match of {
            Density::Rest => ("stretch", density.iter().map(|m| 1.0 / m).collect()),
            Density::Concentration => ("concentration", density.to_vec()),
        };
        Some((format!("{}.{what}", s.name()), Made::Scalar(values)))
    };
    structures.filter(|s| !s.carries_strain()).filter_map(of).collect()
}

/// Curvatures of the level sets, if they are to be written.
fn curved<const D: usize>(view: &View<'_, D>) -> Vec<(String, Made<D>)> {
    let structures = view.carried.structures().iter().map(|s| &**s).enumerate();
    let wanted =
        structures.filter(|(_, s)| view.tables.output.curvature && s.level_set().is_some());
    let of = |(k, s): (usize, &dyn Structure<D>)| {
        let name = s.name().to_string();
        let made = geometry::fields(view, k).into_iter();
        made.map(move |(end, values)| (format!("{name}.{end}"), Made::Scalar(values)))
    };
    wanted.flat_map(of).collect()
}

/// Fields derived from the backward characteristics: the displacement `Y(x) - x` to the position at
/// rest for each structure that resists shear, and in space area change and shear near each
/// interface.
fn strained<const D: usize>(view: &View<'_, D>) -> Vec<(String, Made<D>)> {
    let (mut made, carried, fields) = (Vec::new(), view.carried, &view.state.fields);
    let known = |s: &dyn Structure<D>| view.has_backward_map() || s.carries_strain();
    for (k, s) in carried.structures().iter().enumerate().filter(|(_, s)| known(&***s)) {
        let name = s.name();
        if s.resists_shear() {
            let rest = carried.rest_displacement(fields, k).into_owned();
            made.push((format!("{name}.displacement"), Made::Vector(rest)));
        }
        if D == 3 && s.level_set().is_some() {
            let band = view.thickness.filter(|_| s.acts() && !s.carries_strain());
            let reach = band.unwrap_or_else(|| thinnest(carried));
            let [area, shear] = carried.nodal_strain(fields, k, reach);
            made.push((format!("{name}.area_change"), Made::Scalar(area)));
            made.push((format!("{name}.shear"), Made::Scalar(shear)));
        }
    }
    made
}

/// Two edges of the finest cell: reach of the strain near a passive interface.
fn thinnest<const D: usize>(carried: &Carried<D>) -> f64 {
    let mesh = carried.mesh();
    2.0 * (0..mesh.cell_count()).map(|c| mesh.diameter(c)).fold(f64::INFINITY, f64::min)
}

/// Number of unknowns of all level sets.
pub(super) fn level_set_unknowns<const D: usize>(view: &View<'_, D>) -> usize {
    view.space().len()
        * view.carried.structures().iter().filter(|s| s.level_set().is_some()).count()
}
