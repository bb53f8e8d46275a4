//! `[output]`: what is written, and when.

use super::geometry::{CURVE, Curve, DELTA_LIST, DeltaName, curve, deltas};
use super::picture::Picture;
use super::source::{Motion, Quantity, Source, unless_false};
use super::time::Time;
use crate::base::Result;
use crate::scene::keys::{Absent::*, Keys, Kind::*, row, words};
use crate::scene::keys::{Context, Item};
use crate::scene::keys::{Writer, key, list, name, number, text, vector};

/// What a run writes.
///
/// What is wanted every `d` is written at the start and at the first step at or after each multiple of `d`: after every
/// step when `d` is shorter than the step.
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// Time between rows of the series.
    pub every: f64,
    /// Time between field files; `None` for none. Pictures are drawn from field files, which are written at their times too.
    pub fields: Option<f64>,
    /// Time between pictures; `None` for none.
    pub pictures: Option<f64>,
    /// Whether the pictures are joined to a film.
    pub film: bool,
    /// Seconds of the clock on the wall between checkpoints, 0 for one after each step; `None` for none.
    pub checkpoint: Option<f64>,
    /// Values at points, in the series.
    pub probes: Vec<Probe>,
    /// Values along lines at given times.
    pub profiles: Vec<Profile>,
    /// Forces on boundaries, in the series.
    pub forces: Vec<Force>,
    /// Fluxes through boundaries, in the series.
    pub fluxes: Vec<Flux>,
    /// Whether the backward characteristics are carried even where no structure needs them.
    pub backward_map: bool,
    /// Delta functions that interfaces are measured with, beside the cut one.
    pub deltas: Vec<DeltaName>,
    /// Whether the curvatures of interfaces are measured and written.
    pub curvature: bool,
    /// Curves between interfaces, in the series.
    pub curves: Vec<Curve>,
    /// How pictures look.
    pub picture: Picture,
}

/// A value at a point.
#[derive(Clone, Debug, PartialEq)]
pub struct Probe {
    /// The name of its columns.
    pub name: String,
    /// The point.
    pub at: Vec<f64>,
    /// What is measured.
    pub of: Quantity,
}

/// Values along a segment.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// The name of its file.
    pub name: String,
    /// One end.
    pub from: Vec<f64>,
    /// The other end.
    pub to: Vec<f64>,
    /// Equidistant points, both ends included, >= 2.
    pub points: usize,
    /// What is measured.
    pub of: Quantity,
    /// When: at the first step at or after each; rising. Times after the end are not reached.
    pub times: Vec<f64>,
}

/// The force of the fluid on a named boundary: by the residual of the momentum equation, which is the more accurate one, and by
/// the stress. At its ends the residual holds the force on what comes next, too: ask for closed boundaries where that matters.
#[derive(Clone, Debug, PartialEq)]
pub struct Force {
    /// The name of its columns.
    pub name: String,
    /// The boundary.
    pub boundary: String,
    /// The point about which the moment is taken; `None` for no moment.
    pub about: Option<Vec<f64>>,
}

/// The volume that leaves through a named boundary in unit time.
#[derive(Clone, Debug, PartialEq)]
pub struct Flux {
    /// The name of its column.
    pub name: String,
    /// The boundary.
    pub boundary: String,
}

const QUANTITIES: [(&str, Quantity); 6] = [
    ("pressure", Quantity::Pressure),
    ("velocity", Quantity::Velocity),
    ("speed", Quantity::Speed),
    ("vorticity", Quantity::Vorticity),
    ("level_set", Quantity::LevelSet),
    ("stretch", Quantity::Stretch),
];
const QUANTITY_WORDS: [&str; QUANTITIES.len()] = words(&QUANTITIES);

pub(in crate::scene) static KEYS: Keys = Keys {
    about: "What is written, and when. What is wanted every `d` is written at the start and at the first step at or after each multiple of `d`.",
    keys: &[
        row(
            "every",
            Value("number > 0"),
            "s",
            Derived("`time.step`; with `time.tolerance` a 200th of `time.end`"),
            "Time between rows of `series.csv`.",
        ),
        row(
            "fields",
            Value("number > 0 or false"),
            "s",
            Derived("a tenth of the run"),
            "Time between field files (VTU); false for none. \
            Pictures are drawn from field files, which are written at their times too.",
        ),
        row(
            "pictures",
            Value("number > 0 or false"),
            "s",
            Derived("a fiftieth of the run"),
            "Time between pictures; false for none.",
        ),
        row(
            "film",
            Value("true or false"),
            "",
            Derived("true where there are pictures"),
            "Whether the pictures are joined to a film.",
        ),
        row(
            "checkpoint",
            Value("number >= 0 or false"),
            "s",
            Default("30.0"),
            "Seconds of the clock on the wall between checkpoints, \
            0 for one after each step; false for none.",
        ),
        row("probes", Named(&PROBE), "", Optional, "Values at points, in `series.csv`."),
        row("profiles", Named(&PROFILE), "", Optional, "Values along lines at given times, in `profiles/NAME.csv`."),
        row("forces", Named(&FORCE), "", Optional, "Forces of the fluid on boundaries, in `series.csv`."),
        row(
            "fluxes",
            Named(&FLUX),
            "",
            Optional,
            "Volumes that leave through boundaries in unit time, in `series.csv`.",
        ),
        row(
            "backward_map",
            Value("true or false"),
            "",
            Default("false"),
            "Whether the backward characteristics Y are carried even where no membrane resists shear: columns `determinant_error` and, in \
             space, area and shear of every interface; the field `displacement`, Y(x) - x.",
        ),
        row(
            "deltas",
            Value(DELTA_LIST),
            "",
            Default("[]"),
            "Delta functions that every interface is measured with beside the cut one: columns such as `NAME.perimeter_smereka1` and, where a Heaviside function \
             belongs to it, `NAME.area_towers`; in space `surface` and `volume`. \"smeared\" is that of the force of a membrane.",
        ),
        row(
            "curvature",
            Value("true or false"),
            "",
            Default("false"),
            "Whether the mean and, in space, the Gauss curvature of every interface are measured: columns `NAME.curvature_min`, `_max`, `_mean`, fields `NAME.curvature`.",
        ),
        row("curves", Named(&CURVE), "", Optional, "Curves in which two interfaces meet, in space, in `series.csv`."),
        row("picture", Table(&super::picture::KEYS), "", Optional, "How pictures look."),
    ],
};

const MEASURED: &str = "What is measured. The vorticity is d_x u_y - d_y u_x, in space the length of curl u: the mean of the cells around each node, \
    interpolated.";

static PROBE: Keys = Keys {
    about: "A value at a point.",
    keys: &[
        row("at", Value("point"), "m", Required, "The point."),
        row("of", Choice(&QUANTITY_WORDS), "", Required, MEASURED),
    ],
};

static PROFILE: Keys = Keys {
    about: "Values along a segment.",
    keys: &[
        row("from", Value("point"), "m", Required, "One end."),
        row("to", Value("point"), "m", Required, "The other end."),
        row(
            "points",
            Value("whole number from 2 to 1000000"),
            "",
            Default("200"),
            "Equidistant points, both ends included.",
        ),
        row("of", Choice(&QUANTITY_WORDS), "", Required, MEASURED),
        row(
            "times",
            Value("list of rising numbers >= 0"),
            "s",
            Derived("the end"),
            "When: at the first step at or after each.",
        ),
    ],
};

static FORCE: Keys = Keys {
    about: "The force of the fluid on a boundary, by the residual of the momentum equation (the more accurate one) and by the stress. \
        At the ends of an open curve the residual holds the force on what comes next, too.",
    keys: &[
        row("boundary", Value("text"), "", Required, "The name of the boundary."),
        row("about", Value("point"), "m", Optional, "The point about which the moment is taken."),
    ],
};

static FLUX: Keys = Keys {
    about: "The volume that leaves through a boundary in unit time.",
    keys: &[row("boundary", Value("text"), "", Required, "The name of the boundary.")],
};

/// Without a word from the scene: field files and pictures in a run, and seconds between checkpoints.
const FIELD_FILES: f64 = 10.0;
const PICTURES: f64 = 50.0;
const CHECKPOINT: f64 = 30.0;

impl Output {
    /// `interfaces` are the names of membranes and level sets; `sheared` tells whether some membrane resists shear.
    pub(in crate::scene) fn read(
        item: Option<Item>,
        time: &Time,
        interfaces: &[&str],
        motion: Motion,
        sheared: bool,
        context: &Context,
    ) -> Result<Output> {
        let table = item.as_ref().map(|i| i.table(&KEYS)).transpose()?;
        let asked = table.as_ref().map_or(Ok(None), |t| t.optional("backward_map", Item::boolean))?.unwrap_or(false);
        let source = Source { table, time, interfaces, motion, has_map: asked || sheared, context };
        let fields = source.interval_or_none("fields", FIELD_FILES)?;
        let pictures = source.interval_or_none("pictures", PICTURES)?;
        let film = source.optional("film", |i| match (i.boolean()?, pictures) {
            (true, None) => Err(i
                .error("a film needs pictures, which are off")
                .remedy("give output.pictures an interval, or write film = false")),
            (film, _) => Ok(film),
        })?;
        let output = Output {
            every: source
                .optional("every", Item::positive)?
                .unwrap_or(time.tolerance.map_or(time.step, |_| time.end / ROWS)),
            fields,
            pictures,
            film: film.unwrap_or(pictures.is_some()),
            checkpoint: source
                .optional("checkpoint", |i| unless_false(i, Item::non_negative))?
                .unwrap_or(Some(CHECKPOINT)),
            probes: source.named("probes", |name, i| source.probe(name, i))?,
            profiles: source.named("profiles", |name, i| source.profile(name, i))?,
            forces: source.named("forces", |name, i| source.force(name, i))?,
            fluxes: source.named("fluxes", flux)?,
            backward_map: asked,
            deltas: source.optional("deltas", deltas)?.unwrap_or_default(),
            curvature: source.optional("curvature", Item::boolean)?.unwrap_or(false),
            curves: source.named("curves", |name, i| curve(name, i, interfaces, context))?,
            picture: source.optional("picture", |i| source.picture(i))?.unwrap_or(source.default_picture()),
        };
        source.check_names()?;
        Ok(output)
    }

    pub(in crate::scene) fn write(&self, out: &mut Writer, dimension: usize) {
        let interval = |v: Option<f64>| v.map_or_else(|| "false".to_string(), number);
        out.header("[output]");
        out.entry("every", number(self.every));
        out.entry("fields", interval(self.fields));
        out.entry("pictures", interval(self.pictures));
        out.entry("film", self.film);
        out.entry("checkpoint", interval(self.checkpoint));
        out.entry("backward_map", self.backward_map);
        out.entry("deltas", list(self.deltas.iter().map(|d| text(d.word()))));
        out.entry("curvature", self.curvature);
        out.entry("picture", self.picture.write(dimension));
        for c in &self.curves {
            let of = list(c.of.iter().map(|n| text(n)));
            out.entry(&format!("curves.{}", key(&c.name)), format_args!("{{ of = {of} }}"));
        }
        for p in &self.probes {
            let (at, of) = (vector(&p.at), name(p.of, &QUANTITIES));
            out.entry(&format!("probes.{}", key(&p.name)), format_args!("{{ at = {at}, of = {of} }}"));
        }
        for p in &self.profiles {
            let (from, to, of, times) = (vector(&p.from), vector(&p.to), name(p.of, &QUANTITIES), vector(&p.times));
            let points = p.points;
            out.entry(
                &format!("profiles.{}", key(&p.name)),
                format_args!("{{ from = {from}, to = {to}, points = {points}, of = {of}, times = {times} }}"),
            );
        }
        for f in &self.forces {
            let about = f.about.as_ref().map_or_else(String::new, |a| format!(", about = {}", vector(a)));
            let boundary = text(&f.boundary);
            out.entry(&format!("forces.{}", key(&f.name)), format_args!("{{ boundary = {boundary}{about} }}"));
        }
        for f in &self.fluxes {
            out.entry(&format!("fluxes.{}", key(&f.name)), format_args!("{{ boundary = {} }}", text(&f.boundary)));
        }
    }
}

/// Rows of the series of steps that follow the error, where the scene does not say.
const ROWS: f64 = 200.0;

impl Source<'_> {
    fn quantity(&self, item: &Item) -> Result<Quantity> {
        self.possible(item, item.choice(&QUANTITIES)?)
    }

    fn probe(&self, name: String, item: &Item) -> Result<Probe> {
        let table = item.table(&PROBE)?;
        Ok(Probe {
            name,
            at: table.required("at", "give the point: at = [1, 1]", |i| i.point(self.context))?,
            of: table.required("of", "say what to measure: of = \"pressure\"", |i| self.quantity(i))?,
        })
    }

    fn profile(&self, name: String, item: &Item) -> Result<Profile> {
        let table = item.table(&PROFILE)?;
        let from = table.required("from", "give one end: from = [0, 1]", |i| i.point(self.context))?;
        let to = |i: &Item| match i.point(self.context)? {
            to if to == from => Err(i.error("the profile has no length").remedy("give `to` and `from` that differ")),
            to => Ok(to),
        };
        Ok(Profile {
            name,
            to: table.required("to", "give the other end: to = [2, 1]", to)?,
            from,
            points: table.optional("points", |i| i.count(2, 1_000_000))?.unwrap_or(200),
            of: table.required("of", "say what to measure: of = \"pressure\"", |i| self.quantity(i))?,
            times: table.optional("times", |i| self.times(i))?.unwrap_or_else(|| vec![self.time.end]),
        })
    }

    fn times(&self, item: &Item) -> Result<Vec<f64>> {
        let mut times: Vec<f64> = Vec::new();
        for item in item.list()? {
            let t = item.non_negative()?;
            if times.last().is_some_and(|last| *last >= t) {
                return Err(item
                    .error(format!("the time {t} is not after the one before it"))
                    .remedy(format!("give rising times from 0 to {}", self.time.end)));
            }
            times.push(t);
        }
        Ok(times)
    }

    fn force(&self, name: String, item: &Item) -> Result<Force> {
        if self.motion != Motion::Flow {
            return Err(item
                .key_error("there are no forces: the velocity is prescribed and no flow is solved")
                .remedy("leave output.forces out"));
        }
        let table = item.table(&FORCE)?;
        Ok(Force {
            name,
            boundary: table.required("boundary", "name a boundary: boundary = \"cylinder\"", boundary)?,
            about: table.optional("about", |i| i.point(self.context))?,
        })
    }

    /// Columns of the series begin with the name of what they measure: no two may share it.
    fn check_names(&self) -> Result<()> {
        let mut taken: Vec<&str> = self.interfaces.to_vec();
        for key in ["probes", "forces", "fluxes", "curves"] {
            let Some(item) = self.table.as_ref().and_then(|t| t.get(key)) else { continue };
            for (name, item) in item.open_table()?.items() {
                if taken.contains(&name) {
                    return Err(item
                        .key_error(format!("the name `{name}` is taken by another output or an interface"))
                        .remedy("give every membrane, level set, probe, force, flux and curve a name of its own"));
                }
                taken.push(name);
            }
        }
        Ok(())
    }
}

fn flux(name: String, item: &Item) -> Result<Flux> {
    let table = item.table(&FLUX)?;
    Ok(Flux { name, boundary: table.required("boundary", "name a boundary: boundary = \"right\"", boundary)? })
}

fn boundary(item: &Item) -> Result<String> {
    item.text().map(str::to_string)
}
