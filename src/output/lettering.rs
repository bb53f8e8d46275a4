//! Text on images, drawn as strokes like the lettering of a technical drawing. The letters are our
//! own.
//!
//! A letter is a path in units of a tenth of the height of a capital, from the left end of the
//! baseline, y upward: `M x y` moves, `L x y` draws a straight line, `C` a cubic curve, `V x y` a
//! quarter of an ellipse that leaves vertically, `H x y` one that leaves horizontally.

use super::raster::{Image, Ink, Segment};

/// Anchor of a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Align {
    Left,
    Centre,
    Right,
}

/// Space between letters.
const GAP: f64 = 2.5;

/// Width of `text` in pixels if its capitals are `size` pixels high.
pub(super) fn width(text: &str, size: f64) -> f64 {
    let units: f64 = text.chars().map(|c| glyph(c).0 + GAP).sum();
    (units - GAP).max(0.0) * size / 10.0
}

/// Draws `text` with its baseline at `at` and capitals `size` pixels high.
pub(super) fn draw(image: &mut Image, text: &str, at: [f64; 2], size: f64, align: Align, ink: Ink) {
    let shift = match align {
        Align::Left => 0.0,
        Align::Centre => 0.5,
        Align::Right => 1.0,
    };
    let mut x = at[0] - shift * width(text, size);
    for c in text.chars() {
        let (advance, strokes) = glyph(c);
        let place = |p: [f64; 2]| [x + p[0] * size / 10.0, at[1] - p[1] * size / 10.0];
        let strokes: Vec<Segment> = strokes.iter().map(|s| s.map(place)).collect();
        image.stroke(&strokes, 0.125 * size, ink);
        x += (advance + GAP) * size / 10.0;
    }
}

/// Width and strokes of a letter; an empty box for one that is not in the table.
fn glyph(c: char) -> (f64, Vec<Segment>) {
    let (base, accent) = decomposed(c);
    let find = |c: char| GLYPHS.iter().find(|g| g.0 == c);
    let Some(&(_, width, path)) = find(base) else { return (6.0, trace("M0 0L6 0L6 10L0 10L0 0")) };
    let mut strokes = trace(path);
    if let Some(path) = accent {
        let raise = if base.is_uppercase() { 3.0 } else { 0.0 };
        strokes.extend(trace(path).iter().map(|s| s.map(|p| [p[0] + 0.5 * width, p[1] + raise])));
    }
    (width, strokes)
}

/// An accented letter as its base and the path of the accent, around x = 0 above a small letter.
fn decomposed(c: char) -> (char, Option<&'static str>) {
    let found = ACCENTED.iter().find_map(|(letters, bases, path)| {
        letters
            .chars()
            .zip(bases.chars())
            .find(|(l, _)| *l == c)
            .map(|(_, base)| (base, Some(*path)))
    });
    found.unwrap_or((c, None))
}

/// The segments of a path.
fn trace(path: &str) -> Vec<Segment> {
    let mut segments = Vec::new();
    let mut pen = [0.0; 2];
    for command in
        path.split_inclusive(|c: char| c.is_ascii_alphabetic()).collect::<Vec<_>>().windows(2)
    {
        let kind = command[0].chars().next_back().unwrap_or('M');
        let numbers = command[1].trim_end_matches(|c: char| c.is_ascii_alphabetic());
        let n: Vec<f64> = numbers.split_whitespace().filter_map(|v| v.parse().ok()).collect();
        let Some(&[x, y]) = n.last_chunk::<2>() else { continue };
        let end = [x, y];
        let bend = 0.5523; // a quarter of an ellipse as a cubic
        match (kind, n.as_slice()) {
            ('L', _) => segments.push([pen, end]),
            ('V', _) => {
                let controls =
                    [[pen[0], pen[1] + bend * (y - pen[1])], [x + bend * (pen[0] - x), y]];
                curve(&mut segments, pen, controls, end);
            }
            ('H', _) => {
                let controls =
                    [[pen[0] + bend * (x - pen[0]), pen[1]], [x, y + bend * (pen[1] - y)]];
                curve(&mut segments, pen, controls, end);
            }
            ('C', &[a, b, c, d, ..]) => curve(&mut segments, pen, [[a, b], [c, d]], end),
            _ => {}
        }
        pen = end;
    }
    segments
}

/// A cubic Bezier curve as eight segments.
fn curve(segments: &mut Vec<Segment>, start: [f64; 2], [a, b]: [[f64; 2]; 2], end: [f64; 2]) {
    let mut last = start;
    for k in 1..=8 {
        let t = f64::from(k) / 8.0;
        let s = 1.0 - t;
        let at = |i: usize| {
            s * s * s * start[i]
                + 3.0 * s * s * t * a[i]
                + 3.0 * s * t * t * b[i]
                + t * t * t * end[i]
        };
        let next = [at(0), at(1)];
        segments.push([last, next]);
        last = next;
    }
}

const ACCENTED: &[(&str, &str, &str)] = &[
    ("áéíóúýÁÉÍÓÚÝ", "aeıouyAEIOUY", "M-0.6 8.4L1 10.4"),
    ("àèìòùÀÈÌÒÙ", "aeıouAEIOU", "M0.6 8.4L-1 10.4"),
    ("âêîôûÂÊÎÔÛ", "aeıouAEIOU", "M-1.6 8.4L0 10L1.6 8.4"),
    ("äëïöüÄËÏÖÜ", "aeıouAEIOU", "M-1.3 9.2L-1.3 9.4M1.3 9.2L1.3 9.4"),
    ("ñãõÑÃÕ", "naoNAO", "M-1.8 8.8C-0.8 10.4 0.8 8 1.8 9.6"),
    ("çÇ", "cC", "M0.3 0L-0.2 -2.4"),
    ("åÅ", "aA", "M0 8.4H-1 9.4V0 10.4H1 9.4V0 8.4"),
];

/// Letter, width, path.
const GLYPHS: &[(char, f64, &str)] = &[
    (' ', 2.2, ""),
    ('!', 0.6, "M0.3 10L0.3 3M0.3 0L0.3 0.2"),
    ('"', 2.6, "M0.3 10L0.3 7.4M2.3 10L2.3 7.4"),
    ('#', 6.6, "M1.4 0L2.8 10M4 0L5.4 10M0.4 6.6L6.6 6.6M0 3.4L6.2 3.4"),
    ('$', 6.0, "M5.6 8V3 10H0.4 7.6V3 5.2H5.9 2.6V3 0H0 2.2M3 11.4L3 -1.4"),
    (
        '%',
        8.4,
        "M7 10L1.4 0M1.9 10H0 7.8V1.9 5.6H3.8 7.8V1.9 10M6.5 4.4H4.6 2.2V6.5 0H8.4 2.2V6.5 4.4",
    ),
    ('&', 7.4, "M7.4 0L1.8 7C0.4 8.8 1.6 10 3 10H4.8 8.3C4.8 5.9 0 5.4 0 2.6V2.8 0H6.8 4.6"),
    ('\'', 0.6, "M0.3 10L0.3 7.4"),
    ('(', 2.4, "M2.4 11H0 4.5V2.4 -2"),
    (')', 2.4, "M0 11H2.4 4.5V0 -2"),
    ('*', 4.4, "M2.2 9.6L2.2 4.8M0.1 8.4L4.3 6M4.3 8.4L0.1 6"),
    ('+', 6.0, "M3 7.4L3 1.4M0 4.4L6 4.4"),
    (',', 1.0, "M0.7 0.3L0.1 -1.9"),
    ('-', 3.6, "M0 4L3.6 4"),
    ('−', 5.6, "M0 4.4L5.6 4.4"),
    ('.', 0.8, "M0.4 0L0.4 0.2"),
    ('/', 4.4, "M0 -1L4.4 10.6"),
    ('0', 5.6, "M2.8 10H0 5V2.8 0H5.6 5V2.8 10"),
    ('1', 5.6, "M0.9 8.2L3.2 10L3.2 0"),
    ('2', 5.6, "M0.3 7.4V2.8 10H5.3 7.4C5.3 4.8 2.2 3 0.2 0L5.6 0"),
    ('3', 5.6, "M0.4 8V2.8 10H5.2 7.6V2.4 5.4H5.6 2.7V2.7 0H0 2.2"),
    ('4', 5.6, "M4.2 0L4.2 10L0 3L5.8 3"),
    ('5', 5.6, "M5.1 10L0.9 10L0.5 5.4C1.1 6 1.9 6.4 2.8 6.4H5.6 3.2V2.7 0H0 2"),
    ('6', 5.6, "M5 8.6C4.6 9.6 4 10 3.1 10H0 4.2L0 3.2V2.8 0H5.6 3.2V2.8 6.3H0 3.2"),
    ('7', 5.6, "M0 10L5.6 10L2 0"),
    ('8', 5.6, "M2.8 10H0.4 7.7V2.8 5.4H5.2 7.7V2.8 10M2.8 5.4H0 2.7V2.8 0H5.6 2.7V2.8 5.4"),
    ('9', 5.6, "M0.6 1.4C1 0.4 1.6 0 2.5 0H5.6 5.8L5.6 6.8V2.8 10H0 6.8V2.8 3.7H5.6 6.8"),
    (':', 0.8, "M0.4 0L0.4 0.2M0.4 5.6L0.4 5.8"),
    (';', 1.0, "M0.7 0.3L0.1 -1.9M0.6 5.6L0.6 5.8"),
    ('<', 5.6, "M5.6 8L0 4.4L5.6 0.8"),
    ('=', 5.6, "M0 5.8L5.6 5.8M0 3L5.6 3"),
    ('>', 5.6, "M0 8L5.6 4.4L0 0.8"),
    ('?', 4.8, "M0.2 7.9V2.4 10H4.8 7.6C4.8 5.4 2.3 5.4 2.3 3M2.3 0L2.3 0.2"),
    (
        '@',
        9.0,
        "M6.4 3.9V4.4 6.2H2.6 3.9V4.4 1.6H6.4 3.9V7.8 1.6H9 4.6V4.5 9.4H0 4V4.5 -1.6C5.6 -1.6 6.4 \
         -1.4 7.2 -1",
    ),
    ('A', 7.0, "M0 0L3.5 10L7 0M1.22 3.5L5.78 3.5"),
    ('B', 6.0, "M0 5.3L0 10L3 10H5.4 7.65V3 5.3L0 5.3L0 0L3 0H6 2.65V3 5.3"),
    ('C', 6.8, "M6.7 7.6V3.8 10H0 5V3.8 0H6.7 2.4"),
    ('D', 6.8, "M0 0L0 10L2.4 10H6.8 5V2.4 0L0 0"),
    ('E', 5.4, "M5.4 0L0 0L0 10L5.4 10M0 5.2L4.7 5.2"),
    ('F', 5.2, "M0 0L0 10L5.2 10M0 5.2L4.5 5.2"),
    ('G', 7.0, "M6.7 7.6V3.8 10H0 5V3.8 0H7 3L7 4.6L4.2 4.6"),
    ('H', 6.6, "M0 0L0 10M6.6 0L6.6 10M0 5.2L6.6 5.2"),
    ('I', 0.6, "M0.3 0L0.3 10"),
    ('J', 4.0, "M4 10L4 2.6V2 0H0 2.4"),
    ('K', 6.2, "M0 0L0 10M6 10L0 3.9M2.2 6.1L6.3 0"),
    ('L', 5.0, "M0 10L0 0L5 0"),
    ('M', 8.0, "M0 0L0 10L4 2.4L8 10L8 0"),
    ('N', 6.8, "M0 0L0 10L6.8 0L6.8 10"),
    ('O', 7.6, "M3.8 10H0 5V3.8 0H7.6 5V3.8 10"),
    ('P', 5.8, "M0 0L0 10L3 10H5.8 7.3V3 4.6L0 4.6"),
    ('Q', 7.6, "M3.8 10H0 5V3.8 0H7.6 5V3.8 10M4.8 2.4L7.4 -0.8"),
    ('R', 6.2, "M0 0L0 10L3 10H5.8 7.3V3 4.6L0 4.6M3.2 4.6L6.2 0"),
    ('S', 5.9, "M5.6 7.9V3 10H0.4 7.6V3 5.2H5.9 2.6V3 0H0 2.3"),
    ('T', 6.4, "M0 10L6.4 10M3.2 10L3.2 0"),
    ('U', 6.6, "M0 10L0 3.4V3.3 0H6.6 3.4L6.6 10"),
    ('V', 7.0, "M0 10L3.5 0L7 10"),
    ('W', 10.0, "M0 10L2.4 0L5 8.8L7.6 0L10 10"),
    ('X', 6.6, "M0 0L6.4 10M0.2 10L6.6 0"),
    ('Y', 6.6, "M0 10L3.3 5L6.6 10M3.3 5L3.3 0"),
    ('Z', 6.0, "M0.2 10L5.9 10L0 0L6.1 0"),
    ('[', 2.2, "M2.2 11L0 11L0 -2L2.2 -2"),
    ('\\', 4.4, "M0 10.6L4.4 -1"),
    (']', 2.2, "M0 11L2.2 11L2.2 -2L0 -2"),
    ('^', 4.8, "M0 6.6L2.4 10L4.8 6.6"),
    ('_', 5.4, "M0 -1.6L5.4 -1.6"),
    ('`', 1.6, "M0 10L1.6 8.2"),
    ('a', 4.8, "M0.5 5.6V2.6 7H4.8 4.7L4.8 0M4.8 4.1L2.4 4.1H0 2V2 0H4.8 2.4"),
    ('b', 5.2, "M0 10L0 0M0 3.5V2.6 7H5.2 3.5V2.6 0H0 3.5"),
    ('c', 4.6, "M4.6 5.3V2.6 7H0 3.5V2.6 0H4.6 1.7"),
    ('d', 5.2, "M5.2 10L5.2 0M5.2 3.5V2.6 7H0 3.5V2.6 0H5.2 3.5"),
    ('e', 5.0, "M0.1 3.8L5 3.8V2.6 7H0 3.5V2.7 0C3.7 0 4.5 0.5 4.9 1.6"),
    ('f', 3.2, "M3.4 10H1.2 7.8L1.2 0M0 6.8L3.1 6.8"),
    ('g', 5.2, "M5.2 7L5.2 -0.4V2.6 -3C1.6 -3 0.8 -2.7 0.3 -1.9M5.2 3.5V2.6 7H0 3.5V2.6 0H5.2 3.5"),
    ('h', 4.8, "M0 10L0 0M0 4.2V2.6 7H4.8 4.4L4.8 0"),
    ('i', 0.6, "M0.3 7L0.3 0M0.3 9.5L0.3 9.7"),
    ('ı', 0.6, "M0.3 7L0.3 0"),
    ('j', 1.4, "M1.1 7L1.1 -1.2V-0.5 -3M1.1 9.5L1.1 9.7"),
    ('k', 4.7, "M0 10L0 0M4.4 7L0 2.7M1.7 4.4L4.8 0"),
    ('l', 1.6, "M0.3 10L0.3 1.5V1.7 0"),
    ('m', 8.0, "M0 7L0 0M0 4.2V2.2 7H4 4.6L4 0M4 4.2V6.2 7H8 4.6L8 0"),
    ('n', 4.8, "M0 7L0 0M0 4.2V2.6 7H4.8 4.4L4.8 0"),
    ('o', 5.4, "M2.7 7H0 3.5V2.7 0H5.4 3.5V2.7 7"),
    ('p', 5.2, "M0 7L0 -3M0 3.5V2.6 7H5.2 3.5V2.6 0H0 3.5"),
    ('q', 5.2, "M5.2 7L5.2 -3M5.2 3.5V2.6 7H0 3.5V2.6 0H5.2 3.5"),
    ('r', 2.8, "M0 7L0 0M0 4V2.9 7"),
    ('s', 4.2, "M4 5.4V2.1 7H0.2 5.2V2.1 3.6H4.2 1.8V2.1 0H0 1.6"),
    ('t', 3.1, "M1.2 9.2L1.2 2V3.2 0M0 6.8L3.1 6.8"),
    ('u', 4.8, "M0 7L0 2.6V2.2 0H4.8 2.8M4.8 7L4.8 0"),
    ('v', 5.0, "M0 7L2.5 0L5 7"),
    ('w', 7.4, "M0 7L1.8 0L3.7 6.3L5.6 0L7.4 7"),
    ('x', 4.8, "M0 0L4.7 7M0.1 7L4.8 0"),
    ('y', 5.0, "M0 7L2.5 0M5 7L1.4 -3"),
    ('z', 4.4, "M0.1 7L4.3 7L0 0L4.5 0"),
    ('{', 2.8, "M2.8 11H1.4 9.4L1.4 6V0 4.5H1.4 3L1.4 -0.4V2.8 -2"),
    ('|', 0.6, "M0.3 11L0.3 -2"),
    ('}', 2.8, "M0 11H1.4 9.4L1.4 6V2.8 4.5H1.4 3L1.4 -0.4V0 -2"),
    ('~', 5.6, "M0 3.8C1.4 6.2 4.2 2.4 5.6 4.8"),
    ('·', 0.8, "M0.4 4.2L0.4 4.4"),
    ('×', 5.0, "M0 1.6L5 6.8M0 6.8L5 1.6"),
    ('°', 2.6, "M1.3 10H0 8.7V1.3 7.4H2.6 8.7V1.3 10"),
    ('φ', 6.0, "M3 10L3 -3M3 7H0 3.5V3 0H6 3.5V3 7"),
    ('µ', 4.8, "M0 7L0 -3M0 2.6V2.2 0H4.8 2.8M4.8 7L4.8 0"),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_letter_stays_in_its_box() {
        for (c, width, _) in GLYPHS {
            let (advance, strokes) = glyph(*c);
            assert_eq!(advance, *width);
            assert!(*c == ' ' || !strokes.is_empty(), "{c} is blank");
            for [x, y] in strokes.iter().flatten() {
                assert!(
                    (-0.6..=advance + 0.6).contains(x) && (-3.1..=11.5).contains(y),
                    "{c}: {x} {y}"
                );
            }
        }
        for c in (32u8..127).map(char::from).chain("éÀçñ".chars()) {
            assert!(GLYPHS.iter().any(|g| g.0 == decomposed(c).0), "{c} is missing");
        }
        assert_eq!(glyph('漢').1.len(), 4);
    }

    #[test]
    fn letters_differ() {
        let drawn = |c: char| {
            let mut image = Image::white(24, 30);
            draw(&mut image, &c.to_string(), [4.0, 22.0], 18.0, Align::Left, Ink::solid([0; 3]));
            image
        };
        let images: Vec<_> = ('!'..='~').map(|c| (c, drawn(c))).collect();
        for (i, (a, x)) in images.iter().enumerate() {
            assert!(images[..i].iter().all(|(_, y)| x != y), "{a} looks like another letter");
        }
    }

    #[test]
    fn text_is_where_it_was_asked_for() {
        let columns = |align| {
            let mut image = Image::white(200, 40);
            draw(&mut image, "HIH", [100.0, 30.0], 20.0, align, Ink::solid([0; 3]));
            let dark: Vec<usize> =
                (0..200).filter(|&x| (0..40).any(|y| image.pixel(x, y)[0] < 128)).collect();
            (dark[0] as f64, *dark.last().unwrap() as f64)
        };
        let w = width("HIH", 20.0);
        assert!((columns(Align::Left).0 - 99.0).abs() <= 1.0);
        assert!((columns(Align::Right).1 - 100.0).abs() <= 1.0);
        let (a, b) = columns(Align::Centre);
        assert!((0.5 * (a + b) - 99.5).abs() <= 1.0 && (b - a - w).abs() <= 3.0);
    }
}
