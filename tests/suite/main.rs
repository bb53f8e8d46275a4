//! Fast tests of whole capabilities; unit tests live beside the code.

mod broken_meshes;
mod case;
mod elements;
mod examples;
mod explain;
mod failures;
mod flow;
mod fluid;
mod layers;
mod meshes;
mod passive;
mod program;
mod render;
mod reproducible;
mod run_folder;
mod runs;
mod scenes;
