//! Meshes from gmsh: MSH files of version 2 and 4.1 in ASCII and binary, and of version 4.0 in
//! ASCII; and the `.msh` files of FreeFEM, which are another format.
//!
//! Triangles and tetrahedra of order 1 (of order 2 the vertices are used). Physical groups become
//! regions (of the dimension of the mesh) and boundaries (one less). Other sections, `$Periodic`
//! among them, are skipped. Source: the gmsh reference manual, "MSH file format", and files written
//! by gmsh 4.8.

mod build;
mod cursor;
mod elements;
mod freefem;
mod version2;
mod version4;

use super::Mesh;
use crate::base::{Error, Result, Warning};
use cursor::Cursor;
use std::collections::{BTreeMap, HashMap};
use std::path::Path;

/// Content of a file: points, simplices of all dimensions, and physical groups. [`MshData::mesh`]
/// converts it to a mesh.
#[derive(Clone, Debug, Default)]
pub struct MshData {
    file: String,
    points: Vec<[f64; 3]>,
    /// Tag of every point in the file.
    tags: Vec<u64>,
    /// Index of the point with a tag; tags may have gaps.
    index: HashMap<u64, u32>,
    /// Vertices by dimension of the simplex; those not used are `NONE`.
    simplices: [Vec<[u32; 4]>; 4],
    /// Simplices of a physical group, by its dimension and number.
    groups: BTreeMap<(usize, i64), Vec<u32>>,
    names: BTreeMap<(usize, i64), String>,
    /// Points inside edges of elements of order 2, by index.
    midpoints: Vec<u32>,
}

/// Reads the mesh of a file, with warnings about ignored content.
///
/// # Errors
/// See [`MshData::read`] and [`MshData::mesh`].
pub fn read<const D: usize>(path: &Path) -> Result<(Mesh<D>, Vec<Warning>)> {
    MshData::read(path)?.mesh()
}

/// Dimension of the mesh of a file: 3 if it has tetrahedra, else 2.
///
/// # Errors
/// See [`MshData::read`] and [`MshData::dimension`].
pub fn dimension(path: &Path) -> Result<usize> {
    MshData::read(path)?.dimension()
}

impl MshData {
    /// Reads a file.
    ///
    /// # Errors
    /// A file that cannot be opened, is no MSH file, is damaged, or holds elements that are no
    /// simplices of order 1 or 2. Each names the line (ASCII) or byte (binary), the value found,
    /// and a remedy.
    pub fn read(path: &Path) -> Result<MshData> {
        let name = path.display().to_string();
        let bytes = crate::base::read_plain(path).map_err(|e| {
            Error::input("the mesh file cannot be read")
                .at(&name)
                .value(e)
                .remedy("check the path and the permissions")
        })?;
        MshData::parse(&bytes, &name)
    }

    /// Reads the bytes of a file; `name` is the name of the file in messages.
    ///
    /// # Errors
    /// As [`MshData::read`].
    pub fn parse(bytes: &[u8], name: &str) -> Result<MshData> {
        let mut data = MshData { file: name.to_owned(), ..MshData::default() };
        // Editors may put a byte order mark in front.
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        if freefem::is_mesh(bytes) {
            data.read_freefem(bytes)?;
            return Ok(data);
        }
        let mut cursor = Cursor::new(name, bytes);
        let version = header(&mut cursor)?;
        let mut entities = version4::Entities::new();
        loop {
            cursor.skip_space();
            if cursor.is_at_end() {
                break;
            }
            let at = cursor.at;
            let line = cursor.line();
            let Some(section) = line.strip_prefix('$') else {
                return Err(
                    cursor.unexpected(at, "the start of a section ($Nodes, $Elements, ...)")
                );
            };
            let is_2 = version == Version::Two;
            match section {
                "PhysicalNames" => data.read_names(&mut cursor)?,
                "Nodes" | "ParametricNodes" if is_2 => {
                    data.read_nodes_2(&mut cursor, section == "ParametricNodes")?
                }
                "Elements" if is_2 => data.read_elements_2(&mut cursor)?,
                "Entities" | "PartitionedEntities" if !is_2 => {
                    version4::read_entities(
                        &mut cursor,
                        &mut entities,
                        version,
                        section == "PartitionedEntities",
                    )?;
                }
                "Nodes" => data.read_nodes_4(&mut cursor, version)?,
                "Elements" => data.read_elements_4(&mut cursor, version, &entities)?,
                _ => {
                    cursor.skip_section(section)?;
                    continue;
                }
            }
            cursor.end_section(section)?;
        }
        data.check_sections()?;
        Ok(data)
    }

    /// Dimension of the mesh: 3 if there are tetrahedra, else 2.
    ///
    /// # Errors
    /// Neither tetrahedra nor triangles.
    pub fn dimension(&self) -> Result<usize> {
        (2..=3).rev().find(|&d| !self.simplices[d].is_empty()).ok_or_else(|| {
            Error::input("the mesh has neither triangles nor tetrahedra")
                .at(&self.file)
                .value(format!("{} points, {} lines", self.points.len(), self.simplices[1].len()))
                .remedy(
                    "mesh the surface or the volume (gmsh -2 or -3) and give it a physical group, \
                     or save all (gmsh -save_all)",
                )
        })
    }

    fn check_sections(&self) -> Result<()> {
        let missing = if self.points.is_empty() {
            "$Nodes"
        } else if self.simplices.iter().all(Vec::is_empty) {
            "$Elements"
        } else {
            return Ok(());
        };
        Err(Error::input(format!("the file has no section {missing}, or it is empty"))
            .at(&self.file)
            .value(format!("{} points", self.points.len()))
            .remedy(
                "mesh the geometry before saving (gmsh -2 or -3), and save the physical groups or \
                 all (-save_all)",
            ))
    }

    /// `$PhysicalNames`: always text. The name lies between the first and the last quotation mark.
    fn read_names(&mut self, cursor: &mut Cursor) -> Result<()> {
        let count = cursor.count_line("the number of physical names", 3, 6)?;
        for _ in 0..count {
            cursor.skip_space();
            let at = cursor.at;
            let line = cursor.line();
            let what = "a physical name: its dimension, number and name in quotation marks";
            let (numbers, quoted) =
                line.split_once('"').ok_or_else(|| cursor.unexpected(at, what))?;
            let name = quoted.rsplit_once('"').ok_or_else(|| cursor.unexpected(at, what))?.0;
            let mut numbers = numbers.split_whitespace();
            let dimension = numbers.next().and_then(|w| w.parse().ok()).filter(|d| *d <= 3);
            let number = numbers.next().and_then(|w| w.parse::<i64>().ok());
            let key = dimension.zip(number).ok_or_else(|| cursor.unexpected(at, what))?;
            self.names.insert(key, name.to_owned());
        }
        Ok(())
    }

    fn add_point(&mut self, cursor: &Cursor, at: usize, tag: u64, x: [f64; 3]) -> Result<()> {
        if self.index.insert(tag, self.points.len() as u32).is_some() {
            return Err(cursor
                .error(at, "two points have the same number")
                .value(tag)
                .remedy("number the points uniquely, or write the file again with gmsh"));
        }
        self.points.push(x);
        self.tags.push(tag);
        Ok(())
    }

    /// The vertices of a simplex: the first of its nodes; the others are recorded as midpoints.
    fn vertices(
        &mut self,
        cursor: &Cursor,
        at: usize,
        nodes: &[u64],
        dimension: usize,
    ) -> Result<[u32; 4]> {
        let mut vertices = [super::NONE; 4];
        for (k, tag) in nodes.iter().enumerate() {
            let &point = self.index.get(tag).ok_or_else(|| {
                let all = format!("{} points", self.points.len());
                cursor
                    .error(at, "an element uses a point that does not exist")
                    .value(format!("point {tag}, in a file with {all}"))
                    .remedy("put $Nodes before $Elements, or write the file again with gmsh")
            })?;
            match vertices[..=dimension].get_mut(k) {
                Some(vertex) => *vertex = point,
                None => self.midpoints.push(point),
            }
        }
        Ok(vertices)
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Version {
    Two,
    Four,
    FourOne,
}

/// `$MeshFormat`: version, 0 (ASCII) or 1 (binary), size of a number; if binary, the integer 1 as
/// bytes.
fn header(cursor: &mut Cursor) -> Result<Version> {
    find_format(cursor)?;
    let at = cursor.at;
    let line = cursor.line();
    let words: Vec<&str> = line.split_whitespace().collect();
    let [version, kind, size] = words[..] else {
        return Err(
            cursor.unexpected(at, "the version, the kind (0 or 1) and the size of a number")
        );
    };
    let version = known_format(cursor, at, [version, kind, size])?;
    if kind == "1" {
        cursor.binary = true;
        check_byte_order(cursor)?;
    }
    cursor.end_section("MeshFormat")?;
    Ok(version)
}

/// Moves behind `$MeshFormat`, over comments.
fn find_format(cursor: &mut Cursor) -> Result<()> {
    let any_mesh = "save the mesh as MSH (gmsh FILE -save -format msh41 -o FILE.msh); gmsh also \
        converts other mesh formats";
    loop {
        let at = cursor.start();
        if cursor.is_at_end() {
            return Err(cursor
                .error(at, "the file is empty: expected $MeshFormat")
                .value("0 bytes of mesh")
                .remedy(any_mesh));
        }
        match cursor.line().as_str() {
            "$MeshFormat" => return Ok(()),
            "$Comments" => cursor.skip_section("Comments")?,
            "$NOD" => {
                return Err(cursor
                    .error(at, "this is an MSH file of version 1, which is not read")
                    .value("$NOD")
                    .remedy("convert it: gmsh FILE -save -format msh41 -o NEW.msh"));
            }
            _ => {
                return Err(cursor
                    .unexpected(at, "$MeshFormat: this is no MSH file of gmsh")
                    .remedy(any_mesh));
            }
        }
    }
}

/// The version by its words: version, kind and size of numbers.
fn known_format(cursor: &Cursor, at: usize, [version, kind, size]: [&str; 3]) -> Result<Version> {
    let refuse = |what: &str, value: &str, remedy: &str| {
        Err(cursor.error(at, what).value(value).remedy(remedy))
    };
    let parsed = match version {
        "2" | "2.0" | "2.1" | "2.2" => Version::Two,
        "4" | "4.0" => Version::Four,
        "4.1" => Version::FourOne,
        _ => {
            return refuse(
                "this version of the MSH format cannot be read",
                version,
                "save as 4.1: gmsh -format msh41",
            );
        }
    };
    if kind != "0" && kind != "1" {
        return refuse("the file is neither ASCII (0) nor binary (1)", kind, cursor::WRITE_AGAIN);
    }
    if kind == "1" && parsed == Version::Four {
        return refuse(
            "binary files of version 4.0 cannot be read",
            version,
            "save as 4.1: gmsh -bin -format msh41",
        );
    }
    if kind == "1" && size != "8" {
        return refuse(
            "numbers of this size cannot be read",
            size,
            "write the file on a 64-bit machine, or without -bin",
        );
    }
    Ok(parsed)
}

/// Refuses a binary file with another order of bytes.
fn check_byte_order(cursor: &mut Cursor) -> Result<()> {
    let at = cursor.at;
    let one = cursor.int("the number 1, which tells the order of bytes")?;
    if one != 1 {
        let what = if one == 1 << 24 {
            "the file is big-endian"
        } else {
            "the mark for the order of bytes is wrong"
        };
        return Err(cursor
            .error(at, what)
            .value(one)
            .remedy("write it in ASCII (gmsh without -bin)"));
    }
    Ok(())
}
