//! Physics of the test structure: a disc of fluid pulled to a point by a spring.

use crate::base::Result;
use crate::fem::{At, Basis, Cells, VectorForm, integrate};
use crate::flow::term::{MomentumTerm, Support};
use crate::levelset::heaviside;
use crate::mesh::Point;
use crate::structure::{
    Carry, Data, Declaration, FieldId, Fields, Host, Moved, Place, Rule, Structure, Velocity,
};
use nalgebra::{SMatrix, SVector};

/// A disc of fluid whose centre is pulled to an anchor by a spring: `F(v) = -k (X - A) . mean of v
/// inside`, with the energy `k |X - A|^2 / 2`. The length of the path of the centre is an
/// additional unknown.
#[derive(Clone)]
pub struct Spring<const D: usize> {
    pub name: String,
    pub phi: Vec<f64>,
    pub anchor: Point<D>,
    pub stiffness: f64,
    pub width: f64,
    field: FieldId,
    path: FieldId,
    /// Level set, size and force of the last preparation.
    inside: Vec<f64>,
    pull: SVector<f64, D>,
    weights: Vec<f64>,
    points: usize,
}

impl<const D: usize> Spring<D> {
    pub fn new(
        name: &str,
        phi: Vec<f64>,
        (anchor, stiffness, width): (Point<D>, f64, f64),
    ) -> Self {
        let (field, path) = (FieldId::default(), FieldId::default());
        let (inside, pull, weights, name) = (vec![], SVector::zeros(), vec![], name.to_string());
        Spring {
            name,
            phi,
            anchor,
            stiffness,
            width,
            field,
            path,
            inside,
            pull,
            weights,
            points: 0,
        }
    }
    /// Size and centre of the disc.
    fn centre(&self, basis: &Basis<D>, phi: &[f64]) -> (f64, Point<D>) {
        let eps = self.width;
        let inside = |at: &At<D>| 1.0 - heaviside(basis.value(at, phi) / eps);
        let [size, sums @ ..] = integrate(basis, Cells::All, |at| {
            let x = |i: usize| if i < D { inside(at) * at.x[i] } else { 0.0 };
            [inside(at), x(0), x(1), x(2)]
        });
        (size, Point::<D>::from_fn(|i, _| sums[i] / size))
    }
}

impl<const D: usize> MomentumTerm<D> for Spring<D> {
    fn support(&self) -> Support<'_, D> {
        Support::Cells(Cells::All)
    }
    fn force(&self, at: &At<D>) -> VectorForm<D> {
        (self.pull * self.weights[at.cell * self.points + at.q], SMatrix::zeros())
    }
}

impl<const D: usize> Structure<D> for Spring<D> {
    fn name(&self) -> &str {
        &self.name
    }
    fn begin(&mut self, _: &Host<'_, D>, fields: &mut Declaration<'_, D>) -> Result<()> {
        let rule = |carry| Rule { carry, acts: true, written: true };
        let (phi, path) = (format!("{}.level_set", self.name), format!("{}.path", self.name));
        self.field =
            fields.add(&phi, rule(Carry::Convected(None)), || Data::Scalar(self.phi.clone()));
        self.path = fields.add(&path, rule(Carry::ByOwner), || Data::Numbers(vec![0.0]));
        Ok(())
    }
    fn level_set(&self) -> Option<FieldId> {
        Some(self.field)
    }
    fn prepare(&mut self, at: &Place<'_, D>) -> Result<()> {
        let phi = at.fields.scalar(self.field);
        let (size, centre) = self.centre(at.basis, phi);
        self.pull = (centre - self.anchor) * -self.stiffness;
        self.points = at.basis.rule().len();
        let value = |c: usize, q: usize| {
            1.0 - heaviside(at.basis.value(&at.basis.at(c, q), phi) / self.width)
        };
        let cells = 0..at.space.mesh().cell_count();
        let weights = cells.flat_map(|c| (0..self.points).map(move |q| (c, q)));
        self.weights = weights.map(|(c, q)| value(c, q) / size).collect();
        self.inside = phi.to_vec();
        Ok(())
    }
    fn terms<'a>(&'a self, out: &mut Vec<&'a dyn MomentumTerm<D>>) {
        out.push(self);
    }
    fn advance(&mut self, by: &mut Moved<'_, D>, fields: &mut Fields<D>) -> Result<()> {
        let Velocity::Computed { mean, .. } = by.velocity else { return Ok(()) };
        let fastest = mean.iter().map(|u| u.norm()).fold(0.0, f64::max);
        fields.scalar_mut(self.path)[0] = by.before.scalar(self.path)[0] + by.dt * fastest;
        Ok(())
    }
    fn energy(&mut self, at: &Place<'_, D>, rule: &Basis<D>) -> Result<f64> {
        let (_, centre) = self.centre(rule, at.fields.scalar(self.field));
        Ok(0.5 * self.stiffness * (centre - self.anchor).norm_squared())
    }
    fn boxed(&self) -> Box<dyn Structure<D>> {
        Box::new(self.clone())
    }
}
