//! `units`: what the numbers of a scene are measured in. Nothing is converted.

use crate::base::Result;
use crate::scene::keys::{
    Absent, Context, Form, Item, Kind, Opt, Tabled, Text, Typed, table, text,
};

table! {
    /// Units of length, time and mass, each as it shall be written: with them the report gives a
    /// unit to each number that has one.
    BaseUnits: Default {
        /// The unit of length.
        length: Option<String> [Opt<Text>],
        /// The unit of time.
        time: Option<String> [Opt<Text>],
        /// The unit of mass.
        mass: Option<String> [Opt<Text>],
    }
}

/// Units of a scene, as they were given, and by what they measure where that is known.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Units {
    /// The text of the scene; empty for units in a table, or none.
    pub text: String,
    /// Units of length, time and mass.
    pub base: BaseUnits,
}

/// Systems that have a name.
const SYSTEMS: [(&str, [&str; 3]); 2] = [("si", ["m", "s", "kg"]), ("cgs", ["cm", "s", "g"])];
/// Symbols of units of length, time and mass.
const SYMBOLS: [&[&str]; 3] = [
    &["m", "dm", "cm", "mm", "um", "µm", "μm", "nm", "km"],
    &["s", "ms", "us", "µs", "μs", "ns", "min", "h"],
    &["kg", "g", "mg", "ug", "µg", "μg", "ng", "pg", "fg", "t"],
];

/// The kind of value of the key.
pub(in crate::scene) struct InUnits;

impl Typed for InUnits {
    type Out = Units;
    const KIND: Kind = Kind::Either("text", Form::Text, BaseUnits::KEYS);
    const ABSENT: Absent = Absent::Default("\"\"");
    fn read(item: &Item<'_>, context: &Context) -> Result<Units> {
        if item.is_table() {
            return Ok(Units { text: String::new(), base: BaseUnits::read(item, context)? });
        }
        let text = item.text()?.to_string();
        Ok(Units { base: named(&text), text })
    }
    fn toml(out: &Units) -> String {
        match out.text.is_empty() && out.base != BaseUnits::default() {
            true => out.base.inline(),
            false => text(&out.text),
        }
    }
}

/// The units that a text names: those of a system, or symbols of which no two measure the same.
/// None where any word is neither.
fn named(text: &str) -> BaseUnits {
    let words: Vec<&str> =
        text.split([',', ';', ' ']).map(str::trim).filter(|w| !w.is_empty()).collect();
    let mut found = [None, None, None];
    if let [word] = words[..]
        && let Some((_, symbols)) = SYSTEMS.iter().find(|s| s.0 == word.to_lowercase())
    {
        found = symbols.map(|s| Some(s.to_string()));
    } else {
        for word in words {
            let place = SYMBOLS.iter().position(|symbols| symbols.contains(&word));
            match place {
                Some(k) if found[k].is_none() => found[k] = Some(word.to_string()),
                _ => return BaseUnits::default(),
            }
        }
    }
    let [length, time, mass] = found;
    BaseUnits { length, time, mass }
}

/// Powers of length, time and mass.
type Powers = [f64; 3];

/// The powers in a quantity, by its name in words or by the end of the name of a column, in `d`
/// dimensions; in the plane everything is per unit of depth. `None` if the name says nothing.
fn powers(quantity: &str, d: usize) -> Option<Powers> {
    let n = d as f64;
    Some(match quantity {
        "time" => [0.0, 1.0, 0.0],
        "length" | "distance" | "perimeter" | "centre_x" | "centre_y" | "centre_z" | "axis_1"
        | "axis_2" | "axis_3" | "extent_x" | "extent_y" | "extent_z" | "markers_length"
        | "perimeter_smeared" | "perimeter_smereka1" | "perimeter_smereka2"
        | "perimeter_towers" => [1.0, 0.0, 0.0],
        "area" | "surface" | "markers_area" | "area_smeared" | "area_towers"
        | "surface_smeared" | "surface_smereka1" | "surface_smereka2" | "surface_towers" => {
            [2.0, 0.0, 0.0]
        }
        "volume" | "volume_smeared" | "volume_towers" => [3.0, 0.0, 0.0],
        "curvature_min" | "curvature_max" | "curvature_mean" | "torsion_min" | "torsion_max"
        | "torsion_mean" => [-1.0, 0.0, 0.0],
        "gauss_curvature_min" | "gauss_curvature_max" | "gauss_curvature_mean" => [-2.0, 0.0, 0.0],
        "speed" | "velocity" | "velocity_max" | "velocity_x" | "velocity_y" | "velocity_z" => {
            [1.0, -1.0, 0.0]
        }
        "vorticity" => [0.0, -1.0, 0.0],
        "divergence" => [0.5 * n, -1.0, 0.0],
        "pressure" => [-1.0, -2.0, 1.0],
        "energy" | "energy_kinetic" | "energy_elastic" | "energy_transferred" | "work"
        | "moment" => [n - 1.0, -2.0, 1.0],
        "dissipation" => [n - 1.0, -3.0, 1.0],
        "force" => [n - 2.0, -2.0, 1.0],
        "volume per time" => [n, -1.0, 0.0],
        _ => return None,
    })
}

impl Units {
    /// True if no unit is named.
    pub fn is_empty(&self) -> bool {
        self.text.is_empty() && self.base == BaseUnits::default()
    }
    /// The units in words, as they were given.
    pub fn words(&self) -> String {
        if !self.text.is_empty() {
            return self.text.clone();
        }
        let BaseUnits { length, time, mass } = &self.base;
        [length, time, mass].into_iter().flatten().cloned().collect::<Vec<_>>().join(", ")
    }
    /// The unit of a quantity in `d` dimensions: `mm/ms`. Empty for a pure number, and where it or
    /// a unit that it needs is not known.
    pub fn of(&self, quantity: &str, d: usize) -> String {
        let Some([length, time, mass]) = powers(quantity, d) else { return String::new() };
        let BaseUnits { length: l, time: t, mass: m } = &self.base;
        let (mut above, mut below) = (Vec::new(), Vec::new());
        for (unit, power) in [(m, mass), (l, length), (t, time)] {
            if power == 0.0 {
                continue;
            }
            let Some(unit) = unit else { return String::new() };
            let factor = format!("{unit}{}", raised(power.abs()));
            if power > 0.0 { above.push(factor) } else { below.push(factor) }
        }
        let above = if above.is_empty() { "1".to_string() } else { above.join("·") };
        match &below[..] {
            [] => above,
            [one] => format!("{above}/{one}"),
            many => format!("{above}/({})", many.join("·")),
        }
    }
    /// The name of a quantity with its unit behind it, if it has one: `speed (mm/ms)`.
    pub fn label(&self, quantity: &str, d: usize) -> String {
        match self.of(quantity, d).as_str() {
            "" => quantity.to_string(),
            unit => format!("{quantity} ({unit})"),
        }
    }
}

/// A positive power as an exponent.
fn raised(power: f64) -> String {
    match power {
        1.0 => String::new(),
        2.0 => "²".into(),
        3.0 => "³".into(),
        other => format!("^{other}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn units(text: &str) -> Units {
        Units { base: named(text), text: text.into() }
    }

    #[test]
    fn units_of_derived_quantities_are_products_of_powers() {
        let units = units("um, ms, pg");
        for (quantity, d, unit) in [
            ("time", 2, "ms"),
            ("perimeter", 2, "um"),
            ("speed", 3, "um/ms"),
            ("vorticity", 2, "1/ms"),
            ("pressure", 3, "pg/(um·ms²)"),
            // The energy of the fluid over an area is rho u^2 times that area.
            ("energy", 2, "pg·um/ms²"),
            ("energy", 3, "pg·um²/ms²"),
            ("dissipation", 3, "pg·um²/ms³"),
            ("force", 2, "pg/ms²"),
            ("force", 3, "pg·um/ms²"),
            ("volume per time", 2, "um²/ms"),
            ("divergence", 3, "um^1.5/ms"),
            ("ratio", 2, ""),
        ] {
            assert_eq!(units.of(quantity, d), unit, "{quantity} in {d}");
        }
        assert_eq!(units.label("speed", 2), "speed (um/ms)");
        assert_eq!(units.label("ratio", 2), "ratio");
    }

    #[test]
    fn a_text_names_units_or_is_only_said() {
        assert_eq!(units("SI").of("force", 3), "kg·m/s²");
        assert_eq!(units("g; cm; s").of("energy", 3), "g·cm²/s²");
        assert_eq!(units("mm, s").of("speed", 2), "mm/s");
        assert_eq!(units("mm, s").of("energy", 2), "", "the unit of mass is not known");
        for vague in ["pixels", "radii of the cell", "mm, cm, s", "lengths in mm", ""] {
            assert_eq!(units(vague).base, BaseUnits::default(), "{vague}");
            assert_eq!(units(vague).words(), vague);
        }
    }
}
