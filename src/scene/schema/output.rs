//! `[output]`: results to write, and their times.

use super::geometry::{Curve, DeltaName, Deltas};
use super::given::{Given, Motion, Quantity};
use super::picture::Picture;
use crate::base::Result;
use crate::scene::keys::{
    Context, Count, Direction, Flag, Form, Item, Kind, Named, Nested, NonNegative, Opt, OrFalse,
    Point, Positive, Set, Table, Tabled, Text, Writer, kinds, last, table, words,
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
        /// What the field files hold beside velocity, pressure and level sets: "vorticity";
        /// "materials", density and viscosity where they vary; "interfaces", every interface as
        /// lines (in space: triangles) with what it carries, in `interfaces.pvd`; "boundaries", the
        /// named parts of the boundary, in `boundaries.vtp`.
        store: Vec<Stored> [Set<StoredWords>,
            Default(["vorticity", "materials", "interfaces", "boundaries"])],
        /// Whether the fields of all times are put into one file as well, `fields.vtkhdf`
        /// (VTKHDF 2.0: VTK 9.3 or newer). It is made of the field files whenever a run ends
        /// or stops, and needs as much memory as they are large without compression.
        vtkhdf: bool [Flag, Default(false)],
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
        /// What the coefficients of drag and lift refer to: columns `NAME_drag` and `NAME_lift`, by
        /// the residual, and the Strouhal number in `summary.json`, once the lift has three periods
        /// in the second half of the run. Behind a body also `NAME_recirculation`, the length of the
        /// fluid that goes back, from the rear along the stream through the centre.
        reference: Option<Reference> [Opt<Nested<Reference>>],
    }
}

table! {
    /// Speed, length and density of the coefficients of a force: 2 F / (rho U^2 L), in space
    /// 2 F / (rho U^2 A), and the Strouhal number f L / U.
    Reference {
        /// The speed U, such as the mean one at the inlet.
        speed: f64 [Positive, "m/s",
            Required("give both: reference = { speed = 1, length = 0.1 }")],
        /// The length L, such as the diameter of the body.
        length: f64 [Positive, "m",
            Required("give both: reference = { speed = 1, length = 0.1 }")],
        /// The density rho.
        density: Option<f64> [Opt<Positive>, "kg/m3", Derived("`fluid.density`, outside")],
        /// The area A, in space.
        area: Option<f64> [Opt<Positive>, "m2", Derived("`length` squared")],
        /// The direction of the stream, which is that of the drag.
        stream: Option<Vec<f64>> [Opt<Direction>, Derived("along x")],
        /// In space, the direction of the lift; what is along the stream does not count. In the
        /// plane it is the stream turned to the left.
        lift: Option<Vec<f64>> [Opt<Direction>, Derived("along y")],
    } before Reference::before; check Reference::check;
}

table! {
    /// The volume that leaves through a boundary in unit time.
    Flux {
        /// The name of the boundary.
        boundary: String [Text, Required("name a boundary: boundary = \"right\"")],
    }
}

/// What field files may hold beside velocity, pressure and level sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stored {
    /// The vorticity.
    Vorticity,
    /// Density and viscosity, where they vary.
    Materials,
    /// The interfaces.
    Interfaces,
    /// The boundary.
    Boundaries,
}
words! {
    StoredWords: Stored {
        "vorticity" = Stored::Vorticity,
        "materials" = Stored::Materials,
        "interfaces" = Stored::Interfaces,
        "boundaries" = Stored::Boundaries,
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

impl Reference {
    /// Longest time between rows that shows every period of a flow past a body, of which none is
    /// much shorter than `length / speed`.
    pub fn longest_between_rows(&self) -> f64 {
        0.25 * self.length / self.speed
    }
    /// True if rows so far apart show every period.
    pub fn is_resolved_by(&self, every: f64) -> bool {
        every <= self.longest_between_rows() * (1.0 + 1e-9)
    }
    fn before(table: &Table<'_>, context: &Context) -> Result<()> {
        match ["area", "lift"].into_iter().find_map(|key| table.get(key)) {
            Some(item) if context.dimension == 2 => Err(item
                .key_error(format!("`{}` is for forces in space, and the mesh is plane", item.key))
                .remedy(match item.key.ends_with("lift") {
                    true => "leave it out: the lift is at a right angle to the stream",
                    false => "leave it out: forces in the plane are per unit of depth",
                })),
            _ => Ok(()),
        }
    }

    fn check(&mut self, table: &Table<'_>, context: &Context) -> Result<()> {
        let [stream, lift] = self.directions(context.dimension);
        let length = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>();
        for (key, v) in [("stream", &stream), ("lift", &lift)] {
            if let (true, Some(item)) = (length(v) < 0.5, table.get(key)) {
                let what = if key == "lift" && length(&stream) > 0.5 {
                    "the lift is along the stream"
                } else {
                    "the direction has no length"
                };
                return Err(item
                    .error(what)
                    .remedy("give directions that differ: stream = [1, 0, 0], lift = [0, 1, 0]"));
            }
        }
        Ok(())
    }

    /// Unit vectors of drag and lift; zero where they are not defined.
    pub(in crate::scene) fn directions(&self, dimension: usize) -> [Vec<f64>; 2] {
        let axis = |k: usize| (0..dimension).map(|i| f64::from(u8::from(i == k))).collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let unit = |v: Vec<f64>| {
            let norm = dot(&v, &v).sqrt();
            v.iter().map(|x| if norm > 1e-9 { x / norm } else { 0.0 }).collect::<Vec<f64>>()
        };
        let stream = unit(self.stream.clone().unwrap_or_else(|| axis(0)));
        if dimension == 2 {
            let left = vec![-stream[1], stream[0]];
            return [stream, left];
        }
        let across = |v: Vec<f64>| {
            let v = unit(v);
            let along = dot(&v, &stream);
            unit(v.iter().zip(&stream).map(|(x, s)| x - along * s).collect())
        };
        let lift = across(self.lift.clone().unwrap_or_else(|| axis(1)));
        // Where the stream is along y the lift is by default along z.
        let none = self.lift.is_none() && dot(&lift, &lift) == 0.0;
        let lift = if none { across(axis(2)) } else { lift };
        [stream, lift]
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
