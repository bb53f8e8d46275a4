//! Named fields: all quantities that change in time except velocity and pressure.

use crate::base::bytes::{Reader, Writer};
use crate::base::{Error, Result};
use crate::mesh::Point;
use crate::transport::CharacteristicMap;
use nalgebra::SVector;
use std::sync::Arc;

/// A scalar function of position at time 0.
pub type InitialFunction<const D: usize> = dyn Fn(&Point<D>) -> f64 + Send + Sync;

/// Name of the displacement `Y(x) - x` of the backward characteristics (2.2), one vector per node.
pub const DISPLACEMENT: &str = "displacement";

/// Index of a field in [`Fields`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FieldId(usize);

impl FieldId {
    /// Index of the field in its list.
    pub fn index(self) -> usize {
        self.0
    }
    /// The field of index `index`.
    pub(crate) fn at(index: usize) -> FieldId {
        FieldId(index)
    }
}

/// Values of a field.
#[derive(Debug, PartialEq)]
pub enum Data<const D: usize> {
    /// One number per P2 node; empty where composed transport evaluates the field on demand.
    Scalar(Vec<f64>),
    /// One vector per P2 node.
    Vector(Vec<SVector<f64, D>>),
    /// Positions of points that move.
    Points(Vec<Point<D>>),
    /// Plain numbers, for example the velocities of bodies.
    Numbers(Vec<f64>),
    /// Integer labels, one a node or a cell.
    Labels(Vec<u64>),
}

impl<const D: usize> Data<D> {
    /// Number of entries.
    pub fn len(&self) -> usize {
        match self {
            Data::Scalar(v) | Data::Numbers(v) => v.len(),
            Data::Vector(v) | Data::Points(v) => v.len(),
            Data::Labels(v) => v.len(),
        }
    }
    /// True if there are no entries.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
    fn kind(&self) -> u64 {
        match self {
            Data::Scalar(_) => 0,
            Data::Vector(_) => 1,
            Data::Points(_) => 2,
            Data::Numbers(_) => 3,
            Data::Labels(_) => 4,
        }
    }
    fn write(&self, out: &mut Writer) {
        out.integer(self.kind());
        match self {
            Data::Scalar(v) | Data::Numbers(v) => out.numbers(v),
            Data::Vector(v) | Data::Points(v) => out.vectors(v),
            Data::Labels(v) => {
                out.integer(v.len() as u64);
                v.iter().for_each(|label| out.integer(*label));
            }
        }
    }
    fn read(from: &mut Reader<'_>) -> Option<Data<D>> {
        Some(match from.integer()? {
            0 => Data::Scalar(from.numbers()?),
            1 => Data::Vector(from.vectors()?),
            2 => Data::Points(from.vectors()?),
            3 => Data::Numbers(from.numbers()?),
            4 => Data::Labels(from.list(Reader::integer)?),
            _ => return None,
        })
    }
}

impl<const D: usize> Clone for Data<D> {
    fn clone(&self) -> Self {
        match self {
            Data::Scalar(v) => Data::Scalar(v.clone()),
            Data::Vector(v) => Data::Vector(v.clone()),
            Data::Points(v) => Data::Points(v.clone()),
            Data::Numbers(v) => Data::Numbers(v.clone()),
            Data::Labels(v) => Data::Labels(v.clone()),
        }
    }
    /// Keeps the storage, so that a step allocates nothing after the first ones.
    fn clone_from(&mut self, other: &Self) {
        match (self, other) {
            (Data::Scalar(a), Data::Scalar(b)) | (Data::Numbers(a), Data::Numbers(b)) => {
                a.clone_from(b);
            }
            (Data::Vector(a), Data::Vector(b)) | (Data::Points(a), Data::Points(b)) => {
                a.clone_from(b);
            }
            (Data::Labels(a), Data::Labels(b)) => a.clone_from(b),
            (a, b) => *a = b.clone(),
        }
    }
}

/// A field and its name.
#[derive(Debug, PartialEq)]
pub struct Field<const D: usize> {
    /// Unique name, such as `membrane.level_set`.
    pub name: String,
    /// The values.
    pub data: Data<D>,
}

impl<const D: usize> Clone for Field<D> {
    fn clone(&self) -> Self {
        Field { name: self.name.clone(), data: self.data.clone() }
    }
    fn clone_from(&mut self, other: &Self) {
        self.name.clone_from(&other.name);
        self.data.clone_from(&other.data);
    }
}

/// All named fields at one time, in the order of their declaration.
///
/// Checkpoints, transfers to another mesh, the rollback of a rejected step and the predicted
/// configuration of a step are loops over this list.
#[derive(Debug, Default, PartialEq)]
pub struct Fields<const D: usize> {
    list: Vec<Field<D>>,
    /// The backward map of composed transport, from which level sets are evaluated.
    pub map: Option<CharacteristicMap<D>>,
}

impl<const D: usize> Clone for Fields<D> {
    fn clone(&self) -> Self {
        Fields { list: self.list.clone(), map: self.map.clone() }
    }
    fn clone_from(&mut self, other: &Self) {
        self.list.clone_from(&other.list);
        self.map.clone_from(&other.map);
    }
}

impl<const D: usize> Fields<D> {
    /// Number of fields.
    pub fn len(&self) -> usize {
        self.list.len()
    }
    /// True if there are no fields.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }
    /// The fields in their order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &Field<D>> {
        self.list.iter()
    }
    pub(crate) fn iter_mut(&mut self) -> impl ExactSizeIterator<Item = &mut Field<D>> {
        self.list.iter_mut()
    }
    /// Index of the field of that name.
    pub fn find(&self, name: &str) -> Option<FieldId> {
        self.list.iter().position(|f| f.name == name).map(FieldId)
    }
    fn get(&self, id: FieldId) -> Option<&Data<D>> {
        self.list.get(id.0).map(|f| &f.data)
    }
    /// Numbers of a field: nodal values or plain numbers; empty for other kinds.
    pub fn scalar(&self, id: FieldId) -> &[f64] {
        match self.get(id) {
            Some(Data::Scalar(v) | Data::Numbers(v)) => v,
            _ => &[],
        }
    }
    /// The same, mutable.
    pub fn scalar_mut(&mut self, id: FieldId) -> &mut [f64] {
        match self.list.get_mut(id.0).map(|f| &mut f.data) {
            Some(Data::Scalar(v) | Data::Numbers(v)) => v,
            _ => &mut [],
        }
    }
    /// Vectors of a field: nodal vectors or positions; empty for other kinds.
    pub fn vector(&self, id: FieldId) -> &[SVector<f64, D>] {
        match self.get(id) {
            Some(Data::Vector(v) | Data::Points(v)) => v,
            _ => &[],
        }
    }
    /// The same, mutable.
    pub fn vector_mut(&mut self, id: FieldId) -> &mut [SVector<f64, D>] {
        match self.list.get_mut(id.0).map(|f| &mut f.data) {
            Some(Data::Vector(v) | Data::Points(v)) => v,
            _ => &mut [],
        }
    }
    /// Labels of a field; empty for other kinds.
    pub fn labels(&self, id: FieldId) -> &[u64] {
        match self.get(id) {
            Some(Data::Labels(v)) => v,
            _ => &[],
        }
    }
    /// The same, mutable.
    pub fn labels_mut(&mut self, id: FieldId) -> &mut [u64] {
        match self.list.get_mut(id.0).map(|f| &mut f.data) {
            Some(Data::Labels(v)) => v,
            _ => &mut [],
        }
    }
    /// The displacement `Y(x) - x` of the backward characteristics; empty where they are not
    /// carried.
    pub fn displacement(&self) -> &[SVector<f64, D>] {
        self.find(DISPLACEMENT).map_or(&[], |id| self.vector(id))
    }
    /// True if `other` has the same names, kinds and sizes.
    pub fn fits(&self, other: &Fields<D>) -> bool {
        let same = |(a, b): (&Field<D>, &Field<D>)| {
            (&a.name, a.data.kind(), a.data.len()) == (&b.name, b.data.kind(), b.data.len())
        };
        let maps = |f: &Fields<D>| f.map.as_ref().and_then(|m| m.submaps().next().map(<[_]>::len));
        self.len() == other.len()
            && self.iter().zip(other.iter()).all(same)
            && maps(self) == maps(other)
    }
    /// Names and sizes, for error messages.
    pub fn sizes(&self) -> Vec<(String, usize)> {
        self.iter().map(|f| (f.name.clone(), f.data.len())).collect()
    }
    /// Appends all fields as bytes.
    pub(crate) fn write(&self, out: &mut Writer) {
        out.integer(self.list.len() as u64);
        for Field { name, data } in &self.list {
            out.text(name);
            data.write(out);
        }
        out.integer(self.map.iter().map(|m| m.submaps().len() as u64).sum());
        self.map.iter().flat_map(CharacteristicMap::submaps).for_each(|s| out.vectors(s));
    }
    /// Reads the bytes of [`write`](Self::write); `None` if they are damaged.
    pub(crate) fn read(from: &mut Reader<'_>) -> Option<Fields<D>> {
        let field =
            |from: &mut Reader<'_>| Some(Field { name: from.text()?, data: Data::read(from)? });
        let list = from.list(field)?;
        let map = CharacteristicMap::from_submaps(from.list(Reader::vectors)?);
        Some(Fields { list, map })
    }
}

/// Transport rule of the values of a field.
#[derive(Clone)]
pub enum Carry<const D: usize> {
    /// Constant along particle paths. Composed transport evaluates the function at time 0, if it is
    /// known between the nodes.
    Convected(Option<Arc<InitialFunction<D>>>),
    /// The displacement `Y(x) - x` of backward characteristics.
    BackwardMap,
    /// The function at time 0 composed with the backward characteristics, (2.5).
    OfBackwardMap(Arc<InitialFunction<D>>),
    /// By the structure that declared it ([`Structure::advance`](super::Structure::advance)).
    ByOwner,
}

/// Properties of a field.
#[derive(Clone)]
pub struct Rule<const D: usize> {
    /// Its transport.
    pub carry: Carry<D>,
    /// True if forces or materials depend on it, so that a step predicts it.
    pub acts: bool,
    /// True if field files contain it; nodal scalars and vectors only.
    pub written: bool,
}

/// The list of fields, while structures declare them.
pub struct Declaration<'a, const D: usize> {
    /// Number of P2 nodes.
    pub nodes: usize,
    /// Earlier values, for example from another mesh: they replace initial values.
    pub kept: &'a Fields<D>,
    fields: Fields<D>,
    rules: Vec<Rule<D>>,
}

impl<'a, const D: usize> Declaration<'a, D> {
    /// An empty list, on `nodes` P2 nodes.
    pub fn new(nodes: usize, kept: &'a Fields<D>) -> Declaration<'a, D> {
        Declaration { nodes, kept, fields: Fields::default(), rules: Vec::new() }
    }
    /// Declares a field with its values at time 0. A name that is already declared is shared: the
    /// first values count, and `acts` if any declaration sets it.
    pub fn add(&mut self, name: &str, rule: Rule<D>, initial: impl FnOnce() -> Data<D>) -> FieldId {
        if let Some(id) = self.fields.find(name) {
            self.rules[id.0].acts |= rule.acts;
            return id;
        }
        let kept = self.kept.find(name).and_then(|id| self.kept.get(id)).cloned();
        let data = kept.unwrap_or_else(initial);
        self.fields.list.push(Field { name: name.to_string(), data });
        self.rules.push(rule);
        FieldId(self.fields.len() - 1)
    }
    /// Declares the displacement of the backward characteristics.
    pub fn backward_map(&mut self, acts: bool) -> FieldId {
        let nodes = self.nodes;
        let rule = Rule { carry: Carry::BackwardMap, acts, written: true };
        self.add(DISPLACEMENT, rule, || Data::Vector(vec![SVector::zeros(); nodes]))
    }
    /// The fields and their rules.
    ///
    /// # Errors
    /// A rule for data that it cannot carry: scalars are convected, vectors are backward maps.
    pub fn finish(self) -> Result<(Fields<D>, Vec<Rule<D>>)> {
        for (field, rule) in self.fields.list.iter().zip(&self.rules) {
            let possible = match rule.carry {
                Carry::Convected(_) => matches!(field.data, Data::Scalar(_)),
                Carry::BackwardMap => matches!(field.data, Data::Vector(_)),
                _ => true,
            };
            if !possible {
                return Err(Error::internal(
                    "a field is declared with a rule that cannot carry it",
                )
                .at(format!("field {}", field.name)));
            }
        }
        Ok((self.fields, self.rules))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fields() -> Fields<2> {
        let kept = Fields::default();
        let mut declared = Declaration::new(3, &kept);
        let rule = |acts| Rule { carry: Carry::ByOwner, acts, written: false };
        declared.add("a.level_set", rule(false), || Data::Scalar(vec![0.5, -0.0, 1.0]));
        declared.add("a.points", rule(false), || Data::Points(vec![Point::<2>::new(0.25, 2.0)]));
        declared.add("a.numbers", rule(false), || Data::Numbers(vec![f64::MIN_POSITIVE]));
        declared.add("a.labels", rule(false), || Data::Labels(vec![7, 0, u64::MAX]));
        declared.backward_map(false);
        let (mut fields, _) = declared.finish().unwrap();
        fields.map = CharacteristicMap::from_submaps(vec![vec![Point::<2>::new(0.1, 0.2); 3]; 2]);
        fields
    }

    #[test]
    fn fields_come_back_from_bytes_and_cut_bytes_are_noticed() {
        let mut out = Writer(Vec::new());
        fields().write(&mut out);
        assert_eq!(Fields::read(&mut Reader(&out.0)), Some(fields()));
        for cut in 0..out.0.len() {
            assert_eq!(Fields::<2>::read(&mut Reader(&out.0[..cut])), None);
        }
    }

    #[test]
    fn a_name_is_shared_and_kept_values_replace_initial_ones() {
        let kept = fields();
        let mut declared = Declaration::new(3, &kept);
        let rule = |acts| Rule { carry: Carry::Convected(None), acts, written: true };
        let first = declared.add("a.level_set", rule(false), || Data::Scalar(vec![9.0; 3]));
        let again = declared.add("a.level_set", rule(true), || Data::Scalar(vec![8.0; 3]));
        let other = declared.add("b.level_set", rule(false), || Data::Scalar(vec![1.0; 3]));
        assert!(first == again && first != other);
        let (found, rules) = declared.finish().unwrap();
        assert_eq!(found.scalar(first), [0.5, -0.0, 1.0]);
        assert_eq!(found.scalar(other), [1.0; 3]);
        assert!(rules[0].acts && !rules[1].acts);
        assert!(!found.fits(&kept) && kept.fits(&fields()));
    }
}
