//! Constitutive laws of membranes: for area, for shear, for both.

use crate::base::Result;
use crate::elastic::{AreaLaw, ShearLaw, SurfaceLaw};
use crate::scene::keys::{Context, Nested, NonNegative, Table, one_of, table};

one_of! {
    /// The law of the energy E2(Z2) of shear: exactly one of these. Z2 is (l1/l2 + l2/l1)/2, l1 and
    /// l2 the principal stretches (3.41).
    ShearLaw {
        /// E2' = modulus (Z2 - 1) (3.65): a small shear, for which Z2 - 1 is of second order, meets
        /// no resistance.
        "linear" [Nested<Modulus>] (Modulus { modulus }) => (ShearLaw::Linear { modulus });
        /// E2' = modulus: resists small shears with this modulus.
        "neo_hookean" [Nested<Modulus>] (Modulus { modulus }) => (ShearLaw::NeoHookean { modulus });
    }
}

one_of! {
    /// A law of area and shear together: exactly one of these. The modulus is G, that of surface
    /// shear.
    SurfaceLaw {
        /// A thin sheet of rubber: W = G/2 (l1^2 + l2^2 + 1/(l1 l2)^2 - 3); E_s = 3 G.
        "neo_hookean" [Nested<Modulus>] (Modulus { modulus }) => (SurfaceLaw::NeoHookean { modulus });
        /// Skalak's law for red blood cells: W = G/4 (I1^2 + 2 I1 - 2 I2 + C I2^2), I1 = l1^2 +
        /// l2^2 - 2, I2 = (l1 l2)^2 - 1.
        "skalak" [Nested<Skalak>]
            (Skalak { modulus, area_ratio }) => (SurfaceLaw::Skalak { modulus, area_ratio });
    }
}

table! {
    /// Skalak's law.
    Skalak: Copy {
        /// G, the surface shear modulus.
        modulus: f64 [NonNegative, "N/m",
            Required("write skalak = { modulus = 1, area_ratio = 1 }")],
        /// C: resistance to a change of area over that to shear.
        area_ratio: f64 [NonNegative, Required("write skalak = { modulus = 1, area_ratio = 1 }")],
    }
}

one_of! {
    /// The law of the elastic energy E(r): exactly one of these. The tension is E'(r), r the
    /// stretch (3.13).
    AreaLaw {
        /// E'(r) = modulus (r - 1).
        "linear" [Nested<Modulus>] (Modulus { modulus }) => (AreaLaw::Linear { modulus });
        /// E'(r) = modulus max(r - 1, 0): no resistance to compression.
        "one_sided" [Nested<Modulus>] (Modulus { modulus }) => (AreaLaw::OneSided { modulus });
        /// E'(r) = tension, whatever the stretch: a drop.
        "tension" [Nested<Tension>] (Tension { tension }) => (AreaLaw::Tension { tension });
    }
}

table! {
    /// A law with an elastic modulus.
    Modulus: Copy {
        /// Elastic modulus.
        modulus: f64 [NonNegative, "N/m", Required("write {here} = { modulus = 1 }")],
    }
}

table! {
    /// Surface tension.
    Tension: Copy {
        /// Surface tension.
        tension: f64 [NonNegative, "N/m", Required("write {here} = { tension = 1 }")],
    }
}

/// Rejects laws that exclude each other, or that are not available for the force or the dimension.
pub(super) fn check(table: &Table<'_>, context: &Context) -> Result<()> {
    let (shear, whole) = (table.get("shear"), table.get("law"));
    if let (2, Some(item)) = (context.dimension, shear.as_ref().or(whole.as_ref())) {
        return Err(item
            .key_error("shear is for surfaces in space, and a membrane of the plane is a curve")
            .remedy("give the law of its length alone: area.linear = { modulus = 1 }"));
    }
    if whole.is_some() {
        return match shear.as_ref().or(table.get("area").as_ref()) {
            None => Ok(()),
            Some(other) => Err(other
                .key_error(format!(
                    "`law` is a law of area and shear together, and `{}` comes on top of it",
                    other.key
                ))
                .remedy("give `law` alone, or `area` and `shear`")),
        };
    }
    table.required("area", "give the elastic law: area.linear = { modulus = 1 }", |_| Ok(()))
}

/// A law of area in words.
fn area_words(law: AreaLaw) -> String {
    match law {
        AreaLaw::Linear { modulus } => format!("E'(r) = {modulus} (r - 1)"),
        AreaLaw::OneSided { modulus } => format!("E'(r) = {modulus} max(r - 1, 0)"),
        AreaLaw::Tension { tension } => format!("constant tension {tension}"),
        AreaLaw::Surfactant { tension, elasticity } => {
            format!("the tension {tension} - {elasticity} c, c the concentration of a surfactant")
        }
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
