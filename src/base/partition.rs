//! Disjoint sets of numbers (union-find).

/// A partition of the numbers from 0 on; each set is represented by its least number.
pub struct Partition(Vec<u32>);

impl Partition {
    /// `count` numbers, each a set of its own.
    pub fn new(count: usize) -> Partition {
        Partition((0..count as u32).collect())
    }
    /// Least number of the set of `n`, which must be below `count`; halves the path.
    pub fn first(&mut self, mut n: u32) -> u32 {
        let parent = &mut self.0;
        while parent[n as usize] != n {
            parent[n as usize] = parent[parent[n as usize] as usize];
            n = parent[n as usize];
        }
        n
    }
    /// Merges the sets of `a` and `b`.
    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.first(a), self.first(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_named_by_their_least_numbers() {
        let mut parts = Partition::new(7);
        [(6, 3), (5, 1), (3, 5), (2, 2)].into_iter().for_each(|(a, b)| parts.join(a, b));
        assert_eq!([0, 1, 2, 3, 4, 5, 6].map(|n| parts.first(n)), [0, 1, 2, 1, 4, 1, 1]);
    }
}
