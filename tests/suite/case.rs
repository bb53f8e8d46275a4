//! A scene that a test steps through and measures.

use immersa::fem::vector_errors;
use immersa::mesh::Point;
use immersa::scene::{Diagnostics, Model, Scene};
use nalgebra::{SMatrix, SVector};
use std::path::Path;

pub type V = SVector<f64, 2>;

pub struct Case {
    pub scene: Scene,
    pub model: Model,
}

/// The message that the scene of a text with some values changed is refused with: it has a place, a value and a remedy.
pub fn refused(text: &str, changes: &[&str]) -> String {
    let changes: Vec<String> = changes.iter().map(ToString::to_string).collect();
    let scene = Scene::parse_with(text, Path::new("scene.toml"), &changes);
    match scene.and_then(|scene| Model::<2>::new(&scene).map(drop)) {
        Ok(()) => panic!("{changes:?} was not refused"),
        Err(e) => {
            assert!(!e.place().is_empty() && !e.wrong_value().is_empty() && !e.advice().is_empty(), "{e}");
            e.to_string()
        }
    }
}

impl Case {
    /// The scene of a text; meshes are looked for in `meshes/`.
    pub fn new(text: &str) -> Case {
        Case::with(text, &[])
    }
    /// The same with some values changed: `key=value`.
    pub fn with(text: &str, changes: &[&str]) -> Case {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("meshes/scene.toml");
        let changes: Vec<String> = changes.iter().map(ToString::to_string).collect();
        let scene = Scene::parse_with(text, &path, &changes).unwrap_or_else(|e| panic!("{e}\n{text}"));
        let mut model = Model::<2>::new(&scene).unwrap_or_else(|e| panic!("{e}\n{text}"));
        model.simulation.keep_reactions(true);
        Case { scene, model }
    }
    /// Steps to the end of the scene.
    pub fn run(mut self) -> Case {
        self.steps(self.scene.time.steps() - self.model.simulation.state().steps as usize);
        self
    }
    pub fn steps(&mut self, count: usize) {
        for _ in 0..count {
            self.model.simulation.step().unwrap();
        }
    }
    pub fn time(&self) -> f64 {
        self.model.simulation.time()
    }
    /// A column of the series, now.
    pub fn get(&self, column: &str) -> f64 {
        let diagnostics = Diagnostics::new(&self.scene, &self.model).unwrap();
        let k = diagnostics.columns().iter().position(|c| c == column);
        let k = k.unwrap_or_else(|| panic!("no column {column} in {:?}", diagnostics.columns()));
        diagnostics.row(&self.model).unwrap()[k]
    }
    pub fn velocity(&self) -> &[V] {
        &self.model.simulation.state().flow.u
    }
    /// Largest error of the velocity at a node.
    pub fn largest_error(&self, exact: impl Fn(&Point<2>, f64) -> V) -> f64 {
        let (nodes, t) = (self.model.simulation.space().nodes(), self.time());
        let error = |(x, u): (&Point<2>, &V)| (u - exact(x, t)).norm();
        nodes.iter().zip(self.velocity()).map(error).fold(0.0, f64::max)
    }
    /// Error of the velocity in L2.
    pub fn error(&self, exact: impl Fn(&Point<2>, f64) -> V + Sync) -> f64 {
        let t = self.time();
        let exact = |x: &Point<2>| (exact(x, t), SMatrix::zeros());
        vector_errors(self.model.simulation.space(), self.velocity(), exact).l2
    }
    /// Largest error of the pressure at a node.
    pub fn pressure_error(&self, exact: impl Fn(&Point<2>) -> f64) -> f64 {
        let sim = &self.model.simulation;
        let nodes = sim.flow().unwrap().pressure().space().nodes();
        nodes.iter().zip(&sim.state().flow.p).map(|(x, p)| (p - exact(x)).abs()).fold(0.0, f64::max)
    }
}
