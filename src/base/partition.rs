//! Parts of a set of numbers that are joined pair by pair.

/// The numbers from 0 on, in parts; each part is named by its least number.
pub struct Partition(Vec<u32>);

impl Partition {
    /// `count` numbers, each a part of its own.
    pub fn new(count: usize) -> Partition {
        Partition((0..count as u32).collect())
    }
    /// The least number of the part of `n`, which must be one of the numbers; the way there is halved.
    pub fn first(&mut self, mut n: u32) -> u32 {
        let parent = &mut self.0;
        while parent[n as usize] != n {
            parent[n as usize] = parent[parent[n as usize] as usize];
            n = parent[n as usize];
        }
        n
    }
    /// Makes one part of those of `a` and `b`.
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
