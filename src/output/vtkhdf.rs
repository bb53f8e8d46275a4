//! VTKHDF 2.0: all times of a run in one file, for ParaView and whatever else has VTK 9.3 or newer.
//!
//! The file is made of VTU files as a whole and replaced as a whole: a stop at any moment leaves
//! the old or the new one. HDF5 is written by `hdf5-pure`, which this module alone names. Layout:
//! VTK file formats, <https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format/index.html>.

use super::file::write_file;
use super::vtu::cell_type;
use super::vtu_read::{Snapshot, Values, read_vtu};
use crate::base::{Error, Result};
use hdf5_pure::{AttrValue, FileBuilder, FinishedGroup, GroupBuilder};
use std::path::{Path, PathBuf};

/// Writes the fields of the VTU files `frames`, in the order of their times. A mesh that stays the
/// same is written once. A field that a file lacks is NaN at its time.
///
/// # Errors
/// A file that cannot be read or written.
pub fn write_vtkhdf<const D: usize>(path: &Path, frames: &[PathBuf]) -> Result<()> {
    let mut series = Series::default();
    let mut last: Option<Snapshot<D>> = None;
    for file in frames {
        let snapshot = read_vtu::<D>(file)?;
        let is_new = last.as_ref().is_none_or(|l| !l.space.coincides(&snapshot.space));
        if is_new {
            series.begin_mesh(&snapshot);
        }
        series.add(&snapshot);
        last = Some(snapshot);
    }
    let bytes = series.file().map_err(|e| {
        Error::internal("the file of all times cannot be made")
            .at(path.display().to_string())
            .value(e)
    })?;
    write_file(path, &bytes)
}

/// All times and meshes.
#[derive(Default)]
struct Series {
    /// For every mesh the numbers of its points, cells and corners of cells.
    sizes: Vec<[i64; 3]>,
    points: Vec<f64>,
    corners: Vec<i64>,
    ends: Vec<i64>,
    types: Vec<u8>,
    times: Vec<f64>,
    /// For every time the number of its mesh.
    meshes: Vec<i64>,
    fields: Vec<Column<f64>>,
    regions: Vec<Column<u8>>,
}

/// A field at all times.
struct Column<T> {
    name: String,
    /// 1, or 3 for a vector.
    components: usize,
    values: Vec<T>,
}

impl Series {
    fn begin_mesh<const D: usize>(&mut self, of: &Snapshot<D>) {
        let (space, n) = (&of.space, of.space.local_count());
        let cells = space.mesh().cell_count();
        self.sizes.push([space.len() as i64, cells as i64, (n * cells) as i64]);
        self.points.extend(space.nodes().iter().flat_map(|x| three(x.as_slice())));
        self.corners.extend((0..cells).flat_map(|c| space.cell_nodes(c)).map(|&v| i64::from(v)));
        self.ends.extend((0..=cells).map(|c| (c * n) as i64));
        self.types.extend(vec![cell_type(space.element(), D); cells]);
    }

    fn add<const D: usize>(&mut self, of: &Snapshot<D>) {
        let before = self.meshes.iter().map(|&m| self.sizes[m as usize]);
        let [points, cells] =
            before.fold([0, 0], |[p, c], s| [p + s[0] as usize, c + s[1] as usize]);
        let cells_here = of.space.mesh().cell_count();
        self.times.push(of.time);
        self.meshes.push(self.sizes.len() as i64 - 1);
        for (name, values) in &of.fields {
            let (components, values): (usize, Vec<f64>) = match values {
                Values::Scalar(f) => (1, f.clone()),
                Values::Vector(f) => (3, f.iter().flat_map(|v| three(v.as_slice())).collect()),
            };
            append(&mut self.fields, (name, components), points, f64::NAN, values);
        }
        for (name, members) in of.space.mesh().regions() {
            let mut inside = vec![0; cells_here];
            members.iter().for_each(|&c| inside[c as usize] = 1);
            append(&mut self.regions, (&format!("region {name}"), 1), cells, 0, inside);
        }
        let points = points + of.space.len();
        self.fields.iter_mut().for_each(|f| f.values.resize(points * f.components, f64::NAN));
        self.regions.iter_mut().for_each(|f| f.values.resize(cells + cells_here, 0));
    }

    fn file(&self) -> std::result::Result<Vec<u8>, hdf5_pure::Error> {
        let mut file = FileBuilder::new();
        let mut root = file.create_group("VTKHDF");
        root.set_attr("Version", AttrValue::I64Array(vec![2, 0]));
        root.set_attr("Type", AttrValue::AsciiString("UnstructuredGrid".into()));
        let names = ["NumberOfPoints", "NumberOfCells", "NumberOfConnectivityIds"];
        for (k, name) in names.into_iter().enumerate() {
            integers(&mut root, name, &self.sizes.iter().map(|s| s[k]).collect::<Vec<_>>());
        }
        numbers(&mut root, "Points", 3, &self.points);
        integers(&mut root, "Connectivity", &self.corners);
        integers(&mut root, "Offsets", &self.ends);
        bytes(&mut root, "Types", &self.types);
        let mut data = root.create_group("PointData");
        self.fields.iter().for_each(|f| numbers(&mut data, &f.name, f.components, &f.values));
        root.add_group(data.finish());
        let mut data = root.create_group("CellData");
        self.regions.iter().for_each(|f| bytes(&mut data, &f.name, &f.values));
        root.add_group(data.finish());
        let steps = self.steps(root.create_group("Steps"));
        root.add_group(steps);
        file.add_group(root.finish());
        file.finish()
    }

    /// Where the mesh and the fields of each time begin.
    fn steps(&self, mut steps: GroupBuilder) -> FinishedGroup {
        steps.set_attr("NSteps", AttrValue::I64(self.times.len() as i64));
        numbers(&mut steps, "Values", 1, &self.times);
        integers(&mut steps, "PartOffsets", &self.meshes);
        integers(&mut steps, "NumberOfParts", &vec![1; self.times.len()]);
        let starts = |of: usize, list: &mut dyn Iterator<Item = usize>| -> Vec<i64> {
            let mut sum = 0;
            list.map(|m| {
                sum += self.sizes[m][of];
                sum - self.sizes[m][of]
            })
            .collect()
        };
        for (of, name) in
            ["PointOffsets", "CellOffsets", "ConnectivityIdOffsets"].iter().enumerate()
        {
            let of_mesh = starts(of, &mut (0..self.sizes.len()));
            let of_time: Vec<i64> = self.meshes.iter().map(|&m| of_mesh[m as usize]).collect();
            let set = steps.create_dataset(name).with_i64_data(&of_time);
            // One entry for each kind of cells, of which there is one.
            if *name != "PointOffsets" {
                set.with_shape(&[of_time.len() as u64, 1]);
            }
        }
        for (of, group, names) in [
            (0, "PointDataOffsets", self.fields.iter().map(|f| &f.name).collect::<Vec<_>>()),
            (1, "CellDataOffsets", self.regions.iter().map(|f| &f.name).collect()),
        ] {
            let begin = starts(of, &mut self.meshes.iter().map(|&m| m as usize));
            let mut offsets = steps.create_group(group);
            names.iter().for_each(|name| integers(&mut offsets, name, &begin));
            steps.add_group(offsets.finish());
        }
        steps.finish()
    }
}

/// Appends values to the column of a name, which begins with `missing` at `before` points.
fn append<T: Clone>(
    columns: &mut Vec<Column<T>>,
    (name, components): (&str, usize),
    before: usize,
    missing: T,
    values: Vec<T>,
) {
    let known = columns.iter().position(|c| c.name == name);
    let k = known.unwrap_or_else(|| {
        let values = vec![missing; before * components];
        columns.push(Column { name: name.to_string(), components, values });
        columns.len() - 1
    });
    columns[k].values.extend(values);
}

fn three(x: &[f64]) -> [f64; 3] {
    std::array::from_fn(|k| x.get(k).copied().unwrap_or(0.0))
}

/// Values that are compressed together.
const CHUNK: u64 = 16 * 1024;

fn numbers(group: &mut GroupBuilder, name: &str, components: usize, values: &[f64]) {
    let rows = (values.len() / components) as u64;
    let set = group.create_dataset(name).with_f64_data(values);
    match (components, rows) {
        (1, 0) => set,
        (1, _) => set.with_chunks(&[rows.min(CHUNK)]).with_deflate(1),
        (n, 0) => set.with_shape(&[0, n as u64]),
        (n, _) => set
            .with_shape(&[rows, n as u64])
            .with_chunks(&[rows.min(CHUNK), n as u64])
            .with_deflate(1),
    };
}

fn integers(group: &mut GroupBuilder, name: &str, values: &[i64]) {
    let set = group.create_dataset(name).with_i64_data(values);
    if values.len() > 1 {
        set.with_chunks(&[(values.len() as u64).min(CHUNK)]).with_deflate(1);
    }
}

fn bytes(group: &mut GroupBuilder, name: &str, values: &[u8]) {
    let set = group.create_dataset(name).with_u8_data(values);
    if values.len() > 1 {
        set.with_chunks(&[(values.len() as u64).min(CHUNK)]).with_deflate(1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::{Element, Space};
    use crate::mesh::{Diagonals, rectangle};
    use crate::output::{FieldData, write_vtu};
    use std::sync::Arc;

    #[test]
    fn times_meshes_and_fields_are_where_the_steps_say() {
        let dir = tempfile::tempdir().unwrap();
        let space = |n: usize| {
            let mut mesh = rectangle([0.0; 2], [1.0; 2], [n, n], Diagonals::Right).unwrap();
            mesh.set_region("left", vec![0, 1]);
            Space::new(&Arc::new(mesh), Element::P2)
        };
        // Two times on a mesh, one on another, and a field that comes later.
        let [coarse, fine] = [space(2), space(3)];
        let mut frames = Vec::new();
        for (k, s) in [&coarse, &coarse, &fine].into_iter().enumerate() {
            let f = s.interpolate(|x| x[0] + k as f64);
            let u = s.interpolate(|x| x * (k as f64));
            let mut fields = vec![("u", FieldData::Vector(&u))];
            if k > 0 {
                fields.push(("p", FieldData::Scalar(&f)));
            }
            frames.push(dir.path().join(format!("{k}.vtu")));
            write_vtu(&frames[k], s, 0.5 * k as f64, &fields).unwrap();
        }
        let path = dir.path().join("all.vtkhdf");
        write_vtkhdf::<2>(&path, &frames).unwrap();
        let file = hdf5_pure::File::open(&path).unwrap();
        let list = |name: &str| file.dataset(&format!("VTKHDF/{name}")).unwrap();
        let [n, m] = [coarse.len() as i64, fine.len() as i64];
        assert_eq!(list("NumberOfPoints").read_i64().unwrap(), [n, m]);
        assert_eq!(list("NumberOfCells").read_i64().unwrap(), [8, 18]);
        assert_eq!(list("Points").shape().unwrap(), [(n + m) as u64, 3]);
        assert_eq!(list("Steps/Values").read_f64().unwrap(), [0.0, 0.5, 1.0]);
        assert_eq!(list("Steps/PartOffsets").read_i64().unwrap(), [0, 0, 1]);
        assert_eq!(list("Steps/PointOffsets").read_i64().unwrap(), [0, 0, n]);
        assert_eq!(list("Steps/PointDataOffsets/p").read_i64().unwrap(), [0, n, 2 * n]);
        assert_eq!(list("Steps/CellDataOffsets/region left").read_i64().unwrap(), [0, 8, 16]);
        let (p, u) = (list("PointData/p").read_f64().unwrap(), list("PointData/u"));
        assert_eq!(p.len(), (2 * n + m) as usize);
        assert!(p[..n as usize].iter().all(|v| v.is_nan()), "absent at the first time");
        for (k, x) in fine.nodes().iter().enumerate() {
            let at = 2 * n as usize + k;
            assert_eq!(p[at], x[0] + 2.0);
            assert_eq!(u.read_f64().unwrap()[3 * at..][..3], [2.0 * x[0], 2.0 * x[1], 0.0]);
        }
    }
}
