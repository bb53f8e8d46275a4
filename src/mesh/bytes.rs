//! A mesh as bytes, and back.

use super::Mesh;
use crate::base::bytes::{Reader, Writer};
use std::collections::BTreeMap;

impl<const D: usize> Mesh<D> {
    /// Points, cells and names, for [`from_bytes`](Self::from_bytes).
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut out = Writer::default();
        out.vectors(&self.points);
        out.integers(&self.cells);
        for names in [&self.boundaries, &self.regions] {
            out.integer(names.len() as u64);
            for (name, list) in names {
                out.text(name);
                out.integers(list);
            }
        }
        out.0
    }

    /// The mesh of [`to_bytes`](Self::to_bytes): the same points, cells and facets in the same
    /// order. `None` if the bytes are not a mesh.
    pub fn from_bytes(bytes: &[u8]) -> Option<Mesh<D>> {
        let mut from = Reader(bytes);
        let mut mesh = Mesh::new(from.vectors()?, from.integers()?).ok()?;
        let mut names = || -> Option<BTreeMap<String, Vec<u32>>> {
            let list = from.list(|from| Some((from.text()?, from.integers()?)))?;
            Some(list.into_iter().collect())
        };
        (mesh.boundaries, mesh.regions) = (names()?, names()?);
        let fits = |names: &BTreeMap<_, Vec<u32>>, count: usize| {
            names.values().flatten().all(|&k| (k as usize) < count)
        };
        let whole =
            fits(&mesh.boundaries, mesh.facets.len()) && fits(&mesh.regions, mesh.cell_count());
        (from.0.is_empty() && whole).then_some(mesh)
    }
}

#[cfg(test)]
mod tests {
    use crate::mesh::{Diagonals, Mesh, rectangle};

    #[test]
    fn a_mesh_comes_back_as_it_was_and_bytes_that_are_cut_off_are_none() {
        let mut mesh = rectangle([0.0, 0.0], [1.0, 0.3], [4, 3], Diagonals::UnionJack).unwrap();
        mesh.set_region("fluid", (0..24).collect());
        let bytes = mesh.to_bytes();
        let again = Mesh::<2>::from_bytes(&bytes).unwrap();
        assert_eq!((again.points(), &again.cells), (mesh.points(), &mesh.cells));
        assert_eq!(
            (again.facets(), again.boundaries(), again.regions()),
            (mesh.facets(), mesh.boundaries(), mesh.regions())
        );
        assert_eq!(again.neighbours, mesh.neighbours);
        assert!((0..bytes.len()).all(|cut| Mesh::<2>::from_bytes(&bytes[..cut]).is_none()));
    }
}
