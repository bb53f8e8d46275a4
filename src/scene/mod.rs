//! Scenes.
pub mod expression;
pub(crate) mod nearest;
