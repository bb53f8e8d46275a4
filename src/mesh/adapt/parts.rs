//! Named sets of facets or cells, encoded as one small number each: the set of its names.

use std::collections::BTreeMap;

/// The names, and the sets of them that occur; set 0 is the empty one.
pub(super) struct Parts {
    names: Vec<String>,
    sets: Vec<Vec<u32>>,
}

impl Parts {
    /// The sets of `count` items from the lists of members, and the number of the set of every
    /// item.
    pub fn new(members: &BTreeMap<String, Vec<u32>>, count: usize) -> (Parts, Vec<u32>) {
        let mut of_item = vec![Vec::new(); count];
        for (name, items) in (0..).zip(members.values()) {
            for &i in items {
                let set: &mut Vec<u32> = &mut of_item[i as usize];
                if set.last() != Some(&name) {
                    set.push(name);
                }
            }
        }
        let mut numbers = BTreeMap::from([(Vec::new(), 0)]);
        let mut sets = vec![Vec::new()];
        let mark = |set: Vec<u32>| {
            *numbers.entry(set).or_insert_with_key(|set| {
                sets.push(set.clone());
                sets.len() as u32 - 1
            })
        };
        let marks = of_item.into_iter().map(mark).collect();
        (Parts { names: members.keys().cloned().collect(), sets }, marks)
    }

    /// The members of every name again, from the numbers of the sets of items.
    pub fn members(
        &self,
        marks: impl Iterator<Item = u32>,
    ) -> impl Iterator<Item = (String, Vec<u32>)> {
        let mut members = vec![Vec::new(); self.names.len()];
        for (i, mark) in (0..).zip(marks) {
            self.sets[mark as usize].iter().for_each(|&name| members[name as usize].push(i));
        }
        self.names.iter().cloned().zip(members)
    }
}
