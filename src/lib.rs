//! Structures immersed in a flow: level sets and P2-P1 finite elements on unstructured meshes.
//!
//! The equations are those of G.-H. Cottet, E. Maitre and T. Milcent, *Level Set Methods for
//! Fluid-Structure Interaction* (Springer, 2022), called "the book" in these pages; equation
//! numbers such as (3.16) are the book's. "The paper" is T. Milcent and E. Maitre, *Eulerian model
//! of immersed elastic surfaces with full membrane elasticity* (hal-01078869).
//!
//! # Example
//!
//! A stretched elliptical membrane relaxes in a fluid at rest. Its elastic energy decreases, its
//! area is conserved.
//!
//! ```
//! use immersa::elastic::{AreaLaw, Membrane};
//! use immersa::fem::{Element, Space};
//! use immersa::levelset::{Ellipse, Interface, signed_distance};
//! use immersa::mesh::{Diagonals, Point, rectangle};
//! use immersa::sim::{Fluid, Simulation, SimulationSettings};
//! use immersa::structure::{Immersed, ImmersedInterface};
//! use std::sync::Arc;
//!
//! # fn main() -> immersa::base::Result<()> {
//! let mesh = Arc::new(rectangle([0.0, 0.0], [2.0, 2.0], [16, 16], Diagonals::UnionJack)?);
//! let space = Space::new(&mesh, Element::P2);
//! let ellipse = Ellipse::new(Point::<2>::new(1.0, 1.0), Point::<2>::new(0.75, 0.5), 0.0)?;
//! let stretch = 1.2625; // |grad phi| at the interface, (3.11)
//! let phi = signed_distance(&space, &ellipse).iter().map(|d| stretch * d).collect();
//!
//! let thickness = 0.2; // half-width of the band
//! let law = AreaLaw::Linear { modulus: 1.0 }; // (3.13)
//! let interface = ImmersedInterface::new("membrane", phi, thickness).stretched(stretch);
//! let membrane = Immersed::boxed(interface, Membrane::new(law, thickness));
//! let fluid = Fluid { density: 1.0, viscosity: 0.05 };
//! let settings = SimulationSettings { grad_div: 5.0, ..SimulationSettings::new(0.02, fluid, vec![]) };
//! let mut sim = Simulation::new(&mesh, settings, vec![membrane], |_| Point::<2>::zeros())?;
//!
//! let area = |sim: &Simulation<2>| {
//!     let interface = Interface::cut(sim.space(), sim.level_set(0).into_owned())?;
//!     Ok::<f64, immersa::base::Error>(interface.measures().map_or(0.0, |m| m.enclosed))
//! };
//! let (before, energy) = (area(&sim)?, sim.state().energies.elastic);
//! for _ in 0..5 {
//!     sim.step()?;
//! }
//! println!("area {:.4}, elastic energy {:.4}", area(&sim)?, sim.state().energies.elastic);
//! assert!(sim.state().energies.elastic < energy);
//! assert!((area(&sim)? / before - 1.0).abs() < 1e-3);
//! # Ok(())
//! # }
//! ```
//!
//! # Manual
//!
//! The user guide is the folder `book` of the sources and of the package: a tutorial, the methods
//! with their formulas, and a reference of all keys of a scene. `mdbook build book --open` makes
//! pages of it; its Markdown can be read as it is, from `book/src/SUMMARY.md`. `immersa reference`
//! prints the keys, [`scene::reference::reference`] returns them.
//!
//! # Modules
//!
//! [`mesh`] and [`linalg`] are independent of each other; [`fem`] uses both. [`transport`] moves
//! fields along characteristics, [`levelset`] describes interfaces, [`flow`] solves the
//! Navier-Stokes equations. A [`structure`] acts on the flow through [momentum
//! terms](flow::term::MomentumTerm) and [blocks of unknowns](flow::block::Block); [`elastic`] holds
//! the constitutive laws. [`sim`] couples them in time. [`scene`] reads a problem from a TOML file,
//! [`output`] writes results, [`studies`] compares runs, [`cli`] is the program.
//!
//! # Conventions
//!
//! - `phi < 0` inside; the normal `grad phi / |grad phi|` points outward; the curvature `div n` is
//!   positive on a sphere.
//! - A stress enters as `-(sigma, grad v)` on the right-hand side.
//! - Units are those of any consistent system.
//! - `D` is the dimension, 2 or 3. Points are `nalgebra` vectors, [`mesh::Point`].
//! - Results are bit-identical for any number of threads.
//! - Errors are values, [`base::Error`]; the library prints nothing.

pub mod base;
pub mod cli;
pub mod elastic;
pub mod fem;
pub mod flow;
pub mod levelset;
pub mod linalg;
pub mod mesh;
pub mod output;
pub mod scene;
pub mod sim;
pub mod structure;
pub mod studies;
pub mod transport;
