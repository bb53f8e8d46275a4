//! Fast tests of whole capabilities; unit tests live beside the code.

mod broken_meshes;
mod flow;
mod layers;
mod meshes;
mod render;
mod run_folder;
mod scenes;
