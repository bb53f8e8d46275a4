//! Fast tests of whole capabilities; unit tests live beside the code.

mod flow;
mod layers;
