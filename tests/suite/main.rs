//! Fast tests of whole capabilities; unit tests live beside the code.

mod broken_meshes;
mod elements;
mod flow;
mod layers;
mod meshes;
mod reproducible;
mod scenes;
