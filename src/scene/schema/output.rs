//! `[output]`: what is written, and when.

use super::fluid::Fluid;
use super::geometry::{Curve, DeltaName, Deltas};
use super::picture::Picture;
use super::time::Time;
use crate::base::Result;
use crate::scene::keys::{
    Context, Count, Flag, Item, Kind, Named, Nested, NonNegative, Opt, OrFalse, Point, Positive, Set, Table, Tabled,
    Text, Writer, kinds, last, table, words,
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

/// A field that can be asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// The pressure.
    Pressure,
    /// The velocity, one value for each component.
    Velocity,
    /// The magnitude of the velocity.
    Speed,
    /// The vorticity, [`Space::vorticity`](crate::fem::Space::vorticity).
    Vorticity,
    /// The level set of the one interface.
    LevelSet,
    /// The stretch of the one interface.
    Stretch,
    /// `Z1` on the one interface; in pictures of space alone.
    AreaChange,
    /// `Z2` on the one interface; in pictures of space alone.
    Shear,
    /// The grey levels of the image that is segmented; in pictures alone.
    Image,
    /// A checkerboard on the one interface when it is at rest, which its material carries; in pictures of space alone.
    Checkerboard,
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
    Times: Vec<f64> = Kind::Value("list of rising numbers >= 0"),
        |i, _| i.list()?.iter().map(Item::non_negative).collect();
}

/// Without a word from the scene: field files and pictures in a run, and rows of the series of
/// steps that follow the error.
const FIELD_FILES: f64 = 10.0;
const PICTURES: f64 = 50.0;
const ROWS: f64 = 200.0;

/// The cause of the motion of interfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::scene) enum Motion {
    /// A flow that is solved.
    Flow,
    /// A velocity that is given.
    Prescribed,
    /// The fit to an image; nothing flows.
    Image,
}

impl Motion {
    pub fn of(fluid: &Fluid, image: bool) -> Motion {
        match (image, fluid.is_prescribed()) {
            (true, _) => Motion::Image,
            (false, true) => Motion::Prescribed,
            (false, false) => Motion::Flow,
        }
    }
}

/// Properties of the scene that the values of `[output]` must agree with.
pub(in crate::scene) struct Given<'a> {
    pub time: &'a Time,
    /// Names of all interfaces.
    pub interfaces: &'a [&'a str],
    pub motion: Motion,
    /// True if backward characteristics are carried.
    pub has_map: bool,
    pub context: &'a Context,
}

impl Output {
    /// Reads the table `[output]` of a scene.
    pub(in crate::scene) fn read_given(scene: &Table<'_>, mut given: Given<'_>) -> Result<Output> {
        let table = scene.inner("output", Output::KEYS)?;
        let mut output = Output::read_table(&table, given.context)?;
        given.has_map |= output.backward_map;
        output.complete(&table, &given)?;
        output.check(&table, &given)?;
        Ok(output)
    }

    /// Fills in what follows from the rest of the scene.
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
        if let (Some(item), true) = (items(table, "forces")?.first(), given.motion != Motion::Flow) {
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
        out.entries(last(self.entries(), &["picture", "curves", "probes", "profiles", "forces", "fluxes"]));
    }
}

impl Profile {
    fn check(&mut self, table: &Table<'_>, _: &Context) -> Result<()> {
        match table.get("to").filter(|_| self.from == self.to) {
            Some(to) => Err(to.error("the profile has no length").remedy("give `to` and `from` that differ")),
            None => Ok(()),
        }
    }
}

/// The entries of the named tables `key`.
fn items<'a>(table: &Table<'a>, key: &str) -> Result<Vec<Item<'a>>> {
    let named = table.get(key).map(|i| i.open_table()).transpose()?;
    Ok(named.map_or_else(Vec::new, |t| t.items().map(|(_, item)| item).collect()))
}

impl Given<'_> {
    /// Refuses a quantity that the scene does not have.
    pub(in crate::scene) fn check_quantity(&self, item: &Item, quantity: Quantity) -> Result<()> {
        let n = self.interfaces.len();
        if self.motion == Motion::Image && quantity != Quantity::LevelSet {
            return Err(item
                .error(format!("there is no `{}`: an image is segmented, and nothing flows", item.text()?))
                .remedy("ask for level_set"));
        }
        if quantity == Quantity::Pressure && self.motion == Motion::Prescribed {
            return Err(item
                .error("there is no pressure: the velocity is prescribed and no flow is solved")
                .remedy("ask for velocity, speed, level_set or stretch"));
        }
        if matches!(quantity, Quantity::LevelSet | Quantity::Stretch) && n != 1 {
            return Err(item
                .error(format!("`{}` belongs to one interface, but the scene has {n}", item.text()?))
                .remedy("ask for pressure, velocity or speed"));
        }
        Ok(())
    }

    fn check_times(&self, item: &Item) -> Result<()> {
        let mut last = None;
        for item in item.list()? {
            let t = item.non_negative()?;
            if last.is_some_and(|last| last >= t) {
                return Err(item
                    .error(format!("the time {t} is not after the one before it"))
                    .remedy(format!("give rising times from 0 to {}", self.time.end)));
            }
            last = Some(t);
        }
        Ok(())
    }

    /// Columns of the series begin with the name of what they measure: no two may share it.
    fn check_names(&self, table: &Table<'_>) -> Result<()> {
        let mut taken: Vec<&str> = self.interfaces.to_vec();
        for key in ["probes", "forces", "fluxes", "curves"] {
            let Some(item) = table.get(key) else { continue };
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
