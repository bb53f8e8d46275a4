//! `[mesh.adapt]`: a mesh that follows the interfaces and the fields.

use crate::base::Result;
use crate::scene::keys::{Absent::*, Keys, Kind::*, row, words};
use crate::scene::keys::{Item, Table};
use crate::scene::keys::{Writer, list, name, number};
use crate::sim::Transfer;

/// How a mesh is adapted.
#[derive(Clone, Debug, PartialEq)]
pub struct Adapt {
    /// Time between two looks at the mesh; `None`: it is adapted at the start alone.
    pub every: Option<f64>,
    /// Length of the edges at the interfaces.
    pub edge: Option<f64>,
    /// Their length along the interfaces, if that differs.
    pub along: Option<f64>,
    /// Distance from the interfaces up to which edges are that short.
    pub width: Option<f64>,
    /// Fields whose interpolation error shapes the mesh.
    pub fields: Vec<AdaptField>,
    /// Largest interpolation error of these fields, over their largest difference.
    pub error: f64,
    /// Number of points that the fields may ask for, in place of the error.
    pub vertices: Option<usize>,
    /// Shortest edge that the fields may ask for.
    pub h_min: Option<f64>,
    /// Longest edge.
    pub h_max: Option<f64>,
    /// Largest ratio of the lengths of neighbouring edges.
    pub gradation: f64,
    /// Largest ratio of the longest to the shortest edge of a triangle.
    pub anisotropy: f64,
    /// How fields are brought to a new mesh.
    pub transfer: Transfer,
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

const FIELDS: [(&str, AdaptField); 3] =
    [("velocity", AdaptField::Velocity), ("pressure", AdaptField::Pressure), ("level_set", AdaptField::LevelSet)];
const TRANSFERS: [(&str, Transfer); 2] =
    [("interpolation", Transfer::Interpolation), ("projection", Transfer::Projection)];
const TRANSFER_WORDS: [&str; 2] = words(&TRANSFERS);

/// Defaults, as they are written.
const ERROR: &str = "0.01";
const GRADATION: &str = "1.5";
const ANISOTROPY: &str = "20";
const DEFAULT_ERROR: f64 = 0.01;
const DEFAULT_GRADATION: f64 = 1.5;
const DEFAULT_ANISOTROPY: f64 = 20.0;
/// More points exceed any memory.
const MOST_VERTICES: usize = 2_000_000;

pub(in crate::scene) static KEYS: Keys = Keys {
    about: "A mesh that follows the interfaces and, if wanted, fields. The mesh of `[mesh]` gives the domain and its names.",
    keys: &[
        row(
            "every",
            Value("number > 0"),
            "s",
            Derived("at the start alone"),
            "Time between two looks at the mesh; it is made anew where it no longer fits the interfaces, and always where `fields` are given.",
        ),
        row(
            "edge",
            Value("number > 0"),
            "m",
            Derived("thickness / 3"),
            "Length of the edges at the interfaces. Needed where `numerics.thickness` is not given.",
        ),
        row(
            "along",
            Value("number > 0"),
            "m",
            Derived("edge"),
            "Length of the edges along the interfaces: two or three times `edge` saves as many unknowns where little changes along a membrane.",
        ),
        row(
            "width",
            Value("number > 0"),
            "m",
            Derived("thickness + edge"),
            "Distance from the interfaces up to which the edges are that short.",
        ),
        row(
            "fields",
            Value("list of \"velocity\", \"pressure\", \"level_set\""),
            "",
            Optional,
            "Fields whose second derivatives shape the mesh too (anisotropic metric).",
        ),
        row(
            "error",
            Value("number > 0"),
            "",
            Default(ERROR),
            "Largest error of linear interpolation of these fields, over the largest difference of their values.",
        ),
        row(
            "vertices",
            Value("whole number from 10 to 2000000"),
            "",
            Optional,
            "About how many points the fields may ask for; takes the place of `error`.",
        ),
        row("h_min", Value("number > 0"), "m", Derived("edge / 4"), "Shortest edge that the fields may ask for."),
        row("h_max", Value("number > 0"), "m", Derived("the longest edge of the mesh as given"), "Longest edge."),
        row(
            "gradation",
            Value("number > 1"),
            "",
            Default(GRADATION),
            "Largest ratio of the lengths of neighbouring edges.",
        ),
        row(
            "anisotropy",
            Value("number >= 1"),
            "",
            Default(ANISOTROPY),
            "Largest ratio of the lengths that the fields may ask for in two directions.",
        ),
        row(
            "transfer",
            Choice(&TRANSFER_WORDS),
            "",
            Default("\"interpolation\""),
            "How fields are brought to a new mesh: by their values at its nodes, or by the L2 projection over the common refinement of \
             both meshes, which conserves their integrals.",
        ),
    ],
};

impl Adapt {
    /// Reads `[mesh.adapt]`.
    pub(in crate::scene) fn read(item: &Item) -> Result<Adapt> {
        let table = item.table(&KEYS)?;
        let positive = |key: &str| table.optional(key, Item::positive);
        let adapt = Adapt {
            every: positive("every")?,
            edge: positive("edge")?,
            along: positive("along")?,
            width: positive("width")?,
            fields: table.optional("fields", fields)?.unwrap_or_default(),
            error: positive("error")?.unwrap_or(DEFAULT_ERROR),
            vertices: table.optional("vertices", |i| i.count(10, MOST_VERTICES))?,
            h_min: positive("h_min")?,
            h_max: positive("h_max")?,
            gradation: table.optional("gradation", |i| ratio(i, "above 1", |v| v > 1.0))?.unwrap_or(DEFAULT_GRADATION),
            anisotropy: table
                .optional("anisotropy", |i| ratio(i, "at least 1", |v| v >= 1.0))?
                .unwrap_or(DEFAULT_ANISOTROPY),
            transfer: table.optional("transfer", |i| i.choice(&TRANSFERS))?.unwrap_or(Transfer::Interpolation),
        };
        adapt.check(&table)?;
        Ok(adapt)
    }

    /// Checks that the scene has what the mesh is to follow.
    pub(in crate::scene) fn check_use(&self, item: &Item, has_interfaces: bool, is_prescribed: bool) -> Result<()> {
        let table = item.open_table()?;
        if let (Some(item), true) = (table.get("fields"), is_prescribed && self.fields.contains(&AdaptField::Pressure))
        {
            return Err(item
                .key_error("the velocity is prescribed, and there is no pressure to adapt to")
                .remedy("take \"velocity\" or \"level_set\""));
        }
        if let (Some(item), None) = (table.get("fields"), self.every) {
            return Err(item
                .key_error("fields shape the mesh when it is looked at, and `every` does not say when")
                .remedy("add every = 0.1, or leave fields out"));
        }
        if has_interfaces {
            return Ok(());
        }
        if let Some(item) = ["edge", "along", "width"].iter().find_map(|key| table.get(key)) {
            return Err(item
                .key_error(format!("`{}` is for interfaces, and there is none", item.key))
                .remedy("leave it out; fields = [\"velocity\"] with h_min and h_max shape the mesh"));
        }
        if self.fields.is_empty() {
            return Err(item
                .key_error("there is neither an interface nor a field for the mesh to follow")
                .remedy("add fields = [\"velocity\"] and every = 0.1, or leave mesh.adapt out"));
        }
        Ok(())
    }

    fn check(&self, table: &Table<'_>) -> Result<()> {
        if let (Some(item), Some(_)) = (table.get("error"), self.vertices) {
            return Err(item
                .key_error("`error` and `vertices` both say how fine the mesh is")
                .remedy("keep one of them"));
        }
        if self.fields.is_empty()
            && let Some(item) = ["error", "vertices", "h_min", "anisotropy"].iter().find_map(|key| table.get(key))
        {
            return Err(item
                .key_error(format!("`{}` is for fields that shape the mesh, and none is given", item.key))
                .remedy("add fields = [\"velocity\"], or leave it out"));
        }
        let lengths = [("edge", self.edge), ("along", self.along), ("h_min", self.h_min)];
        for (key, length) in lengths.into_iter().filter_map(|(key, l)| Some((key, l?))) {
            if let (Some(longest), Some(item)) = (self.h_max.filter(|longest| *longest < length), table.get("h_max")) {
                return Err(item
                    .error(format!("`h_max` = {longest} is below `{key}` = {length}"))
                    .remedy(format!("give h_max >= {length}")));
            }
        }
        match (self.along, self.edge, table.get("along")) {
            (Some(along), Some(edge), Some(item)) if along < edge => Err(item
                .error(format!("edges along the interfaces must not be shorter than those across, {edge}"))
                .remedy(format!("give along >= {edge}"))),
            _ => Ok(()),
        }
    }

    /// Writes the table `[mesh.adapt]`.
    pub(in crate::scene) fn write(&self, out: &mut Writer) {
        out.header("[mesh.adapt]");
        let lengths = [
            ("every", self.every),
            ("edge", self.edge),
            ("along", self.along),
            ("width", self.width),
            ("h_min", self.h_min),
            ("h_max", self.h_max),
        ];
        for (key, value) in lengths {
            value.iter().for_each(|v| out.entry(key, number(*v)));
        }
        if !self.fields.is_empty() {
            out.entry("fields", list(self.fields.iter().map(|f| name(*f, &FIELDS))));
            match self.vertices {
                Some(count) => out.entry("vertices", count),
                None => out.entry("error", number(self.error)),
            }
            out.entry("anisotropy", number(self.anisotropy));
        }
        out.entry("gradation", number(self.gradation));
        out.entry("transfer", name(self.transfer, &TRANSFERS));
    }
}

fn fields(item: &Item) -> Result<Vec<AdaptField>> {
    let mut found = Vec::new();
    for item in item.list()? {
        let field = item.choice(&FIELDS)?;
        if found.contains(&field) {
            return Err(item.error("the field is named twice").remedy("name every field once"));
        }
        found.push(field);
    }
    Ok(found)
}

/// A ratio that is large enough.
fn ratio(item: &Item, words: &str, large_enough: impl Fn(f64) -> bool) -> Result<f64> {
    let v = item.number()?;
    if large_enough(v) {
        return Ok(v);
    }
    Err(item.error(format!("`{}` must be {words}", item.key)).remedy(format!("give a ratio {words}, such as 1.5")))
}
