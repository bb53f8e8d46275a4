//! Kinds of structures: one file a kind, with its keys, its construction, its words of the plan, its
//! columns and its charts. A further kind is a file here and a line in `KINDS`.

mod build;
mod drop;
mod laws;
mod level_set;
mod membrane;
mod round;

pub use drop::Drop;
pub use level_set::LevelSet;
pub use membrane::Membrane;

pub(super) use build::{Build, band_of};

use super::charts::Columns;
use super::keys::{Absent::Optional, Context, Item, Key, Keys, Kind, Writer, row};
use super::row::Row;
use super::schema::{Numerics, Shape, Tables};
use super::view::View;
use crate::base::{Error, Result, same};
use crate::output::Figure;
use crate::structure::Structure;
use std::fmt::Debug;

/// A kind of structure: a list of tables of the scene.
pub(super) struct Registered {
    /// Name of the list.
    pub list: &'static str,
    /// Keys of each of its tables.
    pub keys: &'static Keys,
    /// Meaning of the list, for the reference.
    pub doc: &'static str,
    /// Keys that a table must have beside its shape, in a scene of that many dimensions: an example.
    #[cfg(test)]
    pub example: fn(usize) -> &'static str,
    /// Reads one table.
    pub read: fn(&Item<'_>, &Numerics, &Context) -> Result<Box<dyn StructureKind>>,
}

impl Registered {
    /// The key of the list.
    pub const fn key(&self) -> Key {
        row(self.list, Kind::List(self.keys), "", Optional, self.doc)
    }
}

/// All kinds, in the order of their columns and files.
pub(super) static KINDS: &[Registered] = &[
    membrane::KIND,
    drop::KIND,
    level_set::KIND,
    #[cfg(test)]
    crate::scene::tests::spring::KIND,
];

/// Properties of a structure that the rest of a scene depends on.
#[derive(Clone, Debug, PartialEq)]
pub struct Traits {
    /// True if it acts on the flow or holds a fluid; else it is only carried.
    pub acts: bool,
    /// Slope of its level set at the start: the stretch.
    pub slope: f64,
    /// True if it pulls with the same tension whatever its strain.
    pub constant_tension: bool,
    /// Elastic modulus or tension, force per length: scale of its waves.
    pub modulus: f64,
    /// True if it pulls at all, so that other bands must keep clear of its own.
    pub pulls: bool,
    /// True if its force acts on the interface itself and not over a band.
    pub on_interface: bool,
    /// Mass per area at rest.
    pub mass: f64,
    /// Density and viscosity of its own inside, as far as it names them.
    pub own_fluid: [Option<f64>; 2],
    /// True if it resists shear, which takes the backward characteristics.
    pub resists_shear: bool,
    /// Key that cannot be used where particles pass periodic sides, and its meaning.
    pub not_periodic: Option<(&'static str, &'static str)>,
    /// True if its form at rest is round, so that its mean stretch is known from its size.
    pub round_at_rest: bool,
    /// True for a fluid with surface tension.
    pub is_drop: bool,
}

impl Default for Traits {
    fn default() -> Traits {
        Traits {
            acts: true,
            slope: 1.0,
            constant_tension: false,
            modulus: 0.0,
            pulls: false,
            on_interface: false,
            mass: 0.0,
            own_fluid: [None; 2],
            resists_shear: false,
            not_periodic: None,
            round_at_rest: false,
            is_drop: false,
        }
    }
}

/// Construction and measures of a structure in `D` dimensions.
pub(super) trait KindIn<const D: usize> {
    /// Builds the structure.
    ///
    /// # Errors
    /// Values that do not fit the mesh, with their place.
    fn build(&self, of: &mut Build<'_, '_, D>) -> Result<Box<dyn Structure<D>>>;
    /// Measures the structure, number `k`, into columns that begin with its name and a dot.
    ///
    /// # Errors
    /// A level set that is not finite.
    fn measure(&self, view: &View<'_, D>, k: usize, row: &mut Row) -> Result<()>;
}

/// One structure of a scene.
#[allow(private_bounds, reason = "the traits of both dimensions are an implementation detail")]
pub trait StructureKind: KindIn<2> + KindIn<3> + Debug + Send + Sync {
    /// Name in results; unique in the scene.
    fn name(&self) -> &str;
    /// Name of the list it stands in.
    fn list(&self) -> &'static str;
    /// Form at time 0, whose signed distance its level set is made of; `None` for one without.
    fn shape(&self) -> Option<&Shape>;
    /// Properties that the rest of the scene depends on.
    fn traits(&self) -> Traits;
    /// Its lines of the plan, under "Solved".
    fn words(&self) -> Vec<String>;
    /// Its line of the plan under "Numerics", if there is one.
    fn numerics(&self, _tables: &Tables) -> Option<String> {
        None
    }
    /// Columns of half-chords that the scene asks for, after its name and a dot.
    fn chords(&self) -> Vec<String> {
        Vec::new()
    }
    /// Its charts.
    fn charts(&self, of: &Columns<'_>) -> Vec<Figure>;
    /// Writes its table.
    fn write(&self, out: &mut Writer);
    /// A copy.
    fn boxed(&self) -> Box<dyn StructureKind>;
    /// This value, for those that know its type.
    fn as_any(&self) -> &dyn std::any::Any;
}

impl Clone for Box<dyn StructureKind> {
    fn clone(&self) -> Self {
        (**self).boxed()
    }
}

impl PartialEq for Box<dyn StructureKind> {
    /// Structures are equal when they are written alike.
    fn eq(&self, other: &Self) -> bool {
        let written = |s: &dyn StructureKind| {
            let mut out = Writer::default();
            s.write(&mut out);
            out.text
        };
        written(&**self) == written(&**other)
    }
}

/// Gives access to a kind in `D` dimensions.
type Up<const D: usize> = for<'a> fn(&'a dyn StructureKind) -> &'a dyn KindIn<D>;

/// A kind in `D` dimensions, 2 or 3.
///
/// # Errors
/// Internal, in another number of dimensions.
pub(super) fn kind_in<const D: usize>(kind: &dyn StructureKind) -> Result<&dyn KindIn<D>> {
    let (plane, solid): (Up<2>, Up<3>) = (|k| k, |k| k);
    let up: Option<Up<D>> = same(plane).or_else(|| same(solid));
    up.map(|up| up(kind)).ok_or_else(|| Error::internal("a scene of neither 2 nor 3 dimensions"))
}
