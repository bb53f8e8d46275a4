//! Lossless conversion of numbers to bytes and back: 8 bytes each, little-endian; a list follows
//! its length.

use nalgebra::SVector;

/// Writer: the bytes so far.
#[derive(Debug, Default)]
pub struct Writer(pub Vec<u8>);

impl Writer {
    /// A whole number.
    pub fn integer(&mut self, v: u64) {
        self.0.extend(v.to_le_bytes());
    }
    /// Whole numbers.
    pub fn integers(&mut self, list: &[u32]) {
        self.integer(list.len() as u64);
        list.iter().for_each(|v| self.integer(u64::from(*v)));
    }
    /// Numbers.
    pub fn numbers(&mut self, list: &[f64]) {
        self.integer(list.len() as u64);
        list.iter().for_each(|v| self.0.extend(v.to_le_bytes()));
    }
    /// Vectors, component by component.
    pub fn vectors<const D: usize>(&mut self, list: &[SVector<f64, D>]) {
        self.integer(list.len() as u64);
        list.iter().flat_map(|v| v.iter()).for_each(|v| self.0.extend(v.to_le_bytes()));
    }
    /// A text.
    pub fn text(&mut self, text: &str) {
        self.integer(text.len() as u64);
        text.bytes().for_each(|b| self.integer(u64::from(b)));
    }
}

/// Reader from the front of a slice. Methods return `None` if the bytes are used up or do not fit.
#[derive(Debug)]
pub struct Reader<'a>(pub &'a [u8]);

impl Reader<'_> {
    /// A whole number.
    pub fn integer(&mut self) -> Option<u64> {
        let (word, rest) = self.0.split_first_chunk::<8>()?;
        self.0 = rest;
        Some(u64::from_le_bytes(*word))
    }
    /// A number.
    pub fn number(&mut self) -> Option<f64> {
        self.integer().map(f64::from_bits)
    }
    /// A list of elements that `read` reads.
    pub fn list<T>(&mut self, read: impl Fn(&mut Self) -> Option<T>) -> Option<Vec<T>> {
        let count = usize::try_from(self.integer()?)
            .ok()
            .filter(|n| n.checked_mul(8).is_some_and(|b| b <= self.0.len()))?;
        (0..count).map(|_| read(self)).collect()
    }
    /// Whole numbers.
    pub fn integers(&mut self) -> Option<Vec<u32>> {
        self.list(|from| from.integer().and_then(|v| u32::try_from(v).ok()))
    }
    /// Numbers.
    pub fn numbers(&mut self) -> Option<Vec<f64>> {
        self.list(Reader::number)
    }
    /// Vectors, component by component.
    pub fn vectors<const D: usize>(&mut self) -> Option<Vec<SVector<f64, D>>> {
        self.list(|from| {
            let mut v = SVector::<f64, D>::zeros();
            for c in v.iter_mut() {
                *c = from.number()?;
            }
            Some(v)
        })
    }
    /// A text.
    pub fn text(&mut self) -> Option<String> {
        let bytes = self.list(|from| from.integer().and_then(|v| u8::try_from(v).ok()))?;
        String::from_utf8(bytes).ok()
    }
}
