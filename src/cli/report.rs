//! Messages of errors on the terminal.

use crate::base::{Error, Kind, Snippet};
use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet as Excerpt, level};
use std::io::{IsTerminal, Write};
use std::panic::PanicHookInfo;

/// Prints an error on standard error and gives its exit code.
pub(super) fn error(error: &Error) -> u8 {
    let stderr = std::io::stderr();
    let colour = stderr.is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty());
    print(&text(error, colour));
    error.kind().exit_code()
}

/// Prints the message of clap, or its help, and gives the exit code.
pub(super) fn usage(error: &clap::Error) -> u8 {
    // Nothing is left to be done when the terminal is gone.
    let _ = error.print();
    if error.use_stderr() { Kind::Scene.exit_code() } else { 0 }
}

/// Reports a panic: a defect of this program, never of its input.
pub(super) fn defect(panic: &PanicHookInfo<'_>) {
    let payload = panic.payload();
    let literal = payload.downcast_ref::<&str>().copied();
    let message =
        literal.or(payload.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message");
    let place = panic.location().map_or_else(String::new, ToString::to_string);
    let error =
        Error::internal(format!("this is a defect of immersa, not of your input: {message}"))
            .at(place)
            .remedy("please report it with the scene and this message");
    print(&text(&error, false));
}

fn print(text: &str) {
    // A closed standard error must not become a second failure.
    let _ = writeln!(std::io::stderr().lock(), "{text}");
}

/// The message: with the line of the file and a caret where the error is about a text, else in
/// plain lines.
fn text(error: &Error, colour: bool) -> String {
    let Some(snippet) = error.source_snippet() else { return format!("error: {error}") };
    let renderer = if colour { Renderer::styled() } else { Renderer::plain() };
    let span = whole_characters(snippet);
    let marked = snippet.source.get(span.clone()).unwrap_or("");
    // The caret shows this value already.
    let label = Some(error.wrong_value()).filter(|v| !v.is_empty() && *v != marked);
    let annotation = AnnotationKind::Primary.span(span).label(label);
    let excerpt = Excerpt::source(&snippet.source).path(&snippet.path).annotation(annotation);
    let mut group = Level::ERROR.primary_title(error.what()).element(excerpt);
    for (level, line) in [
        (level::NOTE.with_name("at"), error.place()),
        (level::HELP.with_name("remedy"), error.advice()),
    ] {
        if !line.is_empty() {
            group = group.element(level.message(line));
        }
    }
    renderer.render(&[group])
}

/// The span of a snippet, moved to whole characters inside the source.
fn whole_characters(snippet: &Snippet) -> std::ops::Range<usize> {
    let boundary = |mut at: usize| {
        at = at.min(snippet.source.len());
        while !snippet.source.is_char_boundary(at) {
            at -= 1;
        }
        at
    };
    let start = boundary(snippet.span.start);
    start..boundary(snippet.span.end).max(start)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn placed(source: &str, span: std::ops::Range<usize>) -> Error {
        let snippet = Snippet { path: "scene.toml".into(), source: source.into(), span };
        Error::scene("`fluid.viscosity` must be positive")
            .at("scene.toml:2:13, key fluid.viscosity")
            .value("-1")
            .remedy("give a number > 0")
            .snippet(snippet)
    }

    #[test]
    fn the_line_is_shown_with_a_caret() {
        let shown = text(&placed("[fluid]\nviscosity = -1\n", 20..22), false);
        let expected = "\
error: `fluid.viscosity` must be positive
 --> scene.toml:2:13
  |
2 | viscosity = -1
  |             ^^
  |
  = at: scene.toml:2:13, key fluid.viscosity
  = remedy: give a number > 0";
        assert_eq!(shown, expected);
        assert!(text(&placed("[fluid]\nviscosity = -1\n", 20..22), true).contains("\u{1b}["));
    }

    #[test]
    fn an_error_without_a_text_is_plain() {
        let e = Error::input("the mesh cannot be read")
            .at("box.msh")
            .value("byte 7")
            .remedy("write it again");
        assert_eq!(
            text(&e, true),
            "error: the mesh cannot be read\n  at: box.msh\n  value: byte 7\n  remedy: write it \
             again"
        );
    }

    proptest! {
        #[test]
        fn no_source_and_no_span_panic(source in "[a-zé\\n\\r\\t\\x00 \"]*", start in 0..40usize, end in 0..40usize) {
            #[allow(clippy::reversed_empty_ranges, reason = "spans the wrong way round are part of the test")]
            let shown = text(&placed(&source, start..end), false);
            prop_assert!(shown.contains("must be positive") && shown.contains("give a number"));
        }
    }
}
