//! `[mesh.adapt]`: mesh adaptation to the interfaces and the fields.

use crate::base::Result;
use crate::scene::keys::{
    Context, Count, Form, Item, Kind, Many, Opt, Positive, Set, Table, Tabled, Writer, kinds, last,
    table, words,
};
use crate::sim::Transfer;

table! {
    /// A mesh that follows the interfaces and, if wanted, fields. The mesh of `[mesh]` gives the
    /// domain and its names.
    Adapt {
        /// Time between two looks at the mesh; it is made anew where it no longer fits the
        /// interfaces, and always where `fields` are given.
        every: Option<f64> [Opt<Positive>, "s", Derived("at the start alone")],
        /// Length of the edges at the interfaces. Needed where `numerics.thickness` is not given.
        edge: Option<f64> [Opt<Positive>, "m", Derived("thickness / 3")],
        /// Length of the edges along the interfaces: two or three times `edge` saves as many
        /// unknowns where little changes along a membrane.
        along: Option<f64> [Opt<Positive>, "m", Derived("edge")],
        /// Distance from the interfaces up to which the edges are that short.
        width: Option<f64> [Opt<Positive>, "m", Derived("thickness + edge")],
        /// Fields whose second derivatives shape the mesh too (anisotropic metric).
        fields: Vec<AdaptField> [Many<Set<Fields>>],
        /// Largest error of linear interpolation of these fields, over the largest difference of
        /// their values.
        error: f64 [Positive, Default(0.01)],
        /// About how many points the fields may ask for; takes the place of `error`.
        vertices: Option<usize> [Opt<Count<10, 2_000_000>>],
        /// Shortest edge that the fields may ask for.
        h_min: Option<f64> [Opt<Positive>, "m", Derived("edge / 4")],
        /// Longest edge.
        h_max: Option<f64> [Opt<Positive>, "m", Derived("the longest edge of the mesh as given")],
        /// Largest ratio of the lengths of neighbouring edges.
        gradation: f64 [Gradation, Default(1.5)],
        /// Largest ratio of the lengths that the fields may ask for in two directions.
        anisotropy: f64 [Anisotropy, Default(20)],
        /// How fields are brought to a new mesh: by their values at its nodes, or by the L2
        /// projection over the common refinement of both meshes, which conserves their integrals.
        transfer: Transfer [Transfers, Default("interpolation")],
    } check Adapt::check; hide Adapt::hides;
}

/// A field that a mesh can be adapted to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AdaptField {
    /// Both components of the velocity.
    Velocity,
    /// The pressure.
    Pressure,
    /// All level sets.
    LevelSet,
}

words! {
    Fields: AdaptField {
        "velocity" = AdaptField::Velocity, "pressure" = AdaptField::Pressure, "level_set" = AdaptField::LevelSet,
    } twice "the field is named twice", "name every field once"
}
words! {
    Transfers: Transfer {
        "interpolation" = Transfer::Interpolation, "projection" = Transfer::Projection,
    }
}
kinds! {
    /// A ratio of lengths that differ.
    Gradation: f64 = Kind::Value("number > 1", Form::above(1.0)), |i, _| ratio(i, "above 1", |v| v > 1.0);
    /// A ratio of lengths that may be equal.
    Anisotropy: f64 = Kind::Value("number >= 1", Form::least(1.0)), |i, _| ratio(i, "at least 1", |v| v >= 1.0);
}

impl Adapt {
    /// Checks that the scene has the interfaces or fields for the adaptation.
    pub(in crate::scene) fn check_use(
        &self,
        item: &Item,
        has_interfaces: bool,
        is_prescribed: bool,
    ) -> Result<()> {
        let table = item.open_table()?;
        if let (Some(item), true) =
            (table.get("fields"), is_prescribed && self.fields.contains(&AdaptField::Pressure))
        {
            return Err(item
                .key_error("the velocity is prescribed, and there is no pressure to adapt to")
                .remedy("take \"velocity\" or \"level_set\""));
        }
        if let (Some(item), None) = (table.get("fields"), self.every) {
            return Err(item
                .key_error(
                    "fields shape the mesh when it is looked at, and `every` does not say when",
                )
                .remedy("add every = 0.1, or leave fields out"));
        }
        if has_interfaces {
            return Ok(());
        }
        if let Some(item) = ["edge", "along", "width"].iter().find_map(|key| table.get(key)) {
            return Err(item
                .key_error(format!("`{}` is for interfaces, and there is none", item.key))
                .remedy(
                    "leave it out; fields = [\"velocity\"] with h_min and h_max shape the mesh",
                ));
        }
        if self.fields.is_empty() {
            return Err(item
                .key_error("there is neither an interface nor a field for the mesh to follow")
                .remedy("add fields = [\"velocity\"] and every = 0.1, or leave mesh.adapt out"));
        }
        Ok(())
    }

    fn check(&mut self, table: &Table<'_>, _: &Context) -> Result<()> {
        if let (Some(item), Some(_)) = (table.get("error"), self.vertices) {
            return Err(item
                .key_error("`error` and `vertices` both say how fine the mesh is")
                .remedy("keep one of them"));
        }
        if self.fields.is_empty()
            && let Some(item) =
                ["error", "vertices", "h_min", "anisotropy"].iter().find_map(|key| table.get(key))
        {
            return Err(item
                .key_error(format!(
                    "`{}` is for fields that shape the mesh, and none is given",
                    item.key
                ))
                .remedy("add fields = [\"velocity\"], or leave it out"));
        }
        let lengths = [("edge", self.edge), ("along", self.along), ("h_min", self.h_min)];
        for (key, length) in lengths.into_iter().filter_map(|(key, l)| Some((key, l?))) {
            if let (Some(longest), Some(item)) =
                (self.h_max.filter(|longest| *longest < length), table.get("h_max"))
            {
                return Err(item
                    .error(format!("`h_max` = {longest} is below `{key}` = {length}"))
                    .remedy(format!("give h_max >= {length}")));
            }
        }
        match (self.along, self.edge, table.get("along")) {
            (Some(along), Some(edge), Some(item)) if along < edge => Err(item
                .error(format!(
                    "edges along the interfaces must not be shorter than those across, {edge}"
                ))
                .remedy(format!("give along >= {edge}"))),
            _ => Ok(()),
        }
    }

    fn hides(&self, key: &str) -> bool {
        let of_fields =
            ["vertices", "error", "anisotropy"].contains(&key) && self.fields.is_empty();
        of_fields || key == "error" && self.vertices.is_some()
    }

    /// Writes the table `[mesh.adapt]`.
    pub(in crate::scene) fn write(&self, out: &mut Writer) {
        let order = ["fields", "vertices", "error", "anisotropy", "gradation", "transfer"];
        out.header("[mesh.adapt]");
        out.entries(last(self.entries(), &order));
    }
}

/// A ratio that satisfies `large_enough`.
fn ratio(item: &Item, words: &str, large_enough: impl Fn(f64) -> bool) -> Result<f64> {
    let v = item.number()?;
    if large_enough(v) {
        return Ok(v);
    }
    Err(item
        .error(format!("`{}` must be {words}", item.key))
        .remedy(format!("give a ratio {words}, such as 1.5")))
}
