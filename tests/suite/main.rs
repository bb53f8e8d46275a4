//! Fast tests of whole capabilities; unit tests live beside the code.

mod adaptive;
mod book;
mod broken_meshes;
mod case;
mod comparison;
mod convergence;
mod elements;
mod examples;
mod explain;
mod failures;
mod flow;
mod fluid;
mod krylov;
mod layers;
mod meshes;
mod passive;
mod precision;
mod program;
mod render;
mod reproducible;
mod run_folder;
mod runs;
mod scenes;
mod studies;
