//! Shading: two lamps that move with the viewer, a sky, and a gloss.

use super::camera::Camera;
use nalgebra::SVector;

/// The lamps of a picture.
pub(super) struct Lights {
    /// Directions to the lamps, and how bright they are.
    lamps: [(SVector<f64, 3>, f64); 2],
    /// The direction of the sky.
    up: SVector<f64, 3>,
}

/// Light from everywhere: at least, and from the sky in addition.
const AMBIENT: [f64; 2] = [0.40, 0.12];
/// Strength and exponent of the gloss.
const GLOSS: (f64, i32) = (0.16, 36);

impl Lights {
    /// The bright lamp stands at the upper left before the picture, the weak one at the right.
    pub fn new(camera: &Camera) -> Lights {
        let [right, up, toward] = camera.axes;
        let direction = |r: f64, u: f64, t: f64| (right * r + up * u + toward * t).normalize();
        Lights {
            lamps: [(direction(-0.55, 0.65, 0.62), 0.48), (direction(0.85, -0.05, 0.45), 0.14)],
            up,
        }
    }
    /// The colour of a surface of colour `rgb` whose normal is `n`, seen from the direction `eye`;
    /// both are unit vectors, and the normal points to the side that is seen.
    pub fn shade(&self, rgb: [f32; 3], n: &SVector<f64, 3>, eye: &SVector<f64, 3>) -> [f32; 3] {
        let mut light = AMBIENT[0] + AMBIENT[1] * (0.5 + 0.5 * n.dot(&self.up));
        let mut gloss = 0.0;
        for (direction, strength) in &self.lamps {
            light += strength * n.dot(direction).max(0.0);
            let half = (direction + eye).normalize();
            gloss += strength * n.dot(&half).max(0.0).powi(GLOSS.1);
        }
        let gloss = (GLOSS.0 * gloss / self.lamps[0].1) as f32;
        rgb.map(|c| {
            let lit = (c * light as f32).min(255.0);
            lit + (255.0 - lit) * gloss
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::camera::View;
    use super::*;
    use crate::mesh::Point;

    #[test]
    fn what_faces_the_bright_lamp_is_brightest_and_nothing_is_black() {
        let camera = Camera::new(&View::default(), [Point::<3>::zeros(), Point::<3>::repeat(1.0)]);
        let (lights, [right, up, toward]) = (Lights::new(&camera), camera.axes);
        let seen = |n: SVector<f64, 3>| lights.shade([160.0; 3], &n.normalize(), &toward)[0];
        let (bright, dark) = (seen(toward + up - right), seen(right - up + toward * 0.1));
        assert!(bright > seen(toward) && seen(toward) > dark && dark > 60.0, "{bright} {dark}");
        assert!(seen(lights.lamps[0].0) <= 255.0);
    }
}
