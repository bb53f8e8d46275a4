//! What a later run reads of a run folder: its mark and its checkpoints.

use crate::base::{Error, Result, fnv1a};
use std::path::Path;

/// The file that makes a folder a run folder: what wrote it, and the process that last did.
pub(super) const MARK: &str = "immersa.run";
/// Beginning of the mark.
pub(super) const FIRST: &str = "run folder of immersa";
/// The last checkpoint, and the one before, in the folder `checkpoint`.
pub(super) const CHECKPOINTS: [&str; 2] = ["latest.bin", "earlier.bin"];

/// True if the folder has the mark.
pub(super) fn is_run(folder: &Path) -> bool {
    std::fs::read_to_string(folder.join(MARK)).is_ok_and(|text| text.starts_with(FIRST))
}

/// The parts of a checkpoint.
pub(super) struct Checkpoint {
    /// The record of all output, as JSON.
    pub record: Vec<u8>,
    /// The mesh; empty if it is that of the scene.
    pub mesh: Vec<u8>,
    /// The state.
    pub state: Vec<u8>,
}

impl Checkpoint {
    /// As one file: the length of the record and its hash, 8 bytes each, the record; the same for
    /// the mesh; the state.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        for part in [&self.record, &self.mesh] {
            bytes.extend((part.len() as u64).to_le_bytes());
            bytes.extend(fnv1a(part).to_le_bytes());
            bytes.extend(part);
        }
        bytes.extend(&self.state);
        bytes
    }

    /// Reads a checkpoint; `None` if there is no such file.
    ///
    /// # Errors
    /// A file that cannot be read or is damaged.
    pub fn read(path: &Path) -> Result<Option<Checkpoint>> {
        let bytes = match std::fs::read(path) {
            Ok(bytes) => bytes,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(e) => {
                return Err(Error::input(format!("the checkpoint cannot be read: {e}"))
                    .at(path.display().to_string())
                    .remedy("check the permissions of the run folder"));
            }
        };
        let found = part(&bytes).and_then(|(record, rest)| Some((record, part(rest)?)));
        let (record, (mesh, state)) = found.ok_or_else(|| damaged(path, bytes.len()))?;
        let [record, mesh, state] = [record, mesh, state].map(<[u8]>::to_vec);
        Ok(Some(Checkpoint { record, mesh, state }))
    }

    /// The record.
    ///
    /// # Errors
    /// It is damaged.
    pub fn record<T: serde::de::DeserializeOwned>(&self, path: &Path) -> Result<T> {
        serde_json::from_slice(&self.record).map_err(|_| damaged(path, self.record.len()))
    }
}

fn damaged(path: &Path, bytes: usize) -> Error {
    Error::input("the checkpoint is damaged")
        .at(path.display().to_string())
        .value(format!("{bytes} bytes"))
        .remedy("start afresh with --overwrite, or in another folder with --out")
}

/// The first part with its length and hash, and the rest; `None` if it is corrupt.
fn part(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let (size, rest) = bytes.split_first_chunk::<8>()?;
    let (check, rest) = rest.split_first_chunk::<8>()?;
    let (part, rest) = rest.split_at_checked(usize::try_from(u64::from_le_bytes(*size)).ok()?)?;
    (fnv1a(part) == u64::from_le_bytes(*check)).then_some((part, rest))
}
