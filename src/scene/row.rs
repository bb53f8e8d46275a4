//! One row of a series: names and values in one pass.

/// Names of columns with their values at one time. A value that cannot be measured is NaN.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    names: Vec<String>,
    values: Vec<f64>,
}

impl Row {
    /// Adds a column.
    pub fn put(&mut self, name: impl Into<String>, value: f64) {
        self.names.push(name.into());
        self.values.push(value);
    }
    /// Adds columns whose names begin with `prefix`.
    pub fn put_all<S: AsRef<str>>(
        &mut self,
        prefix: &str,
        columns: impl IntoIterator<Item = (S, f64)>,
    ) {
        for (name, value) in columns {
            self.put(format!("{prefix}{}", name.as_ref()), value);
        }
    }
    /// Names of the columns.
    pub fn names(&self) -> &[String] {
        &self.names
    }
    /// Values of the columns.
    pub fn values(&self) -> &[f64] {
        &self.values
    }
    /// Value of the column `name`.
    pub fn get(&self, name: &str) -> Option<f64> {
        Some(self.values[self.names.iter().position(|n| n == name)?])
    }
}
