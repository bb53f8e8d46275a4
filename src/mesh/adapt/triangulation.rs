//! A triangulation with local changes: triangles with their neighbours, and the fixed parts of
//! boundaries and regions.

use super::background::{Background, Sample};
use super::measure;
use super::parts::Parts;
use crate::base::Result;
use crate::mesh::{Mesh, NONE, Point};

/// Sine of the angle below which two sides of a polygon form a straight line.
const STRAIGHT: f64 = 1e-10;

/// Freedom of a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Freedom {
    /// Anywhere.
    Free,
    /// Along the straight part of a boundary or interface that it lies on.
    Line,
    /// Not at all, nor may it be removed.
    Fixed,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    pub point: Point<2>,
    pub metric: Sample,
    pub kind: Freedom,
    /// A triangle that contains it.
    pub triangle: u32,
    /// True if something around it has changed since its last trial move.
    pub pending: bool,
}

/// A positively oriented triangle; side `k` lies opposite to vertex `k`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Triangle {
    /// Its vertices; the first is [`NONE`] if the triangle was removed.
    pub vertices: [u32; 3],
    /// The triangles across its sides, [`NONE`] on the boundary.
    pub neighbours: [u32; 3],
    /// Set of boundaries of each side, 0 inside.
    pub sides: [u32; 3],
    /// Set of regions.
    pub region: u32,
}

/// A side of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Side {
    pub triangle: u32,
    pub opposite: usize,
}

pub(super) struct Triangulation<'a> {
    pub background: Background<'a>,
    pub vertices: Vec<Vertex>,
    pub triangles: Vec<Triangle>,
    /// Removed triangles whose numbers can be reused.
    free: Vec<u32>,
    /// Removed vertices whose numbers can be reused.
    free_vertices: Vec<u32>,
    /// True if sides on the boundary are fixed.
    pub frozen_boundary: bool,
    boundaries: Parts,
    regions: Parts,
}

/// The vertices of a mesh with their metric, each with one of its triangles.
fn vertices_of(background: &Background<'_>, triangles: &[Triangle]) -> Vec<Vertex> {
    // Points of no cell keep the dummy until their numbers are used for others.
    let dummy = background.at_vertex(0, 0);
    let vertex = |p: &Point<2>| Vertex {
        point: *p,
        metric: dummy,
        kind: Freedom::Free,
        triangle: NONE,
        pending: false,
    };
    let mut vertices: Vec<Vertex> = background.mesh.points().iter().map(vertex).collect();
    for (c, triangle) in triangles.iter().enumerate() {
        for (k, &v) in triangle.vertices.iter().enumerate() {
            let vertex = &mut vertices[v as usize];
            if vertex.triangle == NONE {
                vertex.triangle = c as u32;
                vertex.metric = background.at_vertex(c, k);
            }
        }
    }
    vertices
}

impl<'a> Triangulation<'a> {
    pub fn new(background: Background<'a>, frozen_boundary: bool) -> Triangulation<'a> {
        let mesh = background.mesh;
        let (regions, of_cell) = Parts::new(mesh.regions(), mesh.cell_count());
        let (boundaries, of_facet) = Parts::new(mesh.boundaries(), mesh.facets().len());
        let mut triangles: Vec<Triangle> = (0..mesh.cell_count())
            .map(|c| Triangle {
                vertices: [0, 1, 2].map(|k| mesh.cell(c)[k]),
                neighbours: [0, 1, 2].map(|k| mesh.neighbours(c)[k]),
                sides: [0; 3],
                region: of_cell[c],
            })
            .collect();
        for (f, mark) in mesh.facets().iter().zip(of_facet) {
            triangles[f.cell as usize].sides[f.opposite as usize] = mark;
        }
        let vertices = vertices_of(&background, &triangles);
        let free_vertices =
            (0..).zip(&vertices).filter(|(_, v)| v.triangle == NONE).map(|(v, _)| v).collect();
        let mut new = Triangulation {
            background,
            vertices,
            triangles,
            free: Vec::new(),
            free_vertices,
            frozen_boundary,
            boundaries,
            regions,
        };
        new.find_kinds();
        new
    }

    /// Determines the freedom of every vertex from the fixed sides.
    fn find_kinds(&mut self) {
        // Number of kept sides at a vertex, and the first two: other end, boundaries, regions on
        // both sides.
        let mut kept = vec![(0, [(0, [0; 3]); 2]); self.vertices.len()];
        for side in self.sides().filter(|s| self.is_kept(*s)) {
            let triangle = &self.triangles[side.triangle as usize];
            let other = triangle.neighbours[side.opposite];
            let beyond = if other == NONE { NONE } else { self.triangles[other as usize].region };
            let what = [
                triangle.sides[side.opposite],
                triangle.region.min(beyond),
                triangle.region.max(beyond),
            ];
            let [a, b] = self.ends(side);
            for (v, other) in [(a, b), (b, a)] {
                let (count, sides) = &mut kept[v as usize];
                if *count < 2 {
                    sides[*count] = (other, what);
                }
                *count += 1;
            }
        }
        let frozen: Vec<u32> = self
            .sides()
            .filter(|s| self.frozen_boundary && self.is_boundary(*s))
            .flat_map(|s| self.ends(s))
            .collect();
        for (v, (count, [first, second])) in kept.into_iter().enumerate() {
            let to = |other: u32| self.vertices[other as usize].point - self.vertices[v].point;
            self.vertices[v].kind = match count {
                0 => Freedom::Free,
                2 if first.1 == second.1 && is_straight(&to(first.0), &to(second.0)) => {
                    Freedom::Line
                }
                _ => Freedom::Fixed,
            };
        }
        frozen.into_iter().for_each(|v| self.vertices[v as usize].kind = Freedom::Fixed);
    }

    /// Every side once, from the triangle with the smaller number.
    pub fn sides(&self) -> impl Iterator<Item = Side> + '_ {
        let of_triangle = |(t, triangle): (u32, &Triangle)| {
            let n = triangle.neighbours;
            let alive = triangle.vertices[0] != NONE;
            (0..3)
                .filter(move |&k| alive && t < n[k])
                .map(move |opposite| Side { triangle: t, opposite })
        };
        (0..).zip(&self.triangles).flat_map(of_triangle)
    }

    /// The triangles that were not removed.
    pub fn alive(&self) -> impl Iterator<Item = u32> + '_ {
        (0..).zip(&self.triangles).filter(|(_, t)| t.vertices[0] != NONE).map(|(t, _)| t)
    }

    /// The ends of a side, in the order of its triangle.
    pub fn ends(&self, side: Side) -> [u32; 2] {
        let v = &self.triangles[side.triangle as usize].vertices;
        [v[(side.opposite + 1) % 3], v[(side.opposite + 2) % 3]]
    }

    pub fn is_boundary(&self, side: Side) -> bool {
        self.triangles[side.triangle as usize].neighbours[side.opposite] == NONE
    }

    /// True if a side lies on the boundary or between two regions.
    pub fn is_kept(&self, side: Side) -> bool {
        let triangle = &self.triangles[side.triangle as usize];
        let other = triangle.neighbours[side.opposite];
        other == NONE || self.triangles[other as usize].region != triangle.region
    }

    /// The side of the neighbouring triangle that is the same.
    pub fn twin(&self, side: Side) -> Option<Side> {
        let other = self.triangles[side.triangle as usize].neighbours[side.opposite];
        let neighbours = &self.triangles.get(other as usize)?.neighbours;
        let opposite = neighbours.iter().position(|&n| n == side.triangle)?;
        Some(Side { triangle: other, opposite })
    }

    /// The side between `a` and `b` of a triangle, if it has both.
    pub fn side_of(&self, triangle: u32, a: u32, b: u32) -> Option<Side> {
        let v = &self.triangles[triangle as usize].vertices;
        let opposite = v.iter().position(|&x| x != a && x != b)?;
        let has_both = v.contains(&a) && v.contains(&b);
        has_both.then_some(Side { triangle, opposite })
    }

    /// Makes two sides neighbours, or `side` part of the boundary.
    pub fn link(&mut self, side: Side, twin: Option<Side>) {
        self.triangles[side.triangle as usize].neighbours[side.opposite] =
            twin.map_or(NONE, |t| t.triangle);
        if let Some(twin) = twin {
            self.triangles[twin.triangle as usize].neighbours[twin.opposite] = side.triangle;
        }
    }

    /// Stores a triangle as number `t` and registers it with its vertices.
    pub fn put(&mut self, t: u32, triangle: Triangle) {
        self.triangles[t as usize] = triangle;
        for v in triangle.vertices {
            let vertex = &mut self.vertices[v as usize];
            (vertex.triangle, vertex.pending) = (t, true);
        }
    }

    pub fn add(&mut self, triangle: Triangle) -> u32 {
        let t = self.free.pop().unwrap_or_else(|| {
            self.triangles.push(triangle);
            self.triangles.len() as u32 - 1
        });
        self.put(t, triangle);
        t
    }

    pub fn remove(&mut self, t: u32) {
        self.triangles[t as usize].vertices = [NONE; 3];
        self.triangles[t as usize].neighbours = [NONE; 3];
        self.free.push(t);
    }

    pub fn add_vertex(&mut self, vertex: Vertex) -> u32 {
        let Some(v) = self.free_vertices.pop() else {
            self.vertices.push(vertex);
            return self.vertices.len() as u32 - 1;
        };
        self.vertices[v as usize] = vertex;
        v
    }

    pub fn remove_vertex(&mut self, v: u32) {
        self.vertices[v as usize].triangle = NONE;
        self.free_vertices.push(v);
    }

    /// Number of vertices that were not removed.
    pub fn vertex_count(&self) -> usize {
        self.vertices.len() - self.free_vertices.len()
    }

    /// The triangles around a vertex, counter-clockwise, each with the place of the vertex in it.
    /// On the boundary the first and the last have the sides on it.
    pub fn star(&self, v: u32, out: &mut Vec<Side>) {
        out.clear();
        let start = self.vertices[v as usize].triangle;
        if start == NONE {
            return;
        }
        let corner = |t: u32| {
            let k = self.triangles[t as usize].vertices.iter().position(|&x| x == v);
            Side { triangle: t, opposite: k.unwrap_or(0) }
        };
        // Clockwise to the boundary or once round, then counter-clockwise from there.
        let clockwise =
            |s: Side| self.triangles[s.triangle as usize].neighbours[(s.opposite + 2) % 3];
        let counter =
            |s: Side| self.triangles[s.triangle as usize].neighbours[(s.opposite + 1) % 3];
        let mut first = corner(start);
        loop {
            let next = clockwise(first);
            if next == NONE || next == start {
                break;
            }
            first = corner(next);
        }
        let mut at = first;
        loop {
            out.push(at);
            let next = counter(at);
            if next == NONE || next == first.triangle {
                break;
            }
            at = corner(next);
        }
    }

    /// Length of the edge between two vertices in the metric.
    #[inline]
    pub fn length(&self, a: u32, b: u32) -> f64 {
        let (a, b) = (&self.vertices[a as usize], &self.vertices[b as usize]);
        measure::length(&a.point, &a.metric.tensor, &b.point, &b.metric.tensor)
    }

    /// Quality of a triangle in the metric; 0 if it is flat or inverted.
    #[inline]
    pub fn quality(&self, v: [u32; 3]) -> f64 {
        let [a, b, c] = v.map(|v| &self.vertices[v as usize]);
        measure::quality(
            [&a.point, &b.point, &c.point],
            [&a.metric.tensor, &b.metric.tensor, &c.metric.tensor],
        )
    }

    /// The mesh, its points in the order of the vertices, its parts named as before.
    pub fn mesh(&self) -> Result<Mesh<2>> {
        let mut numbers = vec![NONE; self.vertices.len()];
        let mut points = Vec::new();
        let used: Vec<u32> = self.alive().collect();
        for &t in &used {
            self.triangles[t as usize].vertices.into_iter().for_each(|v| numbers[v as usize] = 0);
        }
        for (vertex, number) in self.vertices.iter().zip(&mut numbers).filter(|(_, n)| **n != NONE)
        {
            *number = points.len() as u32;
            points.push(vertex.point);
        }
        let cells = used
            .iter()
            .flat_map(|&t| self.triangles[t as usize].vertices)
            .map(|v| numbers[v as usize]);
        let mut mesh = Mesh::new(points, cells.collect())?;
        let triangle = |t: u32| &self.triangles[t as usize];
        let sides = mesh
            .facets()
            .iter()
            .map(|f| triangle(used[f.cell as usize]).sides[f.opposite as usize]);
        let boundaries: Vec<_> = self.boundaries.members(sides).collect();
        boundaries.into_iter().for_each(|(name, facets)| mesh.set_boundary(name, facets));
        for (name, cells) in self.regions.members(used.iter().map(|&t| triangle(t).region)) {
            mesh.set_region(name, cells);
        }
        Ok(mesh)
    }
}

fn is_straight(a: &Point<2>, b: &Point<2>) -> bool {
    a.dot(b) < 0.0 && a.perp(b).abs() <= STRAIGHT * a.norm() * b.norm()
}
