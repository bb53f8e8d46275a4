//! Files for people and for other programs: VTU and PVD, CSV series, SVG charts, PNG pictures, films, the report page.
//!
//! Everything takes plain data, so that a run and a later `render` of its folder call the same functions. Files that
//! replace an older one are written beside it and renamed: a stop at any moment leaves the old or the new one.

mod chart;
mod colours;
mod field;
mod file;
mod film;
mod grey;
mod grid;
mod legend;
mod lettering;
mod markup;
mod numbers;
mod palette;
mod picture;
mod pvd;
mod raster;
mod report;
mod sampling;
mod segments;
mod series;
pub mod solid;
mod vtu;
mod vtu_read;

pub use chart::{Chart, Curve, Slope, Stroke};
pub use colours::Scale;
pub use field::FieldData;
pub use file::{read as read_file, read_text, write_file};
pub use film::{Film, write_film};
pub use grey::GreyImage;
pub use grid::{Cell, Grid};
pub use numbers::rounded;
pub use picture::{Arrows, Picture};
pub use pvd::{read_pvd, write_pvd};
pub use raster::Image;
pub use report::{Content, Figure, Listing, Number, Report, Section};
pub use segments::Pixels;
pub use series::{Series, Table, same_time};
pub use vtu::write_vtu;
pub use vtu_read::{Snapshot, Values, read_vtu};
