//! The unknowns of a vesicle on its interface, and their equations.

use super::{Bent, MOMENT_ACROSS, TENSION_ACROSS};
use crate::fem::{At, Element, MAX_LOCAL, Rule as Quadrature, Space, SurfacePoint, VectorForm};
use crate::flow::block::Block;
use crate::levelset::cut_cells;
use crate::mesh::NONE;
use nalgebra::{SMatrix, SVector};

/// Layers of cells about the cut ones whose unknowns are in the matrix, so that its pattern lasts
/// until the interface leaves them.
const LAYERS: usize = 2;

/// The unknowns on the interface, the points of their forms, and the forms.
#[derive(Clone, Default)]
pub(super) struct System<const D: usize> {
    /// Cells whose unknowns the matrix has, and for each its tensions, moments, and the jump of the
    /// pressure.
    pub cells: Vec<u32>,
    unknowns: Vec<Vec<u32>>,
    len: usize,
    points: Vec<At<D>>,
    forms: Vec<Form<D>>,
    pub rates: Rates,
}

/// Numbers of a step.
#[derive(Clone, Copy, Default)]
pub(super) struct Rates {
    /// `1/(k dt)`.
    pub softness: f64,
    /// `1/dt`.
    pub rate: f64,
    /// `-ln(L/L_0)/dt`.
    pub stretching: f64,
    /// `(A_0 - A)/(L dt)`.
    pub swelling: f64,
}

/// What is integrated at a point.
#[derive(Clone)]
pub(super) enum Form<const D: usize> {
    /// A point of the interface.
    Surface(Box<OnSurface<D>>),
    /// A point in a cut cell: normal derivatives of the linear and the quadratic functions, times
    /// the roots of their weights.
    Across { tension: [f64; MAX_LOCAL], moment: [f64; MAX_LOCAL] },
    /// Unknowns that no form has: the bits of their local numbers.
    Idle(u32),
}

/// The forms at a point of the interface.
#[derive(Clone)]
pub(super) struct OnSurface<const D: usize> {
    barycentric: [f64; 4],
    values: [f64; MAX_LOCAL],
    gradients: [SVector<f64, D>; MAX_LOCAL],
    normal: SVector<f64, D>,
    /// `II` in space, 0 in the plane.
    form: SMatrix<f64, D, D>,
    /// `H* - c`.
    curvature: f64,
}

/// A local unknown.
enum Unknown {
    Tension(usize),
    Moment(usize),
    Jump,
}

impl<const D: usize> System<D> {
    const MOMENTS: usize = (D + 1) * (D + 2) / 2;

    fn local(k: usize) -> Unknown {
        match k {
            k if k <= D => Unknown::Tension(k),
            k if k <= D + Self::MOMENTS => Unknown::Moment(k - D - 1),
            _ => Unknown::Jump,
        }
    }

    /// Takes the cells of label 1 for those of the unknowns if the interface is in them, or else those
    /// about it.
    pub fn ring(
        &mut self,
        space: &Space<D>,
        identified: &[u32],
        points: &[SurfacePoint<D>],
        known: &[u64],
    ) {
        let cut = cut_cells(points);
        let chosen = known.iter().enumerate().filter(|(_, label)| **label == 1);
        let known: Vec<u32> = chosen.map(|(c, _)| c as u32).collect();
        let cells = if holds(&known, &cut) { known } else { about(space, identified, &cut) };
        if cells != self.cells {
            self.number(space, identified, cells);
        }
    }

    /// Makes the forms for an interface in the cells of the unknowns.
    pub fn place(
        &mut self,
        space: &Space<D>,
        bent: &Bent<D>,
        forms: &[SMatrix<f64, D, D>],
        (spontaneous, viscosity): (f64, f64),
    ) {
        let groups: Vec<&[SurfacePoint<D>]> =
            bent.points.chunk_by(|a, b| a.at.cell == b.at.cell).collect();
        self.points.clear();
        self.forms.clear();
        let mut used = vec![false; self.len];
        let positions = groups.iter().map(|g| self.cells.binary_search(&(g[0].at.cell as u32)));
        for i in positions.flatten() {
            self.unknowns[i].iter().for_each(|&k| used[k as usize] = true);
        }
        let across = Quadrature::simplex(D, 2);
        let mut next = groups.iter().peekable();
        for (i, &cell) in self.cells.iter().enumerate() {
            let c = cell as usize;
            let mesh = space.mesh();
            let corner = mesh.points()[mesh.cell(c)[0] as usize];
            if let Some(group) = next.next_if(|g| g[0].at.cell == c) {
                for p in group.iter() {
                    let inverse = &mesh.map(c).inverse;
                    let g = space.element().reference_gradients::<D>(&p.at.barycentric);
                    let form = OnSurface {
                        barycentric: p.at.barycentric,
                        values: space.element().values::<D>(&p.at.barycentric),
                        gradients: g.map(|g| p.tangential(&inverse.tr_mul(&g))),
                        normal: p.normal,
                        form: forms.get(p.at.q).copied().unwrap_or(SMatrix::zeros()),
                        curvature: bent.curvature[p.at.q] - spontaneous,
                    };
                    self.points.push(At { q: self.points.len(), ..p.at });
                    self.forms.push(Form::Surface(Box::new(form)));
                }
                let (map, size) = (mesh.map(c), mesh.diameter(c));
                let mut middle = [0.0; 4];
                middle[..=D].fill(1.0 / (D as f64 + 1.0));
                let normal = space.gradient(&bent.phi, c, &middle).try_normalize(0.0);
                let normal = normal.unwrap_or(group[0].normal);
                let roots = [(TENSION_ACROSS / viscosity).sqrt(), (MOMENT_ACROSS * size).sqrt()];
                for (l, w) in across.points.iter().zip(&across.weights) {
                    let derivatives = |element: Element, root: f64| {
                        let g = element.reference_gradients::<D>(l);
                        g.map(|g| root * normal.dot(&map.inverse.tr_mul(&g)))
                    };
                    let tension = derivatives(Element::P1, roots[0]);
                    let moment = derivatives(Element::P2, roots[1]);
                    let (q, weight) = (self.points.len(), w * map.volume);
                    self.points.push(At { cell: c, q, barycentric: *l, x: corner, weight });
                    self.forms.push(Form::Across { tension, moment });
                }
            }
            let mut idle = 0;
            for (k, &unknown) in self.unknowns[i].iter().enumerate() {
                if !std::mem::replace(&mut used[unknown as usize], true) {
                    idle |= 1 << k;
                }
            }
            if idle != 0 {
                let (q, barycentric) = (self.points.len(), [1.0, 0.0, 0.0, 0.0]);
                self.points.push(At { cell: c, q, barycentric, x: corner, weight: 1.0 });
                self.forms.push(Form::Idle(idle));
            }
        }
    }

    /// Numbers the unknowns of these cells.
    fn number(&mut self, space: &Space<D>, identified: &[u32], cells: Vec<u32>) {
        self.cells = cells;
        let mut count = 0;
        let mut numbers = [vec![NONE; identified.len()], vec![NONE; identified.len()]];
        let mut number = |list: usize, node: u32| {
            let number = &mut numbers[list][identified[node as usize] as usize];
            if *number == NONE {
                *number = count;
                count += 1;
            }
            *number
        };
        self.unknowns = Vec::with_capacity(self.cells.len());
        for &c in &self.cells {
            let nodes = space.cell_nodes(c as usize);
            let tensions: Vec<u32> = nodes[..=D].iter().map(|&n| number(0, n)).collect();
            let moments = nodes.iter().map(|&n| number(1, n));
            self.unknowns.push(tensions.into_iter().chain(moments).collect());
        }
        self.unknowns.iter_mut().for_each(|list| list.push(count));
        self.len = count as usize + 1;
    }
}

/// True if the ascending list `all` has each of `some`.
pub(super) fn holds(all: &[u32], some: &[u32]) -> bool {
    some.iter().all(|c| all.binary_search(c).is_ok())
}

/// Cut cells with some layers of cells about them, ascending.
pub(super) fn about<const D: usize>(space: &Space<D>, identified: &[u32], cut: &[u32]) -> Vec<u32> {
    let mesh = space.mesh();
    let corners = |c: usize| mesh.cell(c).iter().map(|&v| identified[v as usize] as usize);
    let mut chosen = vec![false; mesh.cell_count()];
    cut.iter().for_each(|&c| chosen[c as usize] = true);
    for _ in 0..LAYERS {
        let mut near = vec![false; identified.len()];
        let inside = (0..chosen.len()).filter(|&c| chosen[c]);
        inside.flat_map(corners).for_each(|n| near[n] = true);
        for c in 0..chosen.len() {
            chosen[c] = chosen[c] || corners(c).any(|n| near[n]);
        }
    }
    (0..chosen.len()).filter(|&c| chosen[c]).map(|c| c as u32).collect()
}

impl<const D: usize> Block<D> for System<D> {
    fn len(&self) -> usize {
        self.len
    }
    fn points(&self) -> &[At<D>] {
        &self.points
    }
    fn cells(&self) -> Option<&[u32]> {
        Some(&self.cells)
    }
    fn unknowns(&self, cell: usize, out: &mut Vec<u32>) {
        if let Ok(i) = self.cells.binary_search(&(cell as u32)) {
            out.extend_from_slice(&self.unknowns[i]);
        }
    }
    fn coupling(&self, at: &At<D>, k: usize) -> VectorForm<D> {
        let zero = (SVector::zeros(), SMatrix::zeros());
        let Form::Surface(f) = &self.forms[at.q] else { return zero };
        match Self::local(k) {
            Unknown::Tension(k) => {
                let tangential = SMatrix::identity() - f.normal * f.normal.transpose();
                (SVector::zeros(), tangential * f.barycentric[k])
            }
            Unknown::Moment(k) => {
                let along = f.normal * f.gradients[k].transpose();
                (SVector::zeros(), along - f.form * f.values[k])
            }
            Unknown::Jump => (f.normal, SMatrix::zeros()),
        }
    }
    fn own(&self, at: &At<D>, j: usize, k: usize) -> f64 {
        let softness = self.rates.softness;
        match (&self.forms[at.q], Self::local(j), Self::local(k)) {
            (Form::Surface(f), Unknown::Moment(j), Unknown::Moment(k)) => {
                -softness * f.values[j] * f.values[k]
            }
            (Form::Across { tension, .. }, Unknown::Tension(j), Unknown::Tension(k)) => {
                -tension[j] * tension[k]
            }
            (Form::Across { moment, .. }, Unknown::Moment(j), Unknown::Moment(k)) => {
                -softness * moment[j] * moment[k]
            }
            (Form::Idle(bits), ..) if j == k && bits >> k & 1 == 1 => -1.0,
            _ => 0.0,
        }
    }
    fn source(&self, at: &At<D>, k: usize) -> f64 {
        let Form::Surface(f) = &self.forms[at.q] else { return 0.0 };
        match Self::local(k) {
            Unknown::Tension(k) => self.rates.stretching * f.barycentric[k],
            Unknown::Moment(k) => -self.rates.rate * f.curvature * f.values[k],
            Unknown::Jump => self.rates.swelling,
        }
    }
}
