//! Straight steps through a mesh with periodic sides.

use crate::fem::Translation;
use crate::mesh::{Location, Mesh, NONE, Point};
use nalgebra::SVector;
use std::sync::Arc;

/// Largest number of periodic sides that one displacement crosses.
const MOST_CROSSINGS: usize = 64;

/// A mesh with its periodic sides.
#[derive(Clone, Debug)]
pub struct Passage<const D: usize> {
    mesh: Arc<Mesh<D>>,
    /// For every facet (cell, opposite vertex) on a periodic side: the cell on the other side and
    /// the translation. Sorted by facet.
    links: Vec<(u32, u32, SVector<f64, D>)>,
    /// The different translations.
    shifts: Vec<SVector<f64, D>>,
}

impl<const D: usize> Passage<D> {
    /// `mesh` with the sides that the translations identify.
    pub fn new(mesh: &Arc<Mesh<D>>, translations: &[Translation<D>]) -> Passage<D> {
        let mut links: Vec<_> = translations
            .iter()
            .map(|t| {
                let (mine, theirs) =
                    (mesh.facets()[t.facet as usize], mesh.facets()[t.partner as usize]);
                (mine.cell * (D as u32 + 1) + mine.opposite, theirs.cell, t.shift)
            })
            .collect();
        links.sort_by_key(|d| d.0);
        links.dedup_by_key(|d| d.0);
        let mut shifts: Vec<SVector<f64, D>> = Vec::new();
        for (_, _, shift) in &links {
            if shifts.iter().all(|s| (s - shift).norm() > 1e-6 * shift.norm()) {
                shifts.push(*shift);
            }
        }
        Passage { mesh: Arc::clone(mesh), links, shifts }
    }
    /// The mesh.
    pub fn mesh(&self) -> &Mesh<D> {
        &self.mesh
    }
    /// True if there are periodic sides.
    pub fn has_periodic_sides(&self) -> bool {
        !self.links.is_empty()
    }
    /// The cell beyond facet `k` of a cell, also through a periodic side, with the translation to
    /// its points; `None` on other boundaries.
    pub fn beyond(&self, cell: u32, k: usize) -> Option<(u32, SVector<f64, D>)> {
        match self.mesh.neighbours(cell as usize)[k] {
            NONE => {
                let facet = cell * (D as u32 + 1) + k as u32;
                let found = self.links.binary_search_by_key(&facet, |d| d.0).ok()?;
                let (_, partner, shift) = self.links[found];
                Some((partner, shift))
            }
            next => Some((next, SVector::zeros())),
        }
    }
    /// The shortest periodic image of a displacement that is shorter than half a period.
    pub fn unwrapped(&self, mut step: SVector<f64, D>) -> SVector<f64, D> {
        // One pair of sides after the other; a corner needs one of each.
        for _ in 0..D {
            let images = self.shifts.iter().map(|shift| step - shift);
            step = images.fold(
                step,
                |best, s| if s.norm_squared() < best.norm_squared() { s } else { best },
            );
        }
        step
    }
    /// Moves by `step`, through periodic sides. Returns the end, and false if the step leaves the
    /// domain.
    pub fn travel(&self, from: Location, step: SVector<f64, D>) -> (Location, bool) {
        let mesh = &self.mesh;
        let x = mesh.point_at(&from);
        let target: Point<D> = x + step;
        let (mut end, inside) = mesh.walk(from.cell, &x, &target);
        let inside = inside || self.through_sides(&mut end, x, target);
        (end, inside)
    }
    /// Moves `at`, the location of `x`, to `target`, which has the barycentric coordinates `end` in
    /// its cell, like [`travel`](Self::travel).
    #[inline]
    pub fn reach(&self, at: &mut Location, end: &[f64; 4], x: Point<D>, target: Point<D>) -> bool {
        self.mesh.walk_on(at, end, &x, &target) || self.through_sides(at, x, target)
    }
    /// Goes on from `at`, where the segment from `x` to `target` has left the mesh, if that is a
    /// periodic side. Returns false if the segment leaves the domain.
    #[cold]
    fn through_sides(&self, at: &mut Location, mut x: Point<D>, mut target: Point<D>) -> bool {
        let mesh = &self.mesh;
        // More periodic sides than a particle can cross in a step, or in the time of a submap.
        for _ in 0..MOST_CROSSINGS {
            let facets = (0..=D as u32)
                .filter(|&k| at.barycentric[k as usize] <= 1e-9)
                .map(|k| at.cell * (D as u32 + 1) + k);
            let link = facets
                .filter_map(|s| self.links.binary_search_by_key(&s, |d| d.0).ok())
                .map(|i| &self.links[i])
                .find(|d| d.2.dot(&(target - x)) < 0.0);
            let Some(&(_, partner, shift)) = link else { return false };
            x = mesh.point_at(at) + shift;
            target += shift;
            let (end, inside) = mesh.walk(partner, &x, &target);
            *at = end;
            if inside {
                return true;
            }
        }
        false
    }
}
