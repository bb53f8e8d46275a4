//! Laws of membranes: of area, of shear, of both.

use crate::base::Result;
use crate::elastic::{AreaLaw, Force, ShearLaw, SurfaceLaw};
use crate::scene::keys::{Absent::*, Context, Item, Keys, Kind::*, Table, Writer, number, row};

pub(super) static SHEARS: Keys = Keys {
    about: "The law of the energy E2(Z2) of shear: exactly one of these. Z2 is (l1/l2 + l2/l1)/2, l1 and l2 the principal stretches (3.41).",
    keys: &[
        row(
            "linear",
            Table(&MODULUS),
            "",
            OneOf,
            "E2' = modulus (Z2 - 1) (3.65): a small shear, for which Z2 - 1 is of second order, meets no resistance.",
        ),
        row("neo_hookean", Table(&MODULUS), "", OneOf, "E2' = modulus: resists small shears with this modulus."),
    ],
};

pub(super) static WHOLE: Keys = Keys {
    about: "A law of area and shear together: exactly one of these. The modulus is G, that of surface shear.",
    keys: &[
        row(
            "neo_hookean",
            Table(&MODULUS),
            "",
            OneOf,
            "A thin sheet of rubber: W = G/2 (l1^2 + l2^2 + 1/(l1 l2)^2 - 3); E_s = 3 G.",
        ),
        row(
            "skalak",
            Table(&SKALAK),
            "",
            OneOf,
            "Skalak's law for red blood cells: W = G/4 (I1^2 + 2 I1 - 2 I2 + C I2^2), I1 = l1^2 + l2^2 - 2, I2 = (l1 l2)^2 - 1.",
        ),
    ],
};

static SKALAK: Keys = Keys {
    about: "Skalak's law.",
    keys: &[
        row("modulus", Value("number >= 0"), "N/m", Required, "G, the surface shear modulus."),
        row("area_ratio", Value("number >= 0"), "", Required, "C: resistance to a change of area over that to shear."),
    ],
};

pub(super) static LAWS: Keys = Keys {
    about: "The law of the elastic energy E(r): exactly one of these. The tension is E'(r), r the stretch (3.13).",
    keys: &[
        row("linear", Table(&MODULUS), "", OneOf, "E'(r) = modulus (r - 1)."),
        row("one_sided", Table(&MODULUS), "", OneOf, "E'(r) = modulus max(r - 1, 0): no resistance to compression."),
        row("tension", Table(&TENSION), "", OneOf, "E'(r) = tension, whatever the stretch: a drop."),
    ],
};

static MODULUS: Keys = Keys {
    about: "A law with an elastic modulus.",
    keys: &[row("modulus", Value("number >= 0"), "N/m", Required, "Elastic modulus.")],
};

static TENSION: Keys = Keys {
    about: "Surface tension.",
    keys: &[row("tension", Value("number >= 0"), "N/m", Required, "Surface tension.")],
};

/// The law of the area, and that of a membrane which resists shear.
pub(super) fn read(table: &Table<'_>, force: Force, context: &Context) -> Result<(AreaLaw, Option<SurfaceLaw>)> {
    let (shear, whole) = (table.get("shear"), table.get("law"));
    if let Some(item) = shear.as_ref().or(whole.as_ref()) {
        if context.dimension == 2 {
            return Err(item
                .key_error("shear is for surfaces in space, and a membrane of the plane is a curve")
                .remedy("give the law of its length alone: area.linear = { modulus = 1 }"));
        }
        if force == Force::Sharp {
            return Err(item
                .key_error("a sharp force carries the stretch along the interface, but no shear")
                .remedy("take force = \"smeared\", or leave the shear out"));
        }
    }
    if let Some(item) = &whole {
        if let Some(other) = shear.as_ref().or(table.get("area").as_ref()) {
            return Err(other
                .key_error(format!("`law` is a law of area and shear together, and `{}` comes on top of it", other.key))
                .remedy("give `law` alone, or `area` and `shear`"));
        }
        let law = SurfaceLaw::read_whole(item)?;
        let [modulus, _, _] = law.response(1.0, 1.0).second;
        return Ok((AreaLaw::Linear { modulus }, Some(law)));
    }
    let remedy = "give the elastic law: area.linear = { modulus = 1 }";
    let area = table.required("area", remedy, AreaLaw::read)?;
    let shear = shear.as_ref().map(ShearLaw::read).transpose()?;
    Ok((area, shear.map(|shear| SurfaceLaw::Split { area, shear })))
}

fn modulus(item: &Item, law: &str) -> Result<f64> {
    item.table(&MODULUS)?.required("modulus", &format!("write {law} = {{ modulus = 1 }}"), Item::non_negative)
}

impl ShearLaw {
    fn read(item: &Item) -> Result<ShearLaw> {
        let (law, item) = item.table(&SHEARS)?.exactly_one(&SHEARS)?;
        let modulus = modulus(&item, law)?;
        Ok(if law == "linear" { ShearLaw::Linear { modulus } } else { ShearLaw::NeoHookean { modulus } })
    }
}

impl SurfaceLaw {
    fn read_whole(item: &Item) -> Result<SurfaceLaw> {
        let (law, item) = item.table(&WHOLE)?.exactly_one(&WHOLE)?;
        if law == "neo_hookean" {
            return Ok(SurfaceLaw::NeoHookean { modulus: modulus(&item, law)? });
        }
        let (table, remedy) = (item.table(&SKALAK)?, "write skalak = { modulus = 1, area_ratio = 1 }");
        Ok(SurfaceLaw::Skalak {
            modulus: table.required("modulus", remedy, Item::non_negative)?,
            area_ratio: table.required("area_ratio", remedy, Item::non_negative)?,
        })
    }
}

impl AreaLaw {
    fn read(item: &Item) -> Result<AreaLaw> {
        let (law, item) = item.table(&LAWS)?.exactly_one(&LAWS)?;
        let (parameter, keys) = if law == "tension" { ("tension", &TENSION) } else { ("modulus", &MODULUS) };
        let remedy = format!("write {law} = {{ {parameter} = 1 }}");
        let value = item.table(keys)?.required(parameter, &remedy, Item::non_negative)?;
        Ok(match law {
            "linear" => AreaLaw::Linear { modulus: value },
            "one_sided" => AreaLaw::OneSided { modulus: value },
            _ => AreaLaw::Tension { tension: value },
        })
    }

    /// The law as TOML.
    fn write(&self) -> String {
        match self {
            AreaLaw::Linear { modulus } => format!("{{ linear = {{ modulus = {} }} }}", number(*modulus)),
            AreaLaw::OneSided { modulus } => format!("{{ one_sided = {{ modulus = {} }} }}", number(*modulus)),
            AreaLaw::Tension { tension } => format!("{{ tension = {{ tension = {} }} }}", number(*tension)),
        }
    }
}

/// Writes the keys of the law of a membrane.
pub(super) fn write(area: AreaLaw, surface: Option<SurfaceLaw>, out: &mut Writer) {
    match surface {
        None => out.entry("area", area.write()),
        Some(SurfaceLaw::Split { area, shear }) => {
            out.entry("area", area.write());
            let (law, modulus) = match shear {
                ShearLaw::Linear { modulus } => ("linear", modulus),
                ShearLaw::NeoHookean { modulus } => ("neo_hookean", modulus),
            };
            out.entry("shear", format_args!("{{ {law} = {{ modulus = {} }} }}", number(modulus)));
        }
        Some(SurfaceLaw::NeoHookean { modulus }) => {
            let modulus = number(modulus);
            out.entry("law", format_args!("{{ neo_hookean = {{ modulus = {modulus} }} }}"));
        }
        Some(SurfaceLaw::Skalak { modulus, area_ratio }) => {
            let (g, c) = (number(modulus), number(area_ratio));
            out.entry("law", format_args!("{{ skalak = {{ modulus = {g}, area_ratio = {c} }} }}"));
        }
    }
}

/// A law of area in words.
fn area_words(law: AreaLaw) -> String {
    match law {
        AreaLaw::Linear { modulus } => format!("E'(r) = {modulus} (r - 1)"),
        AreaLaw::OneSided { modulus } => format!("E'(r) = {modulus} max(r - 1, 0)"),
        AreaLaw::Tension { tension } => format!("constant tension {tension}"),
    }
}

/// The law of a membrane in words.
pub(super) fn words(area: AreaLaw, surface: Option<SurfaceLaw>) -> String {
    match surface {
        None => area_words(area),
        Some(SurfaceLaw::Split { area: first, shear }) => {
            let shear = match shear {
                ShearLaw::Linear { modulus } => format!("E2'(Z2) = {modulus} (Z2 - 1)"),
                ShearLaw::NeoHookean { modulus } => format!("E2'(Z2) = {modulus}"),
            };
            format!("{} and {shear}", area_words(first))
        }
        Some(SurfaceLaw::NeoHookean { modulus }) => format!("the neo-Hookean law, G = {modulus}"),
        Some(SurfaceLaw::Skalak { modulus, area_ratio }) => {
            format!("Skalak's law, G = {modulus}, C = {area_ratio}")
        }
    }
}
