//! Structures immersed in a flow: level sets and P2-P1 finite elements on unstructured meshes.
//!
//! The equations are those of G.-H. Cottet, E. Maitre and T. Milcent, *Level Set Methods for Fluid-Structure
//! Interaction* (Springer, 2022), called "the book" in these pages; equation numbers such as (3.16) are the book's.
//!
//! Signs: `phi < 0` inside, the normal `grad phi / |grad phi|` points outward, a stress enters as `-(sigma, grad v)`
//! on the right-hand side. Units are whatever consistent system the scene uses.

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
