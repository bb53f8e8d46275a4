//! Reading of files whose size is known.

use std::io::{Error, Read, Result};
use std::path::Path;

/// Largest number of bytes that are read of what is no plain file, such as a pipe.
const MOST_OF_PIPE: u64 = 16 << 20;

/// The content of a file. A pipe is read as far as a text may be long; a device without an end is
/// an error.
///
/// # Errors
/// The file cannot be read, or has no end.
pub fn read_plain(path: &Path) -> Result<Vec<u8>> {
    let file = std::fs::File::open(path)?;
    let is_plain = file.metadata()?.is_file();
    let most = if is_plain { u64::MAX } else { MOST_OF_PIPE + 1 };
    let mut bytes = Vec::new();
    file.take(most).read_to_end(&mut bytes)?;
    match !is_plain && bytes.len() as u64 > MOST_OF_PIPE {
        true => Err(Error::other("it is no plain file, and has no end")),
        false => Ok(bytes),
    }
}
