//! Errors and warnings as values: description, place, wrong value and remedy.

use std::fmt;
use std::ops::Range;

/// The result type of the whole crate.
pub type Result<T> = std::result::Result<T, Error>;

/// Kind of an error; sets the exit code of the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A defect of this program (exit code 1).
    Internal,
    /// The command line or the scene is wrong (exit code 2).
    Scene,
    /// The mesh or another input or output file is wrong (exit code 3).
    Input,
    /// The computation failed: blow-up, no convergence, out of memory (exit code 4).
    Computation,
    /// Stopped by the user; the run can be resumed (exit code 130).
    Interrupted,
}

impl Kind {
    /// The exit code of the program for this kind of error.
    pub fn exit_code(self) -> u8 {
        match self {
            Kind::Internal => 1,
            Kind::Scene => 2,
            Kind::Input => 3,
            Kind::Computation => 4,
            Kind::Interrupted => 130,
        }
    }
}

/// A cause of errors that a layer above can say more about: the keys of a scene that take part in
/// it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// The factors of a matrix need more memory than the limit, with a solver that was prescribed.
    SolverMemory,
    /// The iterations of a linear solver did not converge.
    SolverStalled,
    /// Prescribed velocities do not balance in a closed domain.
    Inflow,
    /// A checkpoint is damaged, or of another version or another scene.
    Checkpoint,
    /// The error control needs a step below the shortest one.
    ShortestStep,
    /// The error control needs a scheme of order 2.
    ErrorControl,
    /// The velocity is not finite, or carries a particle across the whole domain in a step.
    BlowUp,
    /// A scheme of order 1 in steps of order 2.
    FirstOrder,
    /// A scheme that needs inertia, without.
    Massless,
    /// The semi-implicit scheme with a force that has no band.
    SharpForce,
    /// The semi-implicit scheme with a force that depends on shear.
    ShearForce,
    /// Markers on an interface of several curves.
    SeveralCurves,
    /// The contour of a segmentation has vanished.
    ContourLost,
    /// A part of the boundary without a condition; the value is its name.
    BareBoundary,
    /// A boundary that is curved more than the refined mesh can follow.
    CurvedBoundary,
}

/// Part of a text file that an error refers to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Snippet {
    /// Name of the file, as the user gave it.
    pub path: String,
    /// The whole text of the file.
    pub source: String,
    /// Byte range of `source` that is wrong.
    pub span: Range<usize>,
}

impl Snippet {
    /// Line and column of the start of the span, both counted from 1.
    pub fn line_column(&self) -> (usize, usize) {
        let end = self.span.start.min(self.source.len());
        let before = self.source.get(..end).unwrap_or(&self.source);
        let line = before.matches('\n').count() + 1;
        let column = before.chars().rev().take_while(|&c| c != '\n').count() + 1;
        (line, column)
    }
}

/// An error: description, place, wrong value and remedy.
///
/// Built by [`Error::scene`], [`Error::input`], [`Error::computation`], [`Error::internal`] or
/// [`Error::interrupted`] and completed by [`at`](Error::at), [`value`](Error::value) and
/// [`remedy`](Error::remedy).
#[derive(Clone, PartialEq, Eq)]
pub struct Error(Box<Parts>);

#[derive(Clone, Debug, PartialEq, Eq)]
struct Parts {
    kind: Kind,
    what: String,
    place: String,
    value: String,
    remedy: String,
    snippet: Option<Snippet>,
    cause: Option<Cause>,
}

impl Error {
    fn new(kind: Kind, what: impl Into<String>) -> Error {
        Error(Box::new(Parts {
            kind,
            what: what.into(),
            place: String::new(),
            value: String::new(),
            remedy: String::new(),
            snippet: None,
            cause: None,
        }))
    }
    /// A wrong command line or scene.
    pub fn scene(what: impl Into<String>) -> Error {
        Error::new(Kind::Scene, what)
    }
    /// A wrong mesh, another wrong input file, or an output that cannot be written.
    pub fn input(what: impl Into<String>) -> Error {
        Error::new(Kind::Input, what)
    }
    /// A computation that failed.
    pub fn computation(what: impl Into<String>) -> Error {
        Error::new(Kind::Computation, what)
    }
    /// A defect of this program.
    pub fn internal(what: impl Into<String>) -> Error {
        Error::new(Kind::Internal, what)
    }
    /// A stop that the user asked for.
    pub fn interrupted(what: impl Into<String>) -> Error {
        Error::new(Kind::Interrupted, what)
    }
    /// Adds the place: file and line, cell and coordinates, key of the scene, or time.
    pub fn at(mut self, place: impl Into<String>) -> Error {
        self.0.place = place.into();
        self
    }
    /// Adds the wrong value.
    pub fn value(mut self, value: impl fmt::Display) -> Error {
        self.0.value = value.to_string();
        self
    }
    /// Adds a remedy for the user.
    pub fn remedy(mut self, remedy: impl Into<String>) -> Error {
        self.0.remedy = remedy.into();
        self
    }
    /// Adds the place in a text file, for a report with the line and a caret.
    pub fn snippet(mut self, snippet: Snippet) -> Error {
        self.0.snippet = Some(snippet);
        self
    }
    /// The cause, for layers above.
    pub fn because(mut self, cause: Cause) -> Error {
        self.0.cause = Some(cause);
        self
    }
    /// The cause, if a layer above can say more about it.
    pub fn cause(&self) -> Option<Cause> {
        self.0.cause
    }
    /// The kind of the error.
    pub fn kind(&self) -> Kind {
        self.0.kind
    }
    /// Description of the error.
    pub fn what(&self) -> &str {
        &self.0.what
    }
    /// Place of the error; may be empty.
    pub fn place(&self) -> &str {
        &self.0.place
    }
    /// The value that is wrong; may be empty.
    pub fn wrong_value(&self) -> &str {
        &self.0.value
    }
    /// Remedy for the user; may be empty.
    pub fn advice(&self) -> &str {
        &self.0.remedy
    }
    /// The place in a text file, if there is one.
    pub fn source_snippet(&self) -> Option<&Snippet> {
        self.0.snippet.as_ref()
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let p = &self.0;
        write!(f, "{}", p.what)?;
        if !p.place.is_empty() {
            write!(f, "\n  at: {}", p.place)?;
        }
        if !p.value.is_empty() {
            write!(f, "\n  value: {}", p.value)?;
        }
        if !p.remedy.is_empty() {
            write!(f, "\n  remedy: {}", p.remedy)?;
        }
        Ok(())
    }
}

/// Same as `Display`, because this is printed when `main` returns an error.
impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl std::error::Error for Error {}

/// A message to the user that does not stop the program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// Description, with place and value.
    pub what: String,
    /// Remedy for the user; may be empty.
    pub remedy: String,
}

impl Warning {
    /// A warning with its remedy.
    pub fn new(what: impl Into<String>, remedy: impl Into<String>) -> Warning {
        Warning { what: what.into(), remedy: remedy.into() }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.what)?;
        if !self.remedy.is_empty() {
            write!(f, "; {}", self.remedy)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_message_names_place_value_and_remedy() {
        let e = Error::scene("time step must be positive")
            .at("scene.toml, key time.step")
            .value(0.0)
            .remedy("give a number > 0");
        let text = e.to_string();
        for part in ["positive", "time.step", "value: 0", "number > 0"] {
            assert!(text.contains(part), "{part} is missing in {text}");
        }
        assert_eq!(e.kind().exit_code(), 2);
    }

    #[test]
    fn line_and_column_count_from_one() {
        let s = Snippet { path: "a".into(), source: "x = 1\nyé = 2\n".into(), span: 9..10 };
        assert_eq!(s.line_column(), (2, 3));
    }
}
