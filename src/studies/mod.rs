//! Studies: the same scene run many times, and the results of all runs on one page.
//!
//! A study makes [`Trial`]s, each the scene with some values set; a [`Campaign`] runs them into
//! folders of their own, once: the same study started again continues. A trial that blows up is a
//! result, not the end of the study. The result is a [`Page`](crate::output::Page) of tables,
//! charts and sentences, which [`files`] writes for readers and for other programs.

mod axis;
mod campaign;
mod compare;
mod compare_meshes;
pub mod convergence;
pub mod files;
mod freefem;
mod front;
mod method;
mod phases;
pub mod precision;
pub mod stability;
mod trial;
mod twin;

pub use axis::{Axis, Choice, assignments, check_distinct, combinations, in_words};
pub use campaign::{Campaign, Listener};
pub use compare::{Bound, Comparison, compare};
pub use compare_meshes::compare_meshes;
pub use freefem::{About, Case, Reading};
pub use method::Method;
pub use phases::Phases;
pub use trial::{End, Outcome, Trial};
pub use twin::{Loop, Twin};

/// A fraction in per cent, with two digits.
fn per_cent(v: f64) -> String {
    format!("{} %", crate::output::rounded(100.0 * v, 2))
}
