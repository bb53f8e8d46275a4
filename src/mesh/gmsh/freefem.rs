//! The `.msh` files that FreeFEM writes with `savemesh`: triangles of the plane.
//!
//! A line with the numbers of vertices, triangles and boundary edges; then `x y label` per vertex,
//! three vertices (from 1) and a region per triangle, two vertices and a label per edge.

use super::MshData;
use crate::base::{Error, Result};
use crate::mesh::NONE;

/// True if the first line of a file has three whole numbers and nothing else.
pub(super) fn is_mesh(bytes: &[u8]) -> bool {
    let line = bytes.split(|b| *b == b'\n').next().unwrap_or_default();
    let Ok(line) = std::str::from_utf8(line) else { return false };
    let words: Vec<&str> = line.split_whitespace().collect();
    words.len() == 3 && words.iter().all(|word| word.parse::<u32>().is_ok())
}

/// The lines of a file that are not empty, with their numbers from 1.
struct Lines<'a> {
    lines: Box<dyn Iterator<Item = (usize, &'a str)> + 'a>,
    last: usize,
    file: &'a str,
}

impl Lines<'_> {
    /// The numbers of the next line.
    fn next<const N: usize>(&mut self, what: &str) -> Result<[f64; N]> {
        let line = self.lines.next();
        let (number, text) = line.unwrap_or((self.last + 1, "the end of the file"));
        self.last = number;
        let values: Vec<f64> = text.split_whitespace().map_while(|w| w.parse().ok()).collect();
        let complete = values.len() == N && text.split_whitespace().count() == N;
        values.try_into().ok().filter(|_| complete).ok_or_else(|| {
            Error::input(format!("a mesh of FreeFEM is damaged: expected {what}"))
                .at(format!("{}, line {number}", self.file))
                .value(text)
                .remedy("save it again with savemesh(Th, \"FILE.msh\")")
        })
    }
}

impl MshData {
    /// Reads a mesh of FreeFEM. Regions and labels are groups without a name.
    pub(super) fn read_freefem(&mut self, bytes: &[u8]) -> Result<()> {
        let (text, file) = (String::from_utf8_lossy(bytes), self.file.clone());
        let numbered = text.lines().enumerate().map(|(k, line)| (k + 1, line));
        let full = numbered.filter(|(_, line)| !line.trim().is_empty());
        let mut lines = Lines { lines: Box::new(full), last: 0, file: &file };
        let [points, triangles, edges] = lines.next("three numbers")?.map(|n: f64| n as usize);
        for k in 0..points {
            let [x, y, _] = lines.next("x, y and the label of a vertex")?;
            self.points.push([x, y, 0.0]);
            self.tags.push(k as u64 + 1);
            self.index.insert(k as u64 + 1, k as u32);
        }
        for _ in 0..triangles {
            let [a, b, c, region] = lines.next("three vertices and the region of a triangle")?;
            self.simplex(&[a, b, c], region, &lines)?;
        }
        for _ in 0..edges {
            let [a, b, label] = lines.next("two vertices and the label of an edge")?;
            self.simplex(&[a, b], label, &lines)?;
        }
        Ok(())
    }

    fn simplex(&mut self, vertices: &[f64], group: f64, lines: &Lines) -> Result<()> {
        let dimension = vertices.len() - 1;
        let mut simplex = [NONE; 4];
        for (own, &v) in simplex.iter_mut().zip(vertices) {
            let known = v.fract() == 0.0 && v >= 1.0 && v <= self.points.len() as f64;
            if !known {
                return Err(Error::input("a mesh of FreeFEM names a vertex that it does not have")
                    .at(format!("{}, line {}", self.file, lines.last))
                    .value(format!("vertex {v} of {}", self.points.len()))
                    .remedy("save it again with savemesh(Th, \"FILE.msh\")"));
            }
            *own = v as u32 - 1;
        }
        let number = self.simplices[dimension].len() as u32;
        self.simplices[dimension].push(simplex);
        self.groups.entry((dimension, group as i64)).or_default().push(number);
        Ok(())
    }
}
