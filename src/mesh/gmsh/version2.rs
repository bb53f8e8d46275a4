//! `$Nodes` and `$Elements` of version 2.

use super::MshData;
use super::cursor::Cursor;
use super::elements::simplex;
use crate::base::Result;
use std::collections::HashMap;

impl MshData {
    pub(super) fn read_nodes_2(&mut self, cursor: &mut Cursor, parametric: bool) -> Result<()> {
        let count = cursor.count_line("the number of points", 4, 28)?;
        self.points.reserve(count);
        for _ in 0..count {
            let at = cursor.start();
            let tag = cursor.int("the number of a point")?;
            let tag =
                u64::try_from(tag).map_err(|_| cursor.unexpected(at, "the number of a point"))?;
            let x = cursor.coordinates(tag)?;
            if parametric {
                let dimension = cursor.int("the dimension of an entity")?;
                cursor.int("the number of an entity")?;
                // Points of curves have one parameter, of surfaces two, the others none.
                for _ in 0..if (1..=2).contains(&dimension) { dimension } else { 0 } {
                    cursor.real("a parameter")?;
                }
            }
            self.add_point(cursor, at, tag, x)?;
        }
        Ok(())
    }

    /// Elements in several physical groups occur once per group: they are added once, and to all
    /// groups.
    pub(super) fn read_elements_2(&mut self, cursor: &mut Cursor) -> Result<()> {
        let count = cursor.count_line("the number of elements", 4, 8)?;
        let mut known: HashMap<[u32; 4], u32> = HashMap::new();
        let mut nodes = Vec::new();
        let mut read = 0;
        while read < count {
            // A binary file has blocks of elements with one header, a text file a header for each.
            let at = cursor.start();
            if !cursor.binary {
                cursor.int("the number of an element")?;
            }
            let code = cursor.int("the type of an element")?;
            let kind = simplex(code)
                .map_err(|(what, remedy)| cursor.error(at, what).value(code).remedy(remedy))?;
            let block =
                if cursor.binary { cursor.int("the number of elements of a block")? } else { 1 };
            let tags = cursor.int("the number of tags of an element")?;
            if tags < 0 || block < 1 || block > (count - read) as i64 {
                return Err(cursor
                    .error(
                        at,
                        "the numbers of elements and of tags do not fit the number of all elements",
                    )
                    .value(format!(
                        "{block} elements with {tags} tags, where {} elements are left",
                        count - read
                    ))
                    .remedy(super::cursor::WRITE_AGAIN));
            }
            for _ in 0..block {
                let at = cursor.start();
                if cursor.binary {
                    cursor.int("the number of an element")?;
                }
                let mut group = 0;
                for t in 0..tags {
                    let tag = cursor.int("a tag of an element")?;
                    group = if t == 0 { tag.saturating_abs() } else { group };
                }
                nodes.clear();
                for _ in 0..kind.nodes {
                    let tag = cursor.int("the number of a point of an element")?;
                    nodes.push(u64::try_from(tag).unwrap_or(u64::MAX));
                }
                let vertices = self.vertices(cursor, at, &nodes, kind.dimension)?;
                let mut key = vertices;
                key.sort_unstable();
                let all = &mut self.simplices[kind.dimension];
                let number = *known.entry(key).or_insert(all.len() as u32);
                if number as usize == all.len() {
                    all.push(vertices);
                }
                if group != 0 {
                    self.groups.entry((kind.dimension, group)).or_default().push(number);
                }
            }
            read += block as usize;
        }
        Ok(())
    }
}
