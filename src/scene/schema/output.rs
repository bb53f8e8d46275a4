//! `[output]`: results to write, and their times.

use super::geometry::{Curve, DeltaName, Deltas};
use super::given::{Given, Motion, Quantity};
use super::picture::Picture;
use crate::base::Result;
use crate::scene::keys::{
    Context, Count, Flag, Form, Item, Kind, Named, Nested, NonNegative, Opt, OrFalse, Point,
    Positive, Set, Table, Tabled, Text, Writer, kinds, last, table, words,
};

table! {
    /// What is written, and when. What is wanted every `d` is written at the start and at the first
    /// step at or after each multiple of `d`.
    Output {
        /// Time between rows of `series.csv`.
        every: f64 [Positive, "s",
            Derived("`time.step`; with `time.tolerance` a 200th of `time.end`")],
        /// Time between field files (VTU); false for none. Pictures are drawn from field files,
        /// which are written at their times too.
        fields: Option<f64> [OrFalse<Positive>, "s", Derived("a tenth of the run")],
        /// Time between pictures; false for none.
        pictures: Option<f64> [OrFalse<Positive>, "s", Derived("a fiftieth of the run")],
        /// Whether the pictures are joined to a film.
        film: bool [Flag, Derived("true where there are pictures")],
        /// Seconds of the clock on the wall between checkpoints, 0 for one after each step; false
        /// for none.
        checkpoint: Option<f64> [OrFalse<NonNegative>, "s", Default(30.0)],
        /// Values at points, in `series.csv`.
        probes: Vec<Named<Probe>> [Named<Probe>],
        /// Values along lines at given times, in `profiles/NAME.csv`.
        profiles: Vec<Named<Profile>> [Named<Profile>],
        /// Forces of the fluid on boundaries, in `series.csv`.
        forces: Vec<Named<Force>> [Named<Force>],
        /// Volumes that leave through boundaries in unit time, in `series.csv`.
        fluxes: Vec<Named<Flux>> [Named<Flux>],
        /// Whether the backward characteristics Y are carried even where no membrane resists shear:
        /// columns `determinant_error` and, in space, area and shear of every interface; the field
        /// `displacement`, Y(x) - x.
        backward_map: bool [Flag, Default(false)],
        /// Delta functions that every interface is measured with beside the cut one: columns such
        /// as `NAME.perimeter_smereka1` and, where a Heaviside function belongs to it,
        /// `NAME.area_towers`; in space `surface` and `volume`. "smeared" is that of the force of a
        /// membrane.
        deltas: Vec<DeltaName> [Set<Deltas>, Default([])],
        /// Whether the mean and, in space, the Gauss curvature of every interface are measured:
        /// columns `NAME.curvature_min`, `_max`, `_mean`, fields `NAME.curvature`.
        curvature: bool [Flag, Default(false)],
        /// Curves in which two interfaces meet, in space, in `series.csv`.
        curves: Vec<Named<Curve>> [Named<Curve>],
        /// How pictures look.
        picture: Picture [Nested<Picture>, Inner],
    }
}

table! {
    /// A value at a point.
    Probe {
        /// The point.
        at: Vec<f64> [Point, "m", Required("give the point: at = [1, 1]")],
        /// What is measured. The vorticity is d_x u_y - d_y u_x, in space the length of curl u: the
        /// mean of the cells around each node, interpolated.
        of: Quantity [Quantities, Required("say what to measure: of = \"pressure\"")],
    }
}

table! {
    /// Values along a segment.
    Profile {
        /// One end.
        from: Vec<f64> [Point, "m", Required("give one end: from = [0, 1]")],
        /// The other end.
        to: Vec<f64> [Point, "m", Required("give the other end: to = [2, 1]")],
        /// Equidistant points, both ends included.
        points: usize [Count<2, 1_000_000>, Default(200)],
        /// What is measured. The vorticity is d_x u_y - d_y u_x, in space the length of curl u: the
        /// mean of the cells around each node, interpolated.
        of: Quantity [Quantities, Required("say what to measure: of = \"pressure\"")],
        /// When: at the first step at or after each.
        times: Vec<f64> [Times, "s", Derived("the end")],
    } check Profile::check;
}

table! {
    /// The force of the fluid on a boundary, by the residual of the momentum equation (the more
    /// accurate one) and by the stress. At the ends of an open curve the residual holds the force
    /// on what comes next, too.
    Force {
        /// The name of the boundary.
        boundary: String [Text, Required("name a boundary: boundary = \"cylinder\"")],
        /// The point about which the moment is taken.
        about: Option<Vec<f64>> [Opt<Point>, "m"],
    }
}

table! {
    /// The volume that leaves through a boundary in unit time.
    Flux {
        /// The name of the boundary.
        boundary: String [Text, Required("name a boundary: boundary = \"right\"")],
    }
}

words! {
    Quantities: Quantity {
        "pressure" = Quantity::Pressure,
        "velocity" = Quantity::Velocity,
        "speed" = Quantity::Speed,
        "vorticity" = Quantity::Vorticity,
        "level_set" = Quantity::LevelSet,
        "stretch" = Quantity::Stretch,
    }
}
kinds! {
    /// Times, not yet in any order.
    Times: Vec<f64> = Kind::Value(
        "list of rising numbers >= 0",
        Form::List(&Form::least(0.0), [0, usize::MAX]),
    ),
        |i, _| i.list()?.iter().map(Item::non_negative).collect();
}

/// Default number of field files and pictures in a run, and of rows of the series for adaptive
/// steps.
const FIELD_FILES: f64 = 10.0;
const PICTURES: f64 = 50.0;
const ROWS: f64 = 200.0;

impl Output {
    /// Reads the table `[output]` of a scene.
    pub(in crate::scene) fn read_given(scene: &Table<'_>, mut given: Given<'_>) -> Result<Output> {
        let table = scene.inner("output", Output::KEYS)?;
        let mut output = Output::read_table(&table, given.context)?;
        given.has_map |= output.backward_map;
        given.has_strain |= output.backward_map;
        output.complete(&table, &given)?;
        output.check(&table, &given)?;
        Ok(output)
    }

    /// Derives the remaining values from the rest of the scene.
    fn complete(&mut self, table: &Table<'_>, given: &Given<'_>) -> Result<()> {
        let (time, paced) = (given.time, given.time.tolerance.is_some());
        let part = |parts: f64| Some((time.end / parts).max(if paced { 0.0 } else { time.step }));
        let absent = |key: &str| table.get(key).is_none();
        if absent("every") {
            self.every = if paced { time.end / ROWS } else { time.step };
        }
        if absent("fields") {
            self.fields = part(FIELD_FILES);
        }
        if absent("pictures") {
            self.pictures = part(PICTURES);
        }
        if absent("film") {
            self.film = self.pictures.is_some();
        }
        if table.inner("picture", Picture::KEYS)?.get("field").is_none() {
            self.picture.field = given.default_field();
        }
        for (profile, item) in self.profiles.iter_mut().zip(items(table, "profiles")?) {
            if item.open_table()?.get("times").is_none() {
                profile.table.times = vec![time.end];
            }
        }
        Ok(())
    }

    fn check(&self, table: &Table<'_>, given: &Given<'_>) -> Result<()> {
        if let (true, None, Some(item)) = (self.film, self.pictures, table.get("film")) {
            return Err(item
                .error("a film needs pictures, which are off")
                .remedy("give output.pictures an interval, or write film = false"));
        }
        let probes = self.probes.iter().map(|p| p.of).zip(items(table, "probes")?);
        let profiles = self.profiles.iter().map(|p| p.of).zip(items(table, "profiles")?);
        for (quantity, item) in probes.chain(profiles) {
            let table = item.open_table()?;
            table.get("of").map_or(Ok(()), |item| given.check_quantity(&item, quantity))?;
            table.get("times").map_or(Ok(()), |item| given.check_times(&item))?;
        }
        if let (Some(item), true) = (items(table, "forces")?.first(), given.motion != Motion::Flow)
        {
            return Err(item
                .key_error("there are no forces: the velocity is prescribed and no flow is solved")
                .remedy("leave output.forces out"));
        }
        for (curve, item) in self.curves.iter().zip(items(table, "curves")?) {
            curve.check(&item, given.interfaces)?;
        }
        if let Some(item) = table.inner("picture", Picture::KEYS)?.get("field") {
            given.check_field(&item, self.picture.field)?;
        }
        given.check_names(table)
    }

    pub(in crate::scene) fn write(&self, out: &mut Writer) {
        out.header("[output]");
        out.entries(last(
            self.entries(),
            &["picture", "curves", "probes", "profiles", "forces", "fluxes"],
        ));
    }
}

impl Profile {
    fn check(&mut self, table: &Table<'_>, _: &Context) -> Result<()> {
        match table.get("to").filter(|_| self.from == self.to) {
            Some(to) => Err(to
                .error("the profile has no length")
                .remedy("give `to` and `from` that differ")),
            None => Ok(()),
        }
    }
}

/// The entries of the table of named tables `key`.
fn items<'a>(table: &Table<'a>, key: &str) -> Result<Vec<Item<'a>>> {
    let named = table.get(key).map(|i| i.open_table()).transpose()?;
    Ok(named.map_or_else(Vec::new, |t| t.items().map(|(_, item)| item).collect()))
}
