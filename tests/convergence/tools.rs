//! Slopes, and meshes that the tests share.

use immersa::mesh::{Mesh, Point};

/// Errors on three or more meshes (or steps), the sizes in the same order.
pub struct Study<'a> {
    pub what: &'a str,
    pub sizes: &'a [f64],
    pub errors: Vec<f64>,
}

impl Study<'_> {
    /// Slope of log error over log size by least squares.
    pub fn slope(&self) -> f64 {
        let x: Vec<f64> = self.sizes.iter().map(|v| v.ln()).collect();
        let y: Vec<f64> = self.errors.iter().map(|v| v.ln()).collect();
        let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
        let (mx, my) = (mean(&x), mean(&y));
        let top: f64 = x.iter().zip(&y).map(|(x, y)| (x - mx) * (y - my)).sum();
        top / x.iter().map(|x| (x - mx).powi(2)).sum::<f64>()
    }
    /// Prints the study and asserts its slope to 0.1 and its last error.
    pub fn assert(&self, order: f64, bound: f64) {
        let slope = self.assert_at_least(order - 0.1, bound);
        assert!(
            slope <= order + 0.1,
            "{}: order {slope}, expected {order}; {:?}",
            self.what,
            self.errors
        );
    }
    /// Prints the study and asserts that its slope, which it returns, is not below `order`, and its
    /// last error.
    pub fn assert_at_least(&self, order: f64, bound: f64) -> f64 {
        let slope = self.slope();
        let last = self.errors[self.errors.len() - 1];
        let errors: Vec<String> = self.errors.iter().map(|e| format!("{e:.3e}")).collect();
        println!("{}: errors {} order {slope:.2}", self.what, errors.join(" "));
        assert!(self.errors.len() >= 3, "{}: three meshes make a slope", self.what);
        assert!(slope >= order, "{}: order {slope}, expected {order}; {errors:?}", self.what);
        assert!(last <= bound, "{}: error {last:e} above {bound:e}", self.what);
        slope
    }
}

/// The mesh with all of its boundary called `walls`.
pub fn with_walls<const D: usize>(mut mesh: Mesh<D>) -> Mesh<D> {
    let facets = (0..mesh.facets().len() as u32).collect();
    mesh.set_boundary("walls", facets);
    mesh
}

/// Longest edge.
pub fn size<const D: usize>(mesh: &Mesh<D>) -> f64 {
    (0..mesh.cell_count()).map(|c| mesh.diameter(c)).fold(0.0, f64::max)
}

/// `(x, y)`.
pub fn point(x: f64, y: f64) -> Point<2> {
    Point::<2>::new(x, y)
}
