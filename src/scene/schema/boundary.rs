//! `[boundary.NAME]`: conditions on the named parts of the boundary.

use crate::base::Result;
use crate::scene::expression::Expression;
use crate::scene::keys::{
    Components, Context, Form, Item, Kind, Tabled, Text, Typed, Writer, key, kinds, one_of, text,
};

/// The name of the whole boundary.
pub const WALLS: &str = "walls";

/// The condition on a named part of the boundary.
#[derive(Clone, Debug, PartialEq)]
pub struct Boundary {
    /// A boundary of the mesh, or [`WALLS`] for all facets without another entry.
    pub name: String,
    /// The condition on it.
    pub condition: Condition,
}

/// A boundary condition of the flow.
#[derive(Clone, Debug, PartialEq)]
pub enum Condition {
    /// A given velocity.
    Velocity(Vec<Expression>),
    /// Zero velocity.
    NoSlip,
    /// Zero normal velocity and zero tangential stress.
    Slip,
    /// Zero stress (do-nothing).
    Open(Opening),
    /// A given pressure.
    Pressure(Expression),
    /// A given pressure where fluid leaves, and a given total pressure where it comes in.
    TotalPressure(Expression),
    /// A given traction.
    Traction(Vec<Expression>),
    /// The same flow as on the boundary of this name, which is a translate of it.
    Periodic(String),
}

one_of! {
    /// What holds on a boundary of the mesh: exactly one of these. `walls` stands for all sides
    /// that have no entry; without any entry, no slip holds on the whole boundary.
    Condition {
        /// A given velocity.
        "velocity" [Components, "m/s"] (v) => (Condition::Velocity(v));
        /// No velocity.
        "no_slip" [True] (()) => (Condition::NoSlip);
        /// No normal velocity and no tangential stress.
        "slip" [True] (()) => (Condition::Slip);
        /// No stress where fluid leaves (do-nothing): true in the form of the stress,
        /// `(2 mu D(u) - p) n = 0`, under which a channel flow spreads a little towards the side, as
        /// it does into the open; "gradient" in that of the gradient, `(mu grad u - p) n = 0`,
        /// under which it goes on as in a longer channel. A structure that reaches it leaves and
        /// exerts no force from then on; fluid that comes in is that outside.
        "open" [OpenForm] (form) => (Condition::Open(form));
        /// The pressure P, for a side that fluid crosses in either direction:
        /// `(mu grad u - p) n = -P n`.
        "pressure" [Stress, "Pa"] (p) => (Condition::Pressure(p));
        /// The pressure P of a reservoir: p = P where fluid leaves, `p + rho |u|^2 / 2 = P` where it
        /// comes in at a right angle.
        "total_pressure" [Stress, "Pa"] (p) => (Condition::TotalPressure(p));
        /// The force per area on the fluid: `(2 mu D(u) - p) n = t` where fluid leaves.
        "traction" [Components, "Pa"] (t) => (Condition::Traction(t));
        /// The name of the boundary that is the translate of this one, with the same flow.
        "periodic" [Text] (other) => (Condition::Periodic(other));
    }
}

/// The form of the stress that is zero on an open side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Opening {
    /// `(2 mu D(u) - p) n`.
    Stress,
    /// `(mu grad u - p) n`.
    Gradient,
}

impl Condition {
    /// True if fluid passes under a given stress.
    pub fn is_open(&self) -> bool {
        use Condition::{Open, Pressure, TotalPressure, Traction};
        matches!(self, Open(_) | Pressure(_) | TotalPressure(_) | Traction(_))
    }
}

kinds! {
    /// A pressure.
    Stress: Expression = Kind::Value("number or expression", Form::Expression), |i, c| i.expression(&c.constants);
}

/// True, or the word "gradient".
pub(in crate::scene) struct OpenForm;

impl Typed for OpenForm {
    type Out = Opening;
    const KIND: Kind = Kind::Value("true or \"gradient\"", Form::TrueOr("gradient"));
    fn read(item: &Item<'_>, context: &Context) -> Result<Opening> {
        match item.text() {
            Ok("gradient") => Ok(Opening::Gradient),
            Ok(_) => Err(item
                .error(format!("`{}` is no form of an open side", item.key))
                .remedy("write open = true (no stress) or open = \"gradient\"")),
            Err(_) => True::read(item, context).map(|()| Opening::Stress),
        }
    }
    fn toml(out: &Opening) -> String {
        match out {
            Opening::Stress => True::toml(&()),
            Opening::Gradient => text("gradient"),
        }
    }
}

/// A condition without a value.
pub(in crate::scene) struct True;

impl Typed for True {
    type Out = ();
    const KIND: Kind = Kind::Value("true", Form::True);
    fn read(item: &Item<'_>, _: &Context) -> Result<()> {
        if item.boolean()? {
            return Ok(());
        }
        let (key, all) = (&item.key, Condition::KEYS.names().collect::<Vec<_>>().join(", "));
        let condition = key.rsplit('.').next().unwrap_or(key);
        Err(item
            .error(format!("`{key}` can only be true"))
            .remedy(format!("write {condition} = true, or one of {all} instead")))
    }
    fn toml((): &()) -> String {
        "true".to_string()
    }
}

/// Reads all entries, in the order of the scene. By default there is no slip on the whole boundary,
/// or no condition if the velocity is `prescribed`.
pub(in crate::scene) fn read(
    item: Option<Item>,
    prescribed: bool,
    context: &Context,
) -> Result<Vec<Boundary>> {
    let Some(item) = item else {
        if prescribed {
            return Ok(Vec::new());
        }
        return Ok(vec![Boundary { name: WALLS.to_string(), condition: Condition::NoSlip }]);
    };
    let entries: Vec<(&str, Item)> = item.open_table()?.items().collect();
    let mut boundaries = Vec::new();
    for (name, item) in &entries {
        let condition = Condition::read(item, context)?;
        if prescribed && !matches!(condition, Condition::Periodic(_)) {
            return Err(item
                .key_error(
                    "a condition on a boundary means nothing where the velocity is prescribed",
                )
                .remedy("leave it out; only periodic sides matter then"));
        }
        boundaries.push(Boundary { name: name.to_string(), condition });
    }
    if boundaries.is_empty() {
        return Err(item
            .key_error("`boundary` is empty")
            .remedy("write [boundary.walls] with no_slip = true, or leave the table out"));
    }
    for (_, item) in &entries {
        check_pair(item, &boundaries)?;
    }
    Ok(boundaries)
}

/// Checks that a periodic boundary has one partner, another boundary without a condition of its
/// own.
fn check_pair(item: &Item, boundaries: &[Boundary]) -> Result<()> {
    let Some(item) = item.open_table()?.get("periodic") else { return Ok(()) };
    let name =
        item.key.strip_prefix("boundary.").and_then(|k| k.strip_suffix(".periodic")).unwrap_or("");
    let other = item.text()?;
    let partner = |b: &Boundary| {
        matches!(&b.condition, Condition::Periodic(p) if p == other) && b.name != name
    };
    let conflict = if other == name {
        Some(format!("`{name}` is periodic with itself"))
    } else if [name, other].contains(&WALLS) {
        Some("the whole boundary cannot be periodic".to_string())
    } else if boundaries.iter().any(partner) {
        Some(format!("`{other}` has two periodic partners"))
    } else {
        let own = boundaries.iter().find(|b| b.name == other).map(|b| &b.condition);
        own.filter(|c| !matches!(c, Condition::Periodic(back) if back == name))
            .map(|_| format!("`{other}` is periodic with `{name}` and has another condition"))
    };
    match conflict {
        None => Ok(()),
        Some(what) => Err(item
            .error(what)
            .remedy("pair each periodic boundary with one other that has no entry")),
    }
}

pub(in crate::scene) fn write(boundaries: &[Boundary], out: &mut Writer) {
    for b in boundaries {
        b.condition.section(&format!("[boundary.{}]", key(&b.name)), out);
    }
}
