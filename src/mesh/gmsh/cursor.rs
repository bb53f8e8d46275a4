//! A position in the bytes of a file, from which words and numbers are read; every error names the
//! position.

use crate::base::{Error, Result};

/// Remedy for a file that ends early or contradicts its own counts.
pub(super) const WRITE_AGAIN: &str = "the file is incomplete or was changed: write it again (gmsh \
    -format msh41 -save_all FILE.geo -2, or -3)";

pub(super) struct Cursor<'a> {
    name: &'a str,
    bytes: &'a [u8],
    pub(super) at: usize,
    /// Numbers are little-endian bytes and not words.
    pub(super) binary: bool,
}

impl<'a> Cursor<'a> {
    pub(super) fn new(name: &'a str, bytes: &'a [u8]) -> Cursor<'a> {
        Cursor { name, bytes, at: 0, binary: false }
    }

    /// An error about the bytes at `at`: the file, and its line (text) or byte (binary).
    pub(super) fn error(&self, at: usize, what: impl Into<String>) -> Error {
        let before = &self.bytes[..at.min(self.bytes.len())];
        let place = if self.binary {
            format!("{}, byte {at}", self.name)
        } else {
            format!("{}, line {}", self.name, before.iter().filter(|&&b| b == b'\n').count() + 1)
        };
        Error::input(what).at(place)
    }

    /// The error for a file that ends while `what` is read.
    fn truncated(&self, what: &str) -> Error {
        self.error(self.bytes.len(), format!("the file ends where {what} should follow"))
            .value(format!("{} bytes in all", self.bytes.len()))
            .remedy(WRITE_AGAIN)
    }

    pub(super) fn skip_space(&mut self) {
        while self.bytes.get(self.at).is_some_and(u8::is_ascii_whitespace) {
            self.at += 1;
        }
    }

    /// Start of the next number.
    pub(super) fn start(&mut self) -> usize {
        if !self.binary {
            self.skip_space();
        }
        self.at
    }

    pub(super) fn is_at_end(&self) -> bool {
        self.at >= self.bytes.len()
    }

    /// The rest of the line as text, without its end; invalid bytes become replacement characters.
    pub(super) fn line(&mut self) -> String {
        let rest = &self.bytes[self.at.min(self.bytes.len())..];
        let length = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        self.at += (length + 1).min(rest.len());
        String::from_utf8_lossy(&rest[..length]).trim().to_owned()
    }

    /// The next word of text.
    fn word(&mut self, what: &str) -> Result<(usize, &'a str)> {
        self.skip_space();
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        if length == 0 {
            return Err(self.truncated(what));
        }
        let at = self.at;
        self.at += length;
        let word = std::str::from_utf8(&rest[..length]).map_err(|_| self.unexpected(at, what))?;
        Ok((at, word))
    }

    /// The error for other content than `what`.
    pub(super) fn unexpected(&self, at: usize, what: &str) -> Error {
        let rest = &self.bytes[at.min(self.bytes.len())..];
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len()).min(40);
        let found = String::from_utf8_lossy(&rest[..end]);
        self.error(at, format!("expected {what}"))
            .value(format!("found {:?}", found))
            .remedy(WRITE_AGAIN)
    }

    fn parse<T: std::str::FromStr>(&mut self, what: &str) -> Result<T> {
        let (at, word) = self.word(what)?;
        word.parse().map_err(|_| self.unexpected(at, what))
    }

    fn bytes_of<const N: usize>(&mut self, what: &str) -> Result<[u8; N]> {
        let bytes = self.bytes.get(self.at..).and_then(|rest| rest.first_chunk::<N>());
        let bytes = *bytes.ok_or_else(|| self.truncated(what))?;
        self.at += N;
        Ok(bytes)
    }

    /// An integer; four bytes if binary.
    pub(super) fn int(&mut self, what: &str) -> Result<i64> {
        if self.binary {
            Ok(i32::from_le_bytes(self.bytes_of(what)?).into())
        } else {
            self.parse(what)
        }
    }

    /// A number that may not be negative; eight bytes if binary.
    pub(super) fn size(&mut self, what: &str) -> Result<u64> {
        if self.binary { Ok(u64::from_le_bytes(self.bytes_of(what)?)) } else { self.parse(what) }
    }

    /// A number, which may be infinite or not a number.
    pub(super) fn real(&mut self, what: &str) -> Result<f64> {
        if self.binary { Ok(f64::from_le_bytes(self.bytes_of(what)?)) } else { self.parse(what) }
    }

    /// The three coordinates of a point.
    pub(super) fn coordinates(&mut self, tag: u64) -> Result<[f64; 3]> {
        let at = self.start();
        let x =
            [self.real("a coordinate")?, self.real("a coordinate")?, self.real("a coordinate")?];
        if x.iter().all(|c| c.is_finite()) {
            return Ok(x);
        }
        Err(self
            .error(at, "a coordinate is not a finite number")
            .value(format!("point {tag} at {x:?}"))
            .remedy("correct the geometry or the program that wrote the file"))
    }

    /// A count of items of `words` numbers, of `bytes` bytes each if binary; an error if the file
    /// cannot hold them, so that memory can be reserved for them.
    pub(super) fn count(&mut self, what: &str, words: usize, bytes: usize) -> Result<usize> {
        let at = self.start();
        let n = self.size(what)?;
        self.fits(at, n, what, if self.binary { bytes } else { 2 * words })
    }

    /// A count on a line of its own, also in a binary file (version 2).
    pub(super) fn count_line(&mut self, what: &str, words: usize, bytes: usize) -> Result<usize> {
        self.skip_space();
        let at = self.at;
        let n = self.line().parse().map_err(|_| self.unexpected(at, what))?;
        self.fits(at, n, what, if self.binary { bytes } else { 2 * words })
    }

    fn fits(&self, at: usize, n: u64, what: &str, each: usize) -> Result<usize> {
        // One more, since the last word of a file needs no space after it.
        let rest = self.bytes.len() - self.at.min(self.bytes.len()) + 1;
        // Points and elements have 32-bit numbers.
        if n <= (rest / each.max(1)).min(1 << 30) as u64 {
            return Ok(n as usize);
        }
        Err(self
            .error(at, format!("{what} does not fit the size of the file"))
            .value(n)
            .remedy(WRITE_AGAIN))
    }

    /// Moves past the line `$End...` of a section that was read to its end.
    pub(super) fn end_section(&mut self, section: &str) -> Result<()> {
        self.skip_space();
        let at = self.at;
        let expected = format!("$End{section}");
        if self.is_at_end() {
            return Err(self.truncated(&expected));
        }
        if self.line() == expected { Ok(()) } else { Err(self.unexpected(at, &expected)) }
    }

    /// Moves past the line `$End...` of a section that is not read.
    pub(super) fn skip_section(&mut self, section: &str) -> Result<()> {
        let expected = format!("$End{section}");
        let rest = &self.bytes[self.at..];
        let found = rest.windows(expected.len()).position(|w| w == expected.as_bytes());
        self.at += found.ok_or_else(|| self.truncated(&expected))?;
        self.end_section(section)
    }
}
