//! From space to the picture: where the viewer stands, and which pixel shows a point.

use crate::mesh::Point;
use nalgebra::SVector;

/// Position of the viewer; the z axis points up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Degrees from the x axis towards the y axis, of the direction from the middle of the box to
    /// the viewer.
    pub azimuth: f64,
    /// Degrees above the plane of x and y; 90 looks down.
    pub elevation: f64,
    /// Projection of lengths at a distance.
    pub projection: Projection,
}

impl Default for View {
    /// From the front, a little from the right and above: x runs to the right, y away from the
    /// viewer, z up.
    fn default() -> View {
        View { azimuth: -60.0, elevation: 24.0, projection: Projection::Perspective }
    }
}

/// Projection of lengths at a distance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Projection {
    /// Not at all: parallel lines stay parallel, equal lengths equal.
    Orthographic,
    /// As for an eye two diagonals of the box away from its middle.
    Perspective,
}

/// Diagonals of the box between its middle and the eye.
const DISTANCE: f64 = 2.0;

/// A point as the picture shows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spot {
    /// Pixels from the upper left corner.
    pub at: [f64; 2],
    /// Greater for what is nearer to the viewer; linear along lines and planes of the picture, one
    /// unit about the distance of the eye.
    pub near: f64,
    /// Weight of a value in the interpolation between points of the picture.
    pub weight: f64,
}

/// Maps points of space to pixels.
#[derive(Clone, Debug)]
pub(super) struct Camera {
    middle: Point<3>,
    /// Directions of the picture: to the right, up, and towards the viewer.
    pub axes: [SVector<f64, 3>; 3],
    /// From the middle to the eye, also the unit of depth without perspective.
    distance: f64,
    projection: Projection,
    /// Pixels per unit of length in the middle of the box.
    pub scale: f64,
    /// The pixel of the middle of the box.
    origin: [f64; 2],
}

impl Camera {
    /// Looks at the middle of a box, one pixel a unit of length.
    pub fn new(view: &View, [low, high]: [Point<3>; 2]) -> Camera {
        let (a, e) = (view.azimuth.to_radians(), view.elevation.to_radians());
        let right = SVector::<f64, 3>::new(-a.sin(), a.cos(), 0.0);
        let toward = SVector::<f64, 3>::new(e.cos() * a.cos(), e.cos() * a.sin(), e.sin());
        Camera {
            middle: (low + high) * 0.5,
            axes: [right, toward.cross(&right), toward],
            distance: DISTANCE * (high - low).norm(),
            projection: view.projection,
            scale: 1.0,
            origin: [0.0; 2],
        }
    }
    /// The same with `points` as large as fits into `room` pixels. Returns the pixels that they
    /// take: their upper left is at the pixel (0, 0).
    pub fn fit(&mut self, points: &[Point<3>], room: [f64; 2]) -> [f64; 2] {
        (self.scale, self.origin) = (1.0, [0.0; 2]);
        let spots: Vec<[f64; 2]> = points.iter().map(|p| self.project(p).at).collect();
        let range = |axis: usize| {
            spots.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), s| {
                (a.min(s[axis]), b.max(s[axis]))
            })
        };
        let (x, y) = (range(0), range(1));
        // A box seen along an edge is flat, but no box is a point.
        self.scale = (room[0] / (x.1 - x.0)).min(room[1] / (y.1 - y.0));
        self.origin = [-x.0 * self.scale, -y.0 * self.scale];
        [(x.1 - x.0) * self.scale, (y.1 - y.0) * self.scale]
    }
    /// Moves the picture by so many pixels.
    pub fn shift(&mut self, [x, y]: [f64; 2]) {
        self.origin = [self.origin[0] + x, self.origin[1] + y];
    }
    pub fn project(&self, p: &Point<3>) -> Spot {
        let [x, y, z] = self.axes.map(|axis| axis.dot(&(p - self.middle)));
        let (near, weight) = match self.projection {
            Projection::Orthographic => (z / self.distance, 1.0),
            Projection::Perspective => {
                (1.0 / (1.0 - z / self.distance), 1.0 / (1.0 - z / self.distance))
            }
        };
        let scale = self.scale * weight;
        Spot { at: [self.origin[0] + scale * x, self.origin[1] - scale * y], near, weight }
    }
    /// Gradients with respect to the point of its column and its row in the picture.
    pub fn derivative(&self, p: &Point<3>) -> [SVector<f64, 3>; 2] {
        let Spot { at, weight, .. } = self.project(p);
        let [right, up, toward] = self.axes;
        let lean = match self.projection {
            Projection::Orthographic => 0.0,
            Projection::Perspective => weight / self.distance,
        };
        let s = self.scale * weight;
        let away = |axis: usize| toward * (lean * (at[axis] - self.origin[axis]));
        [right * s + away(0), up * -s + away(1)]
    }
    /// The direction from a point to the eye, a unit vector.
    pub fn to_eye(&self, p: &Point<3>) -> SVector<f64, 3> {
        match self.projection {
            Projection::Orthographic => self.axes[2],
            Projection::Perspective => (self.middle + self.axes[2] * self.distance - p).normalize(),
        }
    }
}

/// The weights of the corners of a triangle at a point of space, from those at its pixel.
pub(super) fn in_space(spots: &[Spot; 3], l: [f64; 3]) -> [f64; 3] {
    let w: [f64; 3] = std::array::from_fn(|k| l[k] * spots[k].weight);
    w.map(|v| v / (w[0] + w[1] + w[2]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(azimuth: f64, elevation: f64, projection: Projection) -> Camera {
        let (low, high) = (Point::<3>::new(-1.0, -1.0, -1.0), Point::<3>::new(1.0, 1.0, 2.0));
        let mut camera = Camera::new(&View { azimuth, elevation, projection }, [low, high]);
        camera.fit(&[low, high], [300.0, 200.0]);
        camera
    }

    #[test]
    fn from_the_front_x_runs_to_the_right_and_z_up() {
        for projection in [Projection::Orthographic, Projection::Perspective] {
            let camera = camera(-90.0, 0.0, projection);
            let at = |x, y, z| camera.project(&Point::<3>::new(x, y, z));
            let o = at(0.0, 0.0, 0.0);
            assert!(
                at(1.0, 0.0, 0.0).at[0] > o.at[0] + 1.0 && at(0.0, 0.0, 1.0).at[1] < o.at[1] - 1.0
            );
            assert!(at(0.0, -1.0, 0.0).near > o.near && at(0.0, 1.0, 0.0).near < o.near);
        }
    }

    #[test]
    fn the_points_fill_the_room() {
        let camera = camera(20.0, 30.0, Projection::Perspective);
        let spots =
            [[-1.0, -1.0, -1.0], [1.0, 1.0, 2.0]].map(|p| camera.project(&Point::<3>::from(p)).at);
        let width = (spots[0][0] - spots[1][0]).abs();
        let height = (spots[0][1] - spots[1][1]).abs();
        assert!((width - 300.0).abs() < 1e-9 || (height - 200.0).abs() < 1e-9, "{width} {height}");
        assert!(spots.iter().all(|s| s[0] > -1e-9 && s[1] > -1e-9));
    }

    #[test]
    fn depth_is_linear_in_the_picture_and_weights_bring_points_back() {
        let camera = camera(35.0, -20.0, Projection::Perspective);
        let p = [[-1.0, 0.3, 0.9], [0.4, -1.0, 0.1], [0.7, 0.8, -0.5]].map(Point::<3>::from);
        let spots = p.map(|p| camera.project(&p));
        let l = [0.2, 0.5, 0.3];
        let w = in_space(&spots, l);
        let spot = camera.project(&(p[0] * w[0] + p[1] * w[1] + p[2] * w[2]));
        for axis in 0..2 {
            let at: f64 = (0..3).map(|k| l[k] * spots[k].at[axis]).sum();
            assert!((at - spot.at[axis]).abs() < 1e-9);
        }
        assert!(((0..3).map(|k| l[k] * spots[k].near).sum::<f64>() - spot.near).abs() < 1e-12);
    }

    #[test]
    fn the_derivative_is_that_of_the_pixel() {
        for projection in [Projection::Orthographic, Projection::Perspective] {
            let (camera, p) = (camera(35.0, 50.0, projection), Point::<3>::new(0.3, -0.6, 1.1));
            let d = camera.derivative(&p);
            for axis in 0..3 {
                let mut step = Point::<3>::zeros();
                step[axis] = 1e-5;
                let [a, b] = [camera.project(&(p + step)).at, camera.project(&(p - step)).at];
                for k in 0..2 {
                    assert!(
                        ((a[k] - b[k]) / 2e-5 - d[k][axis]).abs() < 1e-5 * camera.scale,
                        "{k} {axis}"
                    );
                }
            }
        }
    }
}
