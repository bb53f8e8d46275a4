//! Text of a chart: its extent, estimated from the advance widths of the typeface, and line breaks.

/// Typefaces in order of preference; the first two have the widths of [`ADVANCE`], the others are
/// narrower.
pub const TYPEFACES: &str = "DejaVu Sans, Verdana, Liberation Sans, Arial, sans-serif";
/// Size of an exponent over that of its base.
pub const RAISED: f64 = 0.75;
/// Advance widths of the characters from space to tilde, in thousandths of the size.
#[rustfmt::skip]
const ADVANCE: [u16; 95] = [
    318, 401, 460, 838, 636, 950, 780, 275, 390, 390, 500, 838, 318, 361, 318, 337,
    636, 636, 636, 636, 636, 636, 636, 636, 636, 636, 337, 337, 838, 838, 838, 531,
    1000, 684, 686, 698, 770, 632, 575, 775, 752, 295, 295, 656, 557, 863, 748, 787,
    603, 787, 695, 635, 611, 732, 684, 989, 685, 611, 685, 390, 337, 390, 838, 500,
    500, 613, 635, 550, 635, 615, 352, 635, 634, 278, 278, 579, 278, 974, 634, 612,
    635, 635, 411, 521, 392, 634, 592, 818, 592, 592, 525, 636, 337, 636, 838,
];

/// Width of a text in pixels at a font size in pixels.
pub fn width(text: &str, size: f64) -> f64 {
    let advance = |c: char| match (c as usize).checked_sub(32).and_then(|k| ADVANCE.get(k)) {
        Some(&w) => f64::from(w),
        None if c == '·' => 318.0,
        // Signs are as wide as the plus, letters of other alphabets hardly wider than a capital.
        None => 838.0,
    };
    text.chars().map(advance).sum::<f64>() * size / 1000.0
}

/// The text in lines of at most `room` pixels, broken at spaces that are not beside an equals sign,
/// and within a word that is longer than a line.
pub fn wrap(text: &str, size: f64, room: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in words(text) {
        if let Some(last) = lines.last_mut()
            && width(&format!("{last} {word}"), size) <= room
        {
            last.push(' ');
            last.push_str(&word);
            continue;
        }
        let mut line = String::new();
        for c in word.chars() {
            line.push(c);
            if line.chars().count() > 1 && width(&line, size) > room {
                line.pop();
                lines.push(std::mem::replace(&mut line, c.to_string()));
            }
        }
        lines.push(line);
    }
    lines
}

/// The parts between which a line may end.
fn words(text: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let mut glued = false;
    for word in text.split_whitespace() {
        match words.last_mut() {
            Some(last) if glued || word == "=" => {
                last.push(' ');
                last.push_str(word);
            }
            _ => words.push(word.into()),
        }
        glued = word == "=";
    }
    words
}

/// A number on an axis: a text and, raised behind it, an exponent.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Label {
    /// The number, or what stands before the exponent.
    pub text: String,
    /// The exponent, if any.
    pub exponent: Option<String>,
}

impl Label {
    /// The label of a number such as `-2.5e-7`: -2.5·10 and the exponent -7, with minus signs
    /// instead of hyphens.
    pub fn new(number: &str) -> Label {
        let signed = |s: &str| s.replace('-', "−");
        let Some((mantissa, exponent)) = number.split_once('e') else {
            return Label { text: signed(number), exponent: None };
        };
        let text = match mantissa {
            "1" => "10".into(),
            "-1" => "−10".into(),
            m => format!("{}·10", signed(m)),
        };
        Label { text, exponent: Some(signed(exponent)) }
    }
    /// Width in pixels at a font size in pixels.
    pub fn width(&self, size: f64) -> f64 {
        width(&self.text, size) + self.exponent.as_ref().map_or(0.0, |e| width(e, RAISED * size))
    }
}
