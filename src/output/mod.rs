//! Files for readers and for other programs: VTU and PVD, CSV series, SVG charts, PNG pictures,
//! films, tables and pages.
//!
//! All functions take plain data, so that a run and a later `render` of its folder call the same
//! ones. A file that replaces an older one is written beside it and renamed: a stop at any moment
//! leaves the old or the new one.

mod appended;
mod chart;
mod clip;
mod colours;
mod csv;
mod field;
mod figure;
mod file;
mod film;
mod grey;
mod legend;
mod lettering;
mod markup;
mod numbers;
mod page;
mod palette;
mod picture;
mod pvd;
mod raster;
mod sampling;
mod segments;
mod series;
mod series_writer;
pub mod solid;
mod table;
mod vtkhdf;
mod vtp;
mod vtu;
mod vtu_read;

pub use chart::{Chart, Curve, OF_CHART, Slope, Stroke};
pub use colours::{ColourMap, Scale};
pub use field::FieldData;
pub use figure::{Content, Figure};
pub use file::{cannot_write, read as read_file, read_text, write_durably, write_file};
pub use film::{Film, write_film};
pub use grey::GreyImage;
pub use numbers::{per_cent, rounded};
pub use page::{KeyNumber, Page};
pub use picture::{Arrows, Picture};
pub use pvd::{read_pvd, write_pvd};
pub use raster::Image;
pub use segments::Pixels;
pub use series::{Series, same_time};
pub use series_writer::SeriesWriter;
pub use table::{Cell, Column, Notation, Table};
pub use vtkhdf::write_vtkhdf;
pub use vtp::{Mark, write_vtp};
pub use vtu::write_vtu;
pub use vtu_read::{Snapshot, Values, read_vtu};
