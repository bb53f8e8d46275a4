//! Escaping, common to XML and HTML.

use std::fmt::Write;

/// `text` with the five characters that XML and HTML reserve replaced, safe as content and inside
/// quoted attributes. Control characters that XML forbids become the replacement character.
pub(super) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            '\n' | '\t' | '\r' => out.push(c),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

/// The path of a file as a relative address, safe inside quoted attributes.
pub(super) fn address(path: &str) -> String {
    let mut out = String::with_capacity(path.len());
    for byte in path.bytes() {
        match byte {
            b if b.is_ascii_alphanumeric() || b"-._~/,=+".contains(&b) => out.push(char::from(b)),
            // Writing to a String cannot fail.
            b => drop(write!(out, "%{b:02X}")),
        }
    }
    out
}

/// `text` [escaped](escape), with the numbers that have an exponent kept whole: a browser would
/// break them at its sign.
pub(super) fn prose(text: &str) -> String {
    let exponent = |w: &str| {
        w.split_once("e-").is_some_and(|(before, after)| {
            before.ends_with(|c: char| c.is_ascii_digit())
                && after.starts_with(|c: char| c.is_ascii_digit())
        })
    };
    let word = |w: &str| match (exponent(w), w.strip_suffix([' ', '\n'])) {
        (false, _) => escape(w),
        (true, None) => format!("<span class=\"whole\">{}</span>", escape(w)),
        (true, Some(number)) => {
            format!("<span class=\"whole\">{}</span>{}", escape(number), &w[number.len()..])
        }
    };
    text.split_inclusive([' ', '\n']).map(word).collect()
}

/// The inverse of [`escape`].
pub(super) fn unescape(text: &str) -> String {
    let pairs = [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&#39;", "'"), ("&amp;", "&")];
    pairs.iter().fold(text.to_string(), |t, (from, to)| t.replace(from, to))
}

/// The value of attribute `name` in the text of a tag, such as `<A b="1" c="2"`.
pub(super) fn attribute(tag: &str, name: &str) -> Option<String> {
    let mut rest = tag;
    while let Some(at) = rest.find(name) {
        let before = rest[..at].chars().next_back();
        rest = &rest[at + name.len()..];
        if before.is_some_and(char::is_whitespace)
            && let Some(value) = rest.strip_prefix("=\"")
        {
            return value.find('"').map(|end| unescape(&value[..end]));
        }
    }
    None
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Fails unless every tag is closed in order, attributes are quoted and `&` only begins an
    /// entity.
    pub fn assert_well_formed(xml: &str) {
        let mut open = Vec::new();
        let mut rest = xml;
        while let Some(at) = rest.find('<') {
            assert_entities(&rest[..at]);
            rest = &rest[at..];
            if let Some(comment) = rest.strip_prefix("<!--") {
                rest = &comment[comment.find("-->").expect("end of comment") + 3..];
                continue;
            }
            // Text in scripts is as it is.
            if rest.starts_with("<script") {
                rest = &rest[rest.find("</script>").expect("end of script") + 9..];
                continue;
            }
            let end = rest.find('>').unwrap_or_else(|| panic!("no end of tag: {rest:.80}"));
            let (tag, after) = (&rest[1..end], &rest[end + 1..]);
            assert_eq!(tag.matches('"').count() % 2, 0, "quotes of <{tag:.80}>");
            assert!(!tag.contains('<'), "< within <{tag:.80}>");
            assert_entities(tag);
            let name =
                tag.trim_start_matches('/').split([' ', '\n', '/']).next().unwrap_or_default();
            if tag.starts_with('/') {
                assert_eq!(open.pop(), Some(name), "closing tags in order");
            } else if !tag.ends_with('/') && !tag.starts_with(['!', '?']) {
                open.push(name);
            }
            rest = after;
        }
        assert_entities(rest);
        assert!(open.is_empty(), "tags left open: {open:?}");
    }

    fn assert_entities(text: &str) {
        for piece in text.split('&').skip(1) {
            let name = piece.split(';').next().unwrap_or_default();
            assert!(name.len() < 8 && name.len() < piece.len(), "a bare & before {piece:.40}");
        }
    }

    #[test]
    fn attributes_are_found_by_their_whole_name() {
        let tag = r#"<DataArray OtherName="x" Name="a &lt; b" type="Float64""#;
        assert_eq!(attribute(tag, "Name").as_deref(), Some("a < b"));
        assert_eq!(attribute(tag, "type").as_deref(), Some("Float64"));
        assert_eq!(attribute(tag, "offset"), None);
    }

    proptest! {
        #[test]
        fn escaping_is_undone_and_leaves_no_reserved_character(text in "[ -~é→]*") {
            let e = escape(&text);
            prop_assert!(!e.contains(['<', '>', '"', '\'']));
            prop_assert_eq!(unescape(&e), text);
        }
    }
}
