//! Numbers for people.

/// A number for people, with at most `digits` digits and without zeros at the end.
pub fn rounded(v: f64, digits: usize) -> String {
    let last = digits.max(1) - 1;
    // Rounded first: 9.9996 with four digits is 10.
    let scientific = format!("{v:.last$e}");
    let Some((mantissa, exponent)) = scientific.split_once('e') else { return v.to_string() };
    match exponent.parse::<i32>() {
        Ok(exponent) if (-3..6).contains(&exponent) => {
            trimmed(&format!("{v:.*}", (last as i32 - exponent).max(0) as usize))
        }
        _ => format!("{}e{exponent}", trimmed(mantissa)),
    }
}

/// A length for people: four decimals, or four digits where these would say nothing.
pub fn length(v: f64) -> String {
    if v == 0.0 || (0.01..1e4).contains(&v.abs()) { format!("{v:.4}") } else { rounded(v, 4) }
}

/// Without zeros at the end of the decimals, and without a negative zero.
pub(crate) fn trimmed(text: &str) -> String {
    let text =
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { text };
    if text == "-0" { "0".into() } else { text.into() }
}
