//! The box around a scene: its edges, a grid on the walls at the back, and axes with numbers.

use super::super::legend::{QUIET, TEXT};
use super::super::lettering::{self, Align};
use super::super::numbers::{tick_text, ticks};
use super::super::raster::{Image, Ink};
use super::camera::{Camera, Spot};
use super::canvas::Stroke;
use crate::mesh::Point;

/// A box as the camera sees it.
pub(super) struct BoxEdges<'a> {
    camera: &'a Camera,
    corners: [Point<3>; 2],
    /// True for the lower and the upper wall across each axis that is at the back: seen from inside
    /// of the box.
    back: [[bool; 2]; 3],
}

/// An edge: its axis and which end of the two next axes it lies at.
#[derive(Clone, Copy)]
struct Edge {
    axis: usize,
    sides: [usize; 2],
}

const EDGE: [u8; 3] = [84, 90, 98];
const GRID: [u8; 3] = [196, 202, 210];
/// Height of the numbers, and length of their ticks.
const SIZE: f64 = 8.5;
const TICK: f64 = 6.0;

impl<'a> BoxEdges<'a> {
    pub fn new(camera: &'a Camera, corners: [Point<3>; 2]) -> BoxEdges<'a> {
        let middle = (corners[0] + corners[1]) * 0.5;
        let back = |axis: usize, side: usize| {
            let mut wall = middle;
            wall[axis] = corners[side][axis];
            let outward = if side == 0 { -1.0 } else { 1.0 };
            // A wall seen from its edge is at the back: rounding must not decide where the axes
            // are.
            camera.to_eye(&wall)[axis] * outward < 1e-9
        };
        BoxEdges {
            camera,
            corners,
            back: std::array::from_fn(|axis| [back(axis, 0), back(axis, 1)]),
        }
    }
    /// The corners of a box.
    pub fn vertices(corners: [Point<3>; 2]) -> [Point<3>; 8] {
        std::array::from_fn(|k| Point::<3>::from_fn(|axis, _| corners[(k >> axis) & 1][axis]))
    }
    /// The grid, and the edges from those at the back to those in front.
    pub fn strokes(&self) -> Vec<Stroke> {
        let stroke = |lines, width, rgb, opacity, lift| Stroke { lines, width, rgb, opacity, lift };
        let edges = |walls: usize| {
            let chosen = edges().filter(|e| self.walls_at_back(*e) == walls);
            chosen.map(|e| self.ends(e).map(|p| self.camera.project(&p))).collect::<Vec<_>>()
        };
        vec![
            // Slices along a wall hide its grid: all of its width, also where the wall leans away.
            stroke(self.grid(), 0.8, GRID, [0.75, 0.0], -5e-3),
            stroke(edges(2), 1.1, EDGE, [0.6, 0.2], 1e-4),
            stroke(edges(1), 1.2, EDGE, [0.9, 0.25], 1e-3),
            stroke(edges(0), 1.0, EDGE, [0.45, 0.2], 1e-3),
        ]
    }
    /// Lines at the ticks, on the walls at the back.
    fn grid(&self) -> Vec<[Spot; 2]> {
        let mut lines = Vec::new();
        for (wall, side) in
            (0..3).flat_map(|wall| [(wall, 0), (wall, 1)]).filter(|(w, s)| self.back[*w][*s])
        {
            for axis in [(wall + 1) % 3, (wall + 2) % 3] {
                let along = 3 - wall - axis;
                for v in self.ticks(axis) {
                    lines.push([0, 1].map(|end| {
                        let mut p = Point::<3>::zeros();
                        (p[wall], p[axis], p[along]) =
                            (self.corners[side][wall], v, self.corners[end][along]);
                        self.camera.project(&p)
                    }));
                }
            }
        }
        lines
    }
    /// Numbers and names of the axes, on edges at the rim of the box: z at the left, x and y below.
    pub fn draw_axes(&self, image: &mut Image) {
        let mut taken = Vec::new();
        for axis in 0..3 {
            let rim = edges().filter(|e| e.axis == axis && self.walls_at_back(*e) == 1);
            let place = |e: &Edge| {
                let [a, b] = self.ends(*e).map(|p| self.camera.project(&p).at);
                let below = if axis == 2 { -0.5 * (a[0] + b[0]) } else { 0.5 * (a[1] + b[1]) };
                ((b[0] - a[0]).hypot(b[1] - a[1]) > 3.0 * SIZE).then_some((below, *e))
            };
            let chosen = rim.filter_map(|e| place(&e)).max_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((_, edge)) = chosen {
                self.draw_axis(edge, &mut taken, image);
            }
        }
    }
    /// Leaves out numbers that would cover others, as they do where two axes meet: `taken` lists
    /// their boxes.
    fn draw_axis(&self, edge: Edge, taken: &mut Vec<[f64; 4]>, image: &mut Image) {
        let (axis, ends) = (edge.axis, self.ends(edge));
        let [a, b] = ends.map(|p| self.camera.project(&p).at);
        let out = self.outward(a, b);
        let (low, high) = (self.corners[0][axis], self.corners[1][axis]);
        let mut widest = 0.0f64;
        for v in self.ticks(axis) {
            let mut p = ends[0];
            p[axis] = v;
            let [x, y] = self.camera.project(&p).at;
            let tip = [x + TICK * out[0], y + TICK * out[1]];
            image.stroke(&[[[x, y], tip]], 1.0, QUIET);
            let text = tick_text(v, 0.2 * (high - low), low.abs().max(high.abs()));
            widest = widest.max(lettering::width(&text, SIZE));
            let place = Place::beside(&text, tip, out, SIZE);
            if taken.iter().all(|t| place.is_clear_of(t)) {
                taken.push(place.bounds);
                place.draw(&text, image, QUIET);
            }
        }
        let far = TICK + 12.0 + out[0].abs() * widest + out[1].abs() * SIZE;
        let middle = [0.5 * (a[0] + b[0]) + far * out[0], 0.5 * (a[1] + b[1]) + far * out[1]];
        let name = ["x", "y", "z"][axis];
        Place::beside(name, middle, out, 11.0).draw(name, image, TEXT);
    }
    /// The direction in the picture away from the box, across an edge at its rim.
    fn outward(&self, a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
        let middle = self.camera.project(&((self.corners[0] + self.corners[1]) * 0.5)).at;
        let (d, length) = ([b[0] - a[0], b[1] - a[1]], (b[0] - a[0]).hypot(b[1] - a[1]));
        let n = [-d[1] / length, d[0] / length];
        let away = n[0] * (a[0] - middle[0]) + n[1] * (a[1] - middle[1]);
        if away < 0.0 { [-n[0], -n[1]] } else { n }
    }
    fn ticks(&self, axis: usize) -> Vec<f64> {
        let (low, high) = (self.corners[0][axis], self.corners[1][axis]);
        // By the length without foreshortening, so that the axes of a cube have the same numbers.
        ticks(low, high, ((high - low) * self.camera.scale / 70.0).clamp(2.0, 6.0))
    }
    fn ends(&self, edge: Edge) -> [Point<3>; 2] {
        [0, 1].map(|end| {
            let mut p = self.corners[end];
            for (k, side) in edge.sides.into_iter().enumerate() {
                let axis = (edge.axis + 1 + k) % 3;
                p[axis] = self.corners[side][axis];
            }
            p
        })
    }
    /// Number of the two walls that meet in an edge and are at the back: with one it lies at the
    /// rim.
    fn walls_at_back(&self, edge: Edge) -> usize {
        (0..2).filter(|&k| self.back[(edge.axis + 1 + k) % 3][edge.sides[k]]).count()
    }
}

fn edges() -> impl Iterator<Item = Edge> {
    (0..12).map(|k| Edge { axis: k / 4, sides: [k & 1, (k >> 1) & 1] })
}

/// Place of a text.
struct Place {
    size: f64,
    /// Left, top, right and bottom.
    bounds: [f64; 4],
}

impl Place {
    /// For a text that begins at a point and lies in a direction from it.
    fn beside(text: &str, at: [f64; 2], out: [f64; 2], size: f64) -> Place {
        let half = [0.5 * lettering::width(text, size), 0.5 * size];
        let [x, y] = [0, 1].map(|k| at[k] + out[k] * (half[k] + 5.0));
        Place { size, bounds: [x - half[0], y - half[1], x + half[0], y + half[1]] }
    }
    fn is_clear_of(&self, other: &[f64; 4]) -> bool {
        let ([a, b, c, d], gap) = (self.bounds, 4.0);
        c + gap < other[0] || other[2] + gap < a || d + gap < other[1] || other[3] + gap < b
    }
    fn draw(&self, text: &str, image: &mut Image, ink: Ink) {
        let [left, _, right, bottom] = self.bounds;
        lettering::draw(image, text, [0.5 * (left + right), bottom], self.size, Align::Centre, ink);
    }
}
