//! Conversion of the content of a file to a mesh.

use super::MshData;
use crate::base::{Error, Result, Warning};
use crate::mesh::{Mesh, NONE, Point, facet_key};
use std::collections::{BTreeMap, HashMap};

/// Largest deviation of a surface from its plane, relative to its size.
const FLAT: f64 = 1e-10;

impl MshData {
    /// The mesh, with warnings about ignored content.
    ///
    /// Points of no cell are dropped; the others and the cells keep their order. Groups without a
    /// name are named by their number; groups of the same name are merged.
    ///
    /// # Errors
    /// A dimension other than `D`, a two-dimensional mesh that is not in a plane `z = const`, or a
    /// mesh that [`Mesh::new`] refuses.
    pub fn mesh<const D: usize>(&self) -> Result<(Mesh<D>, Vec<Warning>)> {
        let dimension = self.dimension()?;
        if dimension != D {
            return Err(Error::input(format!(
                "the mesh has dimension {dimension}, where {D} is needed"
            ))
            .at(&self.file)
            .value(format!(
                "{} triangles, {} tetrahedra",
                self.simplices[2].len(),
                self.simplices[3].len()
            ))
            .remedy(format!("use a mesh of dimension {D}")));
        }
        (D - 1..=D).try_for_each(|d| self.check_names(d))?;
        let (new, kept) = self.vertices_in_use(D);
        if D == 2 {
            self.check_plane(&kept)?;
        }
        let points =
            kept.iter().map(|&p| Point::<D>::from_fn(|i, _| self.points[p as usize][i])).collect();
        let cells =
            self.simplices[D].iter().flat_map(|v| &v[..=D]).map(|&v| new[v as usize]).collect();
        let mut mesh = Mesh::new(points, cells).map_err(|e| {
            let place = format!("{}, {}", self.file, e.place());
            e.at(place)
        })?;
        let mut warnings = self.leftovers(&new);
        self.name_regions(&mut mesh);
        warnings.extend(self.name_boundaries(&mut mesh, &new));
        warnings.extend(self.unused_groups(D));
        Ok((mesh, warnings))
    }

    /// Number in the mesh of every point (`NONE`: dropped), and the kept points.
    fn vertices_in_use(&self, dimension: usize) -> (Vec<u32>, Vec<u32>) {
        let mut new = vec![NONE; self.points.len()];
        for &v in self.simplices[dimension].iter().flat_map(|v| &v[..=dimension]) {
            new[v as usize] = 0;
        }
        let mut kept = Vec::new();
        for (p, number) in new.iter_mut().enumerate().filter(|(_, number)| **number != NONE) {
            *number = kept.len() as u32;
            kept.push(p as u32);
        }
        (new, kept)
    }

    fn check_plane(&self, kept: &[u32]) -> Result<()> {
        let point = |p: u32| &self.points[p as usize];
        let Some(&first) = kept.first() else { return Ok(()) };
        let distance = |p: u32, i: usize| (point(p)[i] - point(first)[i]).abs();
        let size = kept.iter().map(|&p| distance(p, 0).max(distance(p, 1))).fold(0.0, f64::max);
        let Some(&off) = kept.iter().find(|&&p| distance(p, 2) > FLAT * size) else {
            return Ok(());
        };
        let (tag, x) = (self.tags[off as usize], point(off));
        Err(Error::input("the mesh is a surface in space: triangles must lie in a plane z = const")
            .at(format!("{}, point {tag} at {x:?}", self.file))
            .value(format!("z = {} and {}", point(first)[2], x[2]))
            .remedy(
                "draw the geometry in the x-y plane; or, for a 3-D mesh, mesh the volume (gmsh \
                 -3) and give it a physical group",
            ))
    }

    /// Warnings about unused points and parts of elements.
    fn leftovers(&self, new: &[u32]) -> Vec<Warning> {
        let mut warnings = Vec::new();
        if !self.midpoints.is_empty() {
            warnings.push(Warning::new(
                format!(
                    "{}: the mesh is of order 2; only the vertices are used, curved sides become \
                     straight",
                    self.file
                ),
                "mesh with order 1 (gmsh -order 1) and a finer size at curved boundaries",
            ));
        }
        let mut unused: Vec<bool> = new.iter().map(|&n| n == NONE).collect();
        for &p in &self.midpoints {
            unused[p as usize] = false;
        }
        if let Some(p) = unused.iter().position(|&u| u) {
            let count = unused.iter().filter(|&&u| u).count();
            let (tag, x) = (self.tags[p], self.points[p]);
            warnings.push(Warning::new(
                format!(
                    "{}: {count} points belong to no cell and are left out, the first is point \
                     {tag} at {x:?}",
                    self.file
                ),
                "no harm is done; without -save_all gmsh does not write them",
            ));
        }
        warnings
    }

    /// Rejects a name that is the number of another group, which has no name.
    fn check_names(&self, dimension: usize) -> Result<()> {
        let own = |number: i64| self.names.get(&(dimension, number)).filter(|n| !n.is_empty());
        let groups = || self.groups.range((dimension, i64::MIN)..=(dimension, i64::MAX));
        let clash = groups().find_map(|((_, named), _)| {
            let number: i64 = own(*named)?.parse().ok()?;
            let other = groups().any(|((_, n), _)| *n == number) && number != *named;
            (other && own(number).is_none()).then_some((*named, number))
        });
        let Some((named, number)) = clash else { return Ok(()) };
        Err(Error::input("the name of a physical group is the number of another one")
            .at(&self.file)
            .value(format!("group {named} has the name \"{number}\", group {number} has none"))
            .remedy("give both names of their own"))
    }

    /// The name of a group, or its number.
    fn name(&self, dimension: usize, number: i64) -> String {
        let name = self.names.get(&(dimension, number)).filter(|name| !name.is_empty());
        name.cloned().unwrap_or_else(|| number.to_string())
    }

    /// The simplices of all groups of a dimension, by name, sorted and without repetition.
    fn groups_by_name(&self, dimension: usize) -> BTreeMap<String, Vec<u32>> {
        let mut parts: BTreeMap<String, Vec<u32>> = BTreeMap::new();
        for ((_, number), members) in
            self.groups.range((dimension, i64::MIN)..=(dimension, i64::MAX))
        {
            parts.entry(self.name(dimension, *number)).or_default().extend(members);
        }
        for members in parts.values_mut() {
            members.sort_unstable();
            members.dedup();
        }
        parts
    }

    fn name_regions<const D: usize>(&self, mesh: &mut Mesh<D>) {
        for (name, cells) in self.groups_by_name(D) {
            mesh.set_region(name, cells);
        }
    }

    fn name_boundaries<const D: usize>(&self, mesh: &mut Mesh<D>, new: &[u32]) -> Vec<Warning> {
        let key_of = |c: usize, k: usize| facet_key::<D>(mesh.cell(c), k);
        let on_boundary: HashMap<[u32; 3], u32> = mesh
            .facets()
            .iter()
            .zip(0..)
            .map(|(f, i)| (key_of(f.cell as usize, f.opposite as usize), i))
            .collect();
        let mut warnings = Vec::new();
        let mut parts = Vec::new();
        for (name, members) in self.groups_by_name(D - 1) {
            let mut facets = Vec::new();
            let mut inner = Vec::new();
            for m in members {
                let vertices = self.simplices[D - 1][m as usize];
                let mut key = [NONE; 3];
                for k in 0..D {
                    key[k] = new[vertices[k] as usize];
                }
                key.sort_unstable();
                match on_boundary.get(&key) {
                    Some(&f) => facets.push(f),
                    None => inner.push(vertices),
                }
            }
            if let Some(vertices) = inner.first() {
                let at: Vec<_> = vertices[..D].iter().map(|&v| self.points[v as usize]).collect();
                warnings.push(Warning::new(
                    format!(
                        "{}: {} sides of the physical group \"{name}\" do not lie on the boundary \
                         of the mesh and are left out, the first has the corners {at:?}",
                        self.file,
                        inner.len()
                    ),
                    "conditions can be given on the boundary only; a line or surface inside may \
                     be left out of the groups",
                ));
            }
            if !facets.is_empty() {
                facets.sort_unstable();
                facets.dedup();
                parts.push((name, facets));
            }
        }
        for (name, facets) in parts {
            mesh.set_boundary(name, facets);
        }
        warnings
    }

    /// Names without elements, and groups of a dimension without meaning here.
    fn unused_groups(&self, dimension: usize) -> Vec<Warning> {
        let mut warnings = Vec::new();
        for (&(d, number), name) in &self.names {
            if !self.groups.contains_key(&(d, number)) {
                warnings.push(Warning::new(
                    format!(
                        "{}: the physical group \"{name}\" of dimension {d} has no elements",
                        self.file
                    ),
                    "check its definition in the geometry; with -save_all, gmsh keeps groups in \
                     version 4.1 but not in 2.2",
                ));
            }
        }
        for &(d, number) in self.groups.keys().filter(|(d, _)| d + 1 < dimension) {
            let name = self.name(d, number);
            warnings.push(Warning::new(
                format!(
                    "{}: the physical group \"{name}\" of dimension {d} is left out",
                    self.file
                ),
                format!(
                    "only groups of dimension {} (boundaries) and {dimension} (regions) are used",
                    dimension - 1
                ),
            ));
        }
        warnings
    }
}
