//! Draws the image of `examples/active-contours`: four objects in two grey levels under noise, with
//! spots that are no objects, and the mask of the objects.
//!
//!     cargo run --release --example shapes -- examples/active-contours [NOISE]
//!
//! The same numbers come out everywhere: the noise is made by a congruential generator (Knuth's
//! MMIX) from a fixed seed.

use immersa::base::Result;
use immersa::levelset::{Circle, Ellipse, RoundedBox, Shape};
use immersa::mesh::Point;
use immersa::output::{GreyImage, write_file};
use std::path::PathBuf;

/// Pixels along each side.
pub const SIZE: usize = 128;
/// Grey levels of objects and background.
pub const LEVELS: [f64; 2] = [0.65, 0.35];
/// Standard deviation of the noise: half the difference of the levels.
pub const NOISE: f64 = 0.15;
/// Centres of spots of radius 2: bright ones on the background, dark ones on objects.
const SPOTS: [[f64; 2]; 9] = [
    [64.0, 66.0],
    [62.0, 112.0],
    [112.0, 66.0],
    [14.0, 64.0],
    [62.0, 14.0],
    [58.0, 50.0],
    [36.0, 92.0],
    [96.0, 97.0],
    [30.0, 34.0],
];
const SPOT: f64 = 2.0;

/// Whether a place lies in the disc, the ellipse, the square with round corners or the ring.
fn is_inside(x: &Point<2>) -> Result<bool> {
    let p = |x: f64, y: f64| Point::<2>::new(x, y);
    let ring = Circle::new(p(90.0, 38.0), 22.0)?
        .distance(x)
        .max(-Circle::new(p(90.0, 38.0), 11.0)?.distance(x));
    let objects = [
        Circle::new(p(36.0, 92.0), 17.0)?.distance(x),
        Ellipse::new(p(90.0, 94.0), p(24.0, 13.0), 25.0)?.distance(x),
        RoundedBox::new(p(34.0, 36.0), p(16.0, 16.0), 6.0, 15.0)?.distance(x),
        ring,
    ];
    Ok(objects.iter().any(|d| *d < 0.0))
}

/// Numbers of a normal distribution, by Box and Muller.
struct Normal(u64);

impl Normal {
    /// Between 0 and 1, 0 left out.
    fn uniform(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 11) as f64 + 1.0) / (1u64 << 53) as f64
    }
    fn next(&mut self) -> f64 {
        let (radius, turn) = ((-2.0 * self.uniform().ln()).sqrt(), self.uniform());
        radius * (std::f64::consts::TAU * turn).cos()
    }
}

/// The image under noise of this standard deviation, and the mask, white inside.
pub fn draw(noise: f64, seed: u64) -> Result<[GreyImage; 2]> {
    let mut normal = Normal(seed);
    let (mut image, mut mask) = (Vec::new(), Vec::new());
    for k in 0..SIZE * SIZE {
        let x = Point::<2>::new((k % SIZE) as f64 + 0.5, (SIZE - k / SIZE) as f64 - 0.5);
        let inside = is_inside(&x)?;
        let spot = SPOTS.iter().any(|s| (x - Point::<2>::from(*s)).norm() < SPOT);
        image.push(LEVELS[usize::from(inside == spot)] + noise * normal.next());
        mask.push(f64::from(u8::from(inside)));
    }
    Ok([GreyImage::new(SIZE, image)?, GreyImage::new(SIZE, mask)?])
}

/// The seed of the image that is kept.
pub const SEED: u64 = 1;

#[allow(dead_code, reason = "a test draws with the functions above")]
fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let folder =
        PathBuf::from(arguments.next().unwrap_or_else(|| "examples/active-contours".into()));
    let noise = arguments.next().and_then(|a| a.parse().ok()).unwrap_or(NOISE);
    let [image, mask] = draw(noise, SEED)?;
    write_file(&folder.join("shapes.png"), &image.png()?)?;
    write_file(&folder.join("shapes-mask.png"), &mask.png()?)
}
