//! `$Entities`, `$Nodes` and `$Elements` of versions 4.0 and 4.1.

use super::cursor::{Cursor, WRITE_AGAIN};
use super::elements::simplex;
use super::{MshData, Version};
use crate::base::Result;
use std::collections::HashMap;

/// Physical groups of an entity, by its dimension and number.
pub(super) type Entities = HashMap<(i64, i64), Vec<i64>>;

pub(super) fn read_entities(
    cursor: &mut Cursor,
    entities: &mut Entities,
    version: Version,
    partitioned: bool,
) -> Result<()> {
    if partitioned {
        cursor.size("the number of partitions")?;
        for _ in 0..cursor.count("the number of ghost entities", 2, 8)? {
            cursor.int("the number of a ghost entity")?;
            cursor.int("a partition")?;
        }
    }
    let mut counts = [0; 4];
    for n in &mut counts {
        *n = cursor.count("a number of entities", 5, 36)?;
    }
    for (dimension, count) in counts.into_iter().enumerate() {
        for _ in 0..count {
            let number = cursor.int("the number of an entity")?;
            if partitioned {
                cursor.int("the dimension of a parent")?;
                cursor.int("the number of a parent")?;
                skip_ints(cursor, "the number of partitions of an entity")?;
            }
            // A point has its position, other entities have their bounding box; in 4.0 points have
            // one too.
            let corners = if dimension == 0 && version == Version::FourOne { 1 } else { 2 };
            for _ in 0..3 * corners {
                cursor.real("a corner of a bounding box")?;
            }
            let groups = cursor.count("the number of physical groups of an entity", 1, 4)?;
            let mut of_entity = Vec::with_capacity(groups);
            for _ in 0..groups {
                // A negative number: the entity is reversed in this group.
                of_entity.push(cursor.int("the number of a physical group")?.saturating_abs());
            }
            entities.insert((dimension as i64, number), of_entity);
            if dimension > 0 {
                skip_ints(cursor, "the number of bounding entities")?;
            }
        }
    }
    Ok(())
}

fn skip_ints(cursor: &mut Cursor, what: &str) -> Result<()> {
    for _ in 0..cursor.count(what, 1, 4)? {
        cursor.int("the number of an entity")?;
    }
    Ok(())
}

/// Dimension and number of the entity of a block, in reverse order in 4.0.
fn entity(cursor: &mut Cursor, version: Version) -> Result<(i64, i64)> {
    let first = cursor.int("the dimension or number of an entity")?;
    let second = cursor.int("the dimension or number of an entity")?;
    Ok(if version == Version::FourOne { (first, second) } else { (second, first) })
}

/// Checks the sum over blocks against the number at the start of the section.
fn check_total(cursor: &Cursor, at: usize, what: &str, found: usize, total: usize) -> Result<()> {
    if found == total {
        return Ok(());
    }
    Err(cursor
        .error(at, format!("the blocks do not hold as many {what} as the section says"))
        .value(format!("{found} instead of {total}"))
        .remedy(WRITE_AGAIN))
}

impl MshData {
    pub(super) fn read_nodes_4(&mut self, cursor: &mut Cursor, version: Version) -> Result<()> {
        let start = cursor.start();
        let blocks = cursor.count("the number of blocks of points", 4, 20)?;
        let total = cursor.count("the number of points", 4, 32)?;
        skip_range(cursor, version)?;
        self.points.reserve(total);
        for _ in 0..blocks {
            let (dimension, _) = entity(cursor, version)?;
            let at = cursor.start();
            let parametric = cursor.int("whether the points have parameters (0 or 1)")?;
            if !(0..=1).contains(&parametric) || !(0..=3).contains(&dimension) {
                return Err(cursor.unexpected(
                    at,
                    "a dimension of 0 to 3 and whether points have parameters (0 or 1)",
                ));
            }
            let parameters = parametric * dimension;
            let count = cursor.count("the number of points of a block", 4, 32)?;
            // 4.1 has all numbers first and then all coordinates.
            let mut tags = Vec::new();
            for _ in 0..if version == Version::FourOne { count } else { 0 } {
                tags.push(cursor.size("the number of a point")?);
            }
            for i in 0..count {
                let at = cursor.start();
                let tag = match tags.get(i) {
                    Some(&tag) => tag,
                    None => cursor.size("the number of a point")?,
                };
                let x = cursor.coordinates(tag)?;
                for _ in 0..parameters {
                    cursor.real("a parameter")?;
                }
                self.add_point(cursor, at, tag, x)?;
            }
        }
        check_total(cursor, start, "points", self.points.len(), total)
    }

    pub(super) fn read_elements_4(
        &mut self,
        cursor: &mut Cursor,
        version: Version,
        entities: &Entities,
    ) -> Result<()> {
        let start = cursor.start();
        let blocks = cursor.count("the number of blocks of elements", 4, 20)?;
        let total = cursor.count("the number of elements", 2, 16)?;
        skip_range(cursor, version)?;
        let mut nodes = Vec::new();
        let mut found = 0;
        for _ in 0..blocks {
            let of_entity = entity(cursor, version)?;
            let at = cursor.start();
            let code = cursor.int("the type of the elements of a block")?;
            let kind = simplex(code)
                .map_err(|(what, remedy)| cursor.error(at, what).value(code).remedy(remedy))?;
            let count = cursor.count(
                "the number of elements of a block",
                kind.nodes + 1,
                8 * (kind.nodes + 1),
            )?;
            let first = self.simplices[kind.dimension].len();
            self.simplices[kind.dimension].reserve(count);
            for _ in 0..count {
                let at = cursor.start();
                cursor.size("the number of an element")?;
                nodes.clear();
                for _ in 0..kind.nodes {
                    nodes.push(cursor.size("the number of a point of an element")?);
                }
                let vertices = self.vertices(cursor, at, &nodes, kind.dimension)?;
                self.simplices[kind.dimension].push(vertices);
            }
            found += count;
            for &group in entities.get(&of_entity).into_iter().flatten() {
                let numbers = first as u32..(first + count) as u32;
                self.groups.entry((kind.dimension, group)).or_default().extend(numbers);
            }
        }
        check_total(cursor, start, "elements", found, total)
    }
}

/// Skips the least and the greatest number of the points or elements, present in 4.1.
fn skip_range(cursor: &mut Cursor, version: Version) -> Result<()> {
    if version == Version::FourOne {
        cursor.size("the least number")?;
        cursor.size("the greatest number")?;
    }
    Ok(())
}
