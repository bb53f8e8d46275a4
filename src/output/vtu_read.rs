//! Reading the VTU files of [`write_vtu`](super::write_vtu) back, for pictures of a finished run.

use super::appended::BLOCK;
use super::file;
use super::markup::attribute;
use super::vtu::{HEAD, TAIL, cell_type};
use crate::base::{Error, Result};
use crate::fem::{Element, Space};
use crate::mesh::{Mesh, Point};
use flate2::read::ZlibDecoder;
use nalgebra::SVector;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

/// The values of a field, one a node.
#[derive(Clone, Debug, PartialEq)]
pub enum Values<const D: usize> {
    /// A number a node.
    Scalar(Vec<f64>),
    /// A vector a node.
    Vector(Vec<SVector<f64, D>>),
}

/// Content of a VTU file.
#[derive(Clone, Debug)]
pub struct Snapshot<const D: usize> {
    /// The time.
    pub time: f64,
    /// The space the fields live on, with the nodes numbered as they were; its mesh knows its
    /// regions but no boundary names.
    pub space: Space<D>,
    /// Names and values, in the order of the file.
    pub fields: Vec<(String, Values<D>)>,
}

impl<const D: usize> Snapshot<D> {
    /// The scalar field of this name.
    ///
    /// # Errors
    /// There is none; the fields that exist are listed.
    pub fn scalar(&self, name: &str) -> Result<&[f64]> {
        let found = self.fields.iter().find_map(|(n, v)| match v {
            Values::Scalar(f) if n == name => Some(f.as_slice()),
            _ => None,
        });
        found.ok_or_else(|| self.missing("scalar", name))
    }
    /// The vector field of this name.
    ///
    /// # Errors
    /// There is none; the fields that exist are listed.
    pub fn vector(&self, name: &str) -> Result<&[SVector<f64, D>]> {
        let found = self.fields.iter().find_map(|(n, v)| match v {
            Values::Vector(f) if n == name => Some(f.as_slice()),
            _ => None,
        });
        found.ok_or_else(|| self.missing("vector", name))
    }
    fn missing(&self, kind: &str, name: &str) -> Error {
        let label = |(n, v): &(String, Values<D>)| match v {
            Values::Scalar(_) => format!("{n} (scalar)"),
            Values::Vector(_) => format!("{n} (vector)"),
        };
        let known: Vec<_> = self.fields.iter().map(label).collect();
        Error::input(format!("the file has no {kind} field of this name"))
            .value(name)
            .remedy(format!("fields in this file: {}", known.join(", ")))
    }
}

/// Reads a file that [`write_vtu`](super::write_vtu) wrote.
///
/// # Errors
/// The file cannot be read, is cut off or damaged, was written by another program, or is of another
/// dimension.
pub fn read_vtu<const D: usize>(path: &Path) -> Result<Snapshot<D>> {
    let bytes = file::read(path)?;
    parse(&bytes)
        .map_err(|e| if e.place().is_empty() { e.at(path.display().to_string()) } else { e })
}

fn parse<const D: usize>(bytes: &[u8]) -> Result<Snapshot<D>> {
    let file = Parts::split(bytes)?;
    let [points, cells] = file.sizes()?;
    let time = file.floats("FieldData", "TimeValue", 1)?[0];
    let types = file.array("Cells", "types", cells)?;
    let element = [Element::P1, Element::P2]
        .into_iter()
        .find(|&e| types.iter().all(|&t| t == cell_type(e, D)));
    let element = element.ok_or_else(|| {
        Error::input(format!("the cells are not triangles or tetrahedra of dimension {D}"))
            .value(format!("VTK cell type {}", types.first().copied().unwrap_or_default()))
    })?;
    let nodes = vectors::<D>(&file.floats("Points", "Points", 3 * points)?);
    let n = element.local_count(D);
    let connectivity = file.array("Cells", "connectivity", 8 * n * cells)?;
    let index = |b: &[u8]| {
        u32::try_from(u64::from_le_bytes(eight(b))).ok().filter(|&i| (i as usize) < points)
    };
    let connectivity: Option<Vec<u32>> = connectivity.chunks_exact(8).map(index).collect();
    let connectivity =
        connectivity.ok_or_else(|| damaged("a cell uses a point that does not exist"))?;
    let space = rebuild(element, &nodes, &connectivity, &file.regions(cells)?)?;
    Ok(Snapshot { time, space, fields: file.fields(points)? })
}

/// The space, built from its vertices as the writer's was, with the same numbers for the same
/// nodes.
fn rebuild<const D: usize>(
    element: Element,
    nodes: &[Point<D>],
    connectivity: &[u32],
    regions: &[(String, Vec<u32>)],
) -> Result<Space<D>> {
    let n = element.local_count(D);
    // Midpoints are numbered after all points of the mesh.
    let points = connectivity
        .chunks_exact(n)
        .flat_map(|c| &c[D + 1..])
        .min()
        .map_or(nodes.len(), |&m| m as usize);
    let vertices = connectivity.chunks_exact(n).flat_map(|c| c[..=D].iter().copied()).collect();
    let mut mesh = Mesh::new(nodes[..points].to_vec(), vertices)?;
    regions.iter().for_each(|(name, cells)| mesh.set_region(name.clone(), cells.clone()));
    let space = Space::new(&Arc::new(mesh), element);
    let same = space.nodes() == nodes
        && (0..connectivity.len() / n)
            .all(|c| space.cell_nodes(c) == &connectivity[c * n..(c + 1) * n]);
    if same { Ok(space) } else { Err(foreign("its nodes are numbered in another way")) }
}

/// The text and the binary part of a file.
struct Parts<'a> {
    head: &'a str,
    data: &'a [u8],
}

impl<'a> Parts<'a> {
    fn split(bytes: &'a [u8]) -> Result<Parts<'a>> {
        let rest =
            bytes.strip_prefix(HEAD.as_bytes()).ok_or_else(|| foreign("its first lines differ"))?;
        let at = rest
            .windows(TAIL.len())
            .position(|w| w == TAIL.as_bytes())
            .ok_or_else(|| damaged("it has no data"))?;
        let head = std::str::from_utf8(&rest[..at]).map_err(|_| damaged("its head is not text"))?;
        Ok(Parts { head, data: &rest[at + TAIL.len()..] })
    }
    /// Numbers of points and cells.
    fn sizes(&self) -> Result<[usize; 2]> {
        let tag = self.head.split("<Piece").nth(1).unwrap_or_default();
        // Node numbers have 32 bits, which also keeps all sizes below far from overflow.
        let size =
            |name| attribute(tag, name).and_then(|v| v.parse::<u32>().ok()).map(|v| v as usize);
        size("NumberOfPoints")
            .zip(size("NumberOfCells"))
            .map(|(p, c)| [p, c])
            .filter(|[p, c]| *p > 0 && *c > 0)
            .ok_or_else(|| damaged("it does not say how many points and cells it has"))
    }
    /// The tags of the arrays in a section.
    fn tags(&self, section: &str) -> impl Iterator<Item = &'a str> {
        let inside = self.head.split(&format!("<{section}>")).nth(1).unwrap_or_default();
        let inside = inside.split(&format!("</{section}>")).next().unwrap_or_default();
        inside.split("<DataArray").skip(1)
    }
    /// The bytes of the named array.
    fn array(&self, section: &str, name: &str, length: usize) -> Result<Vec<u8>> {
        let tag = self.tags(section).find(|t| attribute(t, "Name").as_deref() == Some(name));
        self.content(tag.ok_or_else(|| damaged(&format!("it has no array {name}")))?, length)
    }
    fn floats(&self, section: &str, name: &str, count: usize) -> Result<Vec<f64>> {
        self.array(section, name, 8 * count).map(|b| floats(&b))
    }
    /// The bytes an array tag points to, uncompressed.
    fn content(&self, tag: &str, length: usize) -> Result<Vec<u8>> {
        let cut = || damaged("it is cut off or its data are corrupt");
        let offset =
            attribute(tag, "offset").and_then(|o| o.parse::<usize>().ok()).ok_or_else(cut)?;
        let data = self.data.get(offset..).ok_or_else(cut)?;
        let blocks = length.div_ceil(BLOCK);
        let table = data.get(..8 * (3 + blocks)).ok_or_else(cut)?;
        let table: Vec<usize> =
            table.chunks_exact(8).map(|b| u64::from_le_bytes(eight(b)) as usize).collect();
        if table[..3] != [blocks, BLOCK, length % BLOCK] {
            return Err(cut());
        }
        let mut rest = &data[8 * (3 + blocks)..];
        let mut out = Vec::new();
        for &size in &table[3..] {
            let block = rest.get(..size).ok_or_else(cut)?;
            rest = &rest[size..];
            // One byte more than expected is enough to notice a block that is too long.
            ZlibDecoder::new(block)
                .take(BLOCK as u64 + 1)
                .read_to_end(&mut out)
                .map_err(|_| cut())?;
        }
        if out.len() == length { Ok(out) } else { Err(cut()) }
    }
    fn fields<const D: usize>(&self, points: usize) -> Result<Vec<(String, Values<D>)>> {
        let field = |tag: &str| {
            let name = attribute(tag, "Name").unwrap_or_default();
            let values = match attribute(tag, "NumberOfComponents") {
                None => Values::Scalar(floats(&self.content(tag, 8 * points)?)),
                Some(_) => Values::Vector(vectors(&floats(&self.content(tag, 24 * points)?))),
            };
            Ok((name, values))
        };
        self.tags("PointData").map(field).collect()
    }
    /// Names of regions and their cells.
    fn regions(&self, cells: usize) -> Result<Vec<(String, Vec<u32>)>> {
        let mut regions = Vec::new();
        for tag in self.tags("CellData") {
            if let Some(name) =
                attribute(tag, "Name").as_deref().and_then(|n| n.strip_prefix("region "))
            {
                let inside = self.content(tag, cells)?;
                regions.push((
                    name.to_string(),
                    (0..cells as u32).filter(|&c| inside[c as usize] == 1).collect(),
                ));
            }
        }
        Ok(regions)
    }
}

fn eight(b: &[u8]) -> [u8; 8] {
    let mut a = [0; 8];
    a.copy_from_slice(b);
    a
}

fn floats(bytes: &[u8]) -> Vec<f64> {
    bytes.chunks_exact(8).map(|b| f64::from_le_bytes(eight(b))).collect()
}

/// The first `D` of every three components.
fn vectors<const D: usize>(values: &[f64]) -> Vec<SVector<f64, D>> {
    values.chunks_exact(3).map(|v| SVector::from_fn(|k, _| v[k])).collect()
}

fn foreign(why: &str) -> Error {
    Error::input(format!("this VTU file was not written by immersa: {why}"))
        .remedy("give a file of a run folder; ParaView and meshio read the others")
}

fn damaged(why: &str) -> Error {
    Error::input(format!("this VTU file is damaged: {why}"))
        .remedy("run the scene again, with --resume from its last checkpoint")
}

#[cfg(test)]
mod tests;
