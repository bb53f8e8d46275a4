//! CSV (RFC 4180): one line of a file, written and read.

/// A line of entries that are written as they are.
pub(super) fn line(entries: impl IntoIterator<Item = String>) -> String {
    entries.into_iter().collect::<Vec<_>>().join(",") + "\n"
}

/// A line of names.
pub(super) fn names<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    line(names.into_iter().map(quoted))
}

/// A line of numbers.
pub(super) fn numbers(values: impl IntoIterator<Item = f64>) -> String {
    line(values.into_iter().map(number))
}

/// A number with the fewest digits that read back as the same bits.
pub(super) fn number(v: f64) -> String {
    // Debug writes an exponent where digits would be many.
    format!("{v:?}")
}

/// A text as an entry; a line break, which would end the line, becomes a space.
pub(super) fn quoted(text: &str) -> String {
    let text = text.replace(['\n', '\r'], " ");
    if text.contains([',', '"']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text }
}

/// The entries of a line.
pub(super) fn entries(line: &str) -> Vec<String> {
    let mut entries = vec![String::new()];
    let mut inside = false;
    let mut characters = line.trim_end_matches(['\n', '\r']).chars().peekable();
    while let Some(c) = characters.next() {
        match c {
            '"' if inside && characters.peek() == Some(&'"') => {
                characters.next();
                entries.last_mut().into_iter().for_each(|e| e.push('"'));
            }
            '"' => inside = !inside,
            ',' if !inside => entries.push(String::new()),
            c => entries.last_mut().into_iter().for_each(|e| e.push(c)),
        }
    }
    entries
}
