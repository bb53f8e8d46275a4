//! Kinds of structures. Each has one file with its keys, its construction, its text in the plan,
//! its columns and its charts. A new kind is a new file and one line in `KINDS`.

mod build;
mod drop;
mod laws;
mod level_set;
mod membrane;
mod motion;
mod round;
mod vesicle;

pub use drop::Drop;
pub use level_set::LevelSet;
pub use membrane::Membrane;
pub use vesicle::Vesicle;

pub(super) use build::{Build, band_of};

use super::charts::{Columns, Plot};
use super::keys::{Absent::Optional, Context, Item, Key, Keys, Kind, Writer, row};
use super::row::Row;
use super::schema::{Numerics, Shape, Tables};
use super::view::View;
use crate::base::{Error, Result, same};
use crate::structure::Structure;
use std::fmt::Debug;

/// A kind of structure: a list of tables of the scene.
pub(super) struct Registered {
    /// Name of the list.
    pub list: &'static str,
    /// Keys of each of its tables.
    pub keys: &'static Keys,
    /// Description of the list, for the reference.
    pub doc: &'static str,
    /// Required keys of a table beside its shape, for a scene of the given dimension; an example.
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
    vesicle::KIND,
    #[cfg(test)]
    crate::scene::tests::spring::KIND,
];

/// Properties of a structure that the rest of a scene depends on.
#[derive(Clone, Debug, PartialEq)]
pub struct Traits {
    /// True if it acts on the flow or encloses a fluid; otherwise it is passive.
    pub acts: bool,
    /// Initial slope of its level set: the stretch.
    pub slope: f64,
    /// True if its tension does not depend on the strain.
    pub constant_tension: bool,
    /// Elastic modulus or tension, force per length: the scale of its waves.
    pub modulus: f64,
    /// True if it exerts a force, so that other bands must not overlap its own.
    pub pulls: bool,
    /// True if its force acts on the interface itself and not over a band.
    pub on_interface: bool,
    /// True if its stretch is carried along the interface.
    pub carries_stretch: bool,
    /// True if unknowns of its own keep its size, so that no error of the divergence changes it.
    pub keeps_size: bool,
    /// True if it resists compression, and being without bending stiffness then wrinkles.
    pub wrinkles: bool,
    /// Mass per area at rest.
    pub mass: f64,
    /// Density and viscosity of its inside fluid, if specified by the structure.
    pub own_fluid: [Option<f64>; 2],
    /// True if it resists shear, which requires the backward characteristics.
    pub resists_shear: bool,
    /// True if its interface carries its strain.
    pub carries_strain: bool,
    /// Key that is not available where particles cross periodic sides, and its meaning.
    pub not_periodic: Option<(&'static str, &'static str)>,
    /// True if it is round at rest, so that its mean stretch follows from its size.
    pub round_at_rest: bool,
    /// True if it is elastic and the slope of its level set is its stretch.
    pub stretches: bool,
    /// True if its size at rest is that at the start over its slope there.
    pub has_size_at_rest: bool,
}

impl Traits {
    /// True if the slope of its level set is its stretch, which redistancing would destroy.
    pub fn slope_is_stretch(&self) -> bool {
        self.stretches && !self.carries_stretch && !self.constant_tension
    }
    /// Its inside fluid as the end of a phrase; empty if it is that outside.
    pub fn own_fluid_in_words(&self) -> String {
        let own = ["density", "viscosity"].iter().zip(self.own_fluid);
        own.filter_map(|(what, value)| Some(format!(", {what} {} inside", value?))).collect()
    }
    /// True if its level set is kept near a distance by default.
    pub fn keeps_distance(&self) -> bool {
        (self.on_interface || self.carries_stretch) && self.mass == 0.0
    }
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
            carries_stretch: false,
            keeps_size: false,
            wrinkles: false,
            mass: 0.0,
            own_fluid: [None; 2],
            resists_shear: false,
            carries_strain: false,
            not_periodic: None,
            round_at_rest: false,
            stretches: false,
            has_size_at_rest: false,
        }
    }
}

/// What a series says of a run as a whole.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Its name in the summary, and its title in the report.
    pub names: [&'static str; 2],
    /// A word or a number.
    pub value: FindingValue,
    /// A note in the report.
    pub note: String,
}

/// The value of a finding.
#[derive(Clone, Debug, PartialEq)]
pub enum FindingValue {
    /// A word.
    Word(&'static str),
    /// A number.
    Number(f64),
}

/// Construction and measurements of a structure in `D` dimensions.
pub(super) trait KindIn<const D: usize> {
    /// Builds the structure.
    ///
    /// # Errors
    /// Values that do not fit the mesh, with their position.
    fn build(&self, of: &mut Build<'_, '_, D>) -> Result<Box<dyn Structure<D>>>;
    /// Measures structure number `k`, in columns that begin with its name and a dot.
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
    /// Name of its list in the scene.
    fn list(&self) -> &'static str;
    /// Initial form, from whose signed distance the level set is computed; `None` without one.
    fn shape(&self) -> Option<&Shape>;
    /// Properties that the rest of the scene depends on.
    fn traits(&self) -> Traits;
    /// Its lines in the plan, under "Solved".
    fn words(&self) -> Vec<String>;
    /// Its line in the plan under "Numerics", if there is one.
    fn numerics(&self, _tables: &Tables) -> Option<String> {
        None
    }
    /// Columns of requested half-chords, after its name and a dot.
    fn chords(&self) -> Vec<String> {
        Vec::new()
    }
    /// What its series says of the run as a whole, for the summary and the report.
    fn findings(&self, _of: &Columns<'_>) -> Vec<Finding> {
        Vec::new()
    }
    /// Its charts.
    fn charts(&self, of: &Columns<'_>) -> Vec<Plot>;
    /// Writes its table.
    fn write(&self, out: &mut Writer);
    /// A copy.
    fn boxed(&self) -> Box<dyn StructureKind>;
    /// This value, for downcasting.
    fn as_any(&self) -> &dyn std::any::Any;
}

impl Clone for Box<dyn StructureKind> {
    fn clone(&self) -> Self {
        (**self).boxed()
    }
}

impl PartialEq for Box<dyn StructureKind> {
    /// Structures are equal if their TOML texts are equal.
    fn eq(&self, other: &Self) -> bool {
        let written = |s: &dyn StructureKind| {
            let mut out = Writer::default();
            s.write(&mut out);
            out.text
        };
        written(&**self) == written(&**other)
    }
}

/// Upcast of a kind to `D` dimensions.
type Up<const D: usize> = for<'a> fn(&'a dyn StructureKind) -> &'a dyn KindIn<D>;

/// A kind in `D` dimensions, 2 or 3.
///
/// # Errors
/// Internal, for another dimension.
pub(super) fn kind_in<const D: usize>(kind: &dyn StructureKind) -> Result<&dyn KindIn<D>> {
    let (plane, solid): (Up<2>, Up<3>) = (|k| k, |k| k);
    let up: Option<Up<D>> = same(plane).or_else(|| same(solid));
    up.map(|up| up(kind)).ok_or_else(|| Error::internal("a scene of neither 2 nor 3 dimensions"))
}
