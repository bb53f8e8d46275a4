//! What the benches compute: a stretched ball in a closed box with a flow that turns.

use immersa::elastic::{AreaLaw, Membrane};
use immersa::fem::{
    Basis, Cells, Condition, Element, Numbering, Rule, Space, assemble_flow_matrix,
};
use immersa::flow::FlowSolver;
use immersa::linalg::{Factor, Ordering, SymmetricMatrix};
use immersa::mesh::{Diagonals, Mesh, Point, box_mesh, rectangle};
use immersa::sim::{Coupling, Fluid, Simulation, SimulationSettings};
use immersa::structure::{Immersed, ImmersedInterface};
use nalgebra::{SMatrix, SVector};
use std::sync::Arc;

/// The time step.
pub const DT: f64 = 5e-3;

/// The pieces of a step.
pub struct Case<const D: usize> {
    pub velocity: Basis<D>,
    pub pressure: Basis<D>,
    pub conditions: Vec<(String, Condition<D>)>,
    pub u: Vec<SVector<f64, D>>,
    pub phi: Vec<f64>,
}

impl Case<2> {
    pub fn plane(n: usize) -> Self {
        Case::new(rectangle([0.0; 2], [2.0; 2], [n; 2], Diagonals::UnionJack).unwrap())
    }
}
impl Case<3> {
    pub fn space(n: usize) -> Self {
        Case::new(box_mesh([0.0; 3], [2.0; 3], [n; 3]).unwrap())
    }
}

impl<const D: usize> Case<D> {
    pub fn new(mesh: Mesh<D>) -> Self {
        let conditions =
            mesh.boundaries().keys().map(|name| (name.clone(), Condition::NoSlip)).collect();
        let mesh = Arc::new(mesh);
        let (p2, p1) = [Element::P2, Element::P1].map(|e| Arc::new(Space::new(&mesh, e))).into();
        let rule = Arc::new(Rule::simplex(D, 5));
        let bump = |x: &Point<D>| x.iter().map(|x| x * (2.0 - x)).product::<f64>();
        let u = p2.interpolate(|x| {
            let mut u = SVector::<f64, D>::zeros();
            (u[0], u[1]) = (bump(x) * (x[1] - 1.0), bump(x) * (1.0 - x[0]));
            u
        });
        let phi = p2.interpolate(|x| 1.2 * ((x - Point::<D>::repeat(1.0)).norm() - 0.6));
        Case {
            velocity: Basis::new(&p2, &rule),
            pressure: Basis::new(&p1, &rule),
            conditions,
            u,
            phi,
        }
    }
    pub fn thickness(&self) -> f64 {
        2.0 * self.velocity.space().mesh().diameter(0)
    }
    pub fn membrane(&self) -> Membrane<D> {
        Membrane::new(AreaLaw::Linear { modulus: 1.0 }, self.thickness())
    }
    pub fn solver(&self) -> FlowSolver<D> {
        let (velocity, pressure) = (self.velocity.space(), self.pressure.space());
        FlowSolver::new(velocity, pressure, self.velocity.rule(), &self.conditions, 1.0).unwrap()
    }
    pub fn numbering(&self) -> Numbering<D> {
        Numbering::new(self.velocity.space(), self.pressure.space(), &self.conditions).unwrap()
    }
    pub fn empty_matrix(&self, numbering: &Numbering<D>) -> SymmetricMatrix {
        let (u, p) = (self.velocity.space(), self.pressure.space());
        let groups = (0..u.mesh().cell_count()).map(|c| {
            let mut list = Vec::new();
            numbering.cell_unknowns(u.cell_nodes(c), Some(p.cell_nodes(c)), &mut list);
            list
        });
        SymmetricMatrix::from_groups(numbering.order(), groups).unwrap()
    }
    pub fn assemble(&self, numbering: &Numbering<D>, matrix: &mut SymmetricMatrix) {
        matrix.zero();
        let form = |_: &_, u: &SVector<f64, D>, grad: &SMatrix<f64, D, D>| {
            (u / DT, (grad + grad.transpose()) * 0.01 + SMatrix::identity() * grad.trace())
        };
        assemble_flow_matrix(
            &self.velocity,
            Some(&self.pressure),
            numbering,
            Cells::All,
            matrix,
            &mut Vec::new(),
            form,
        )
        .unwrap();
    }
    pub fn factored(&self) -> (SymmetricMatrix, Factor) {
        let numbering = self.numbering();
        let mut matrix = self.empty_matrix(&numbering);
        self.assemble(&numbering, &mut matrix);
        let ordering = Ordering::saddle_point(&matrix, numbering.first_pressure()).unwrap();
        let mut factor = Factor::analyse(&matrix, ordering).unwrap();
        factor.refactor(&matrix).unwrap();
        (matrix, factor)
    }
    pub fn simulation(&self, order: usize, coupling: Coupling) -> Simulation<D> {
        let settings = SimulationSettings {
            order,
            grad_div: 1.0,
            ..SimulationSettings::new(
                DT,
                Fluid { density: 1.0, viscosity: 0.01 },
                self.conditions.clone(),
            )
        };
        let (membrane, phi) = (self.membrane(), self.phi.clone());
        let structure = Immersed::boxed(
            ImmersedInterface::new("membrane", phi, self.thickness())
                .stretched(1.2)
                .coupled(coupling),
            membrane,
        );
        let mesh = self.velocity.space().mesh();
        let mut simulation =
            Simulation::new(mesh, settings, vec![structure], |_| SVector::zeros()).unwrap();
        for _ in 0..2 {
            simulation.step().unwrap();
        }
        simulation
    }
}
