//! A scene that a test steps through and measures.

use immersa::base::Result;
use immersa::fem::{Space, vector_errors};
use immersa::mesh::Point;
use immersa::scene::{Advected, ImmersedFlow, Problem, Scene, Segmented, problem};
use immersa::sim::{Carried, State};
use nalgebra::{SMatrix, SVector};
use std::borrow::Cow;
use std::path::Path;
use std::sync::Arc;

pub type V = SVector<f64, 2>;

/// A problem of the plane that a scene is built as.
pub trait Built: Problem + Sized {
    fn build(scene: &Scene) -> Result<Self>;
    fn parts(&self) -> (&Carried<2>, &State<2>);
    fn level_set(&self, k: usize) -> Cow<'_, [f64]> {
        let (carried, state) = self.parts();
        carried.level_set(&state.fields, k)
    }
    fn space(&self) -> &Arc<Space<2>> {
        self.parts().0.space()
    }
}

impl Built for ImmersedFlow {
    fn build(scene: &Scene) -> Result<Self> {
        let mut flow = ImmersedFlow::new(scene)?;
        flow.simulation.keep_reactions(true);
        Ok(flow)
    }
    fn parts(&self) -> (&Carried<2>, &State<2>) {
        (self.simulation.carried(), self.simulation.state())
    }
}

impl Built for Advected {
    fn build(scene: &Scene) -> Result<Self> {
        Advected::new(scene)
    }
    fn parts(&self) -> (&Carried<2>, &State<2>) {
        (self.advection.carried(), self.advection.state())
    }
}

impl Built for Segmented {
    fn build(scene: &Scene) -> Result<Self> {
        Segmented::new(scene)
    }
    fn parts(&self) -> (&Carried<2>, &State<2>) {
        (self.segmenting.carried(), self.segmenting.state())
    }
}

pub struct Case<P = ImmersedFlow> {
    pub scene: Scene,
    pub model: P,
}

/// The message that the scene of a text with some values changed is refused with: it has a place, a
/// value and a remedy.
pub fn refused(text: &str, changes: &[&str]) -> String {
    let changes: Vec<String> = changes.iter().map(ToString::to_string).collect();
    let scene = Scene::parse_with(text, Path::new("scene.toml"), &changes);
    match scene.and_then(|scene| problem(&scene).map(drop)) {
        Ok(()) => panic!("{changes:?} was not refused"),
        Err(e) => {
            assert!(
                !e.place().is_empty() && !e.wrong_value().is_empty() && !e.advice().is_empty(),
                "{e}"
            );
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
        Case::of(text, changes)
    }
}

impl<P: Built> Case<P> {
    /// The scene of a text with some values changed.
    pub fn of(text: &str, changes: &[&str]) -> Case<P> {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("meshes/scene.toml");
        let changes: Vec<String> = changes.iter().map(ToString::to_string).collect();
        let scene =
            Scene::parse_with(text, &path, &changes).unwrap_or_else(|e| panic!("{e}\n{text}"));
        let model = P::build(&scene).unwrap_or_else(|e| panic!("{e}\n{text}"));
        Case { scene, model }
    }
    /// Steps to the end of the scene.
    pub fn run(mut self) -> Case<P> {
        self.steps(self.scene.time.steps() - self.model.moment().steps as usize);
        self
    }
    pub fn steps(&mut self, count: usize) {
        for _ in 0..count {
            self.model.step().unwrap();
        }
    }
    pub fn time(&self) -> f64 {
        self.model.moment().time
    }
    /// A column of the series, now.
    pub fn get(&self, column: &str) -> f64 {
        let row = self.model.row().unwrap();
        row.get(column).unwrap_or_else(|| panic!("no column {column} in {:?}", row.names()))
    }
    /// The state as bytes.
    pub fn bytes(&self) -> Vec<u8> {
        self.model.save(7)[1].clone()
    }
    /// Continues from these bytes.
    pub fn resume(&mut self, bytes: &[u8]) {
        self.model.restore([&[], bytes], 7, None).unwrap();
    }
}

impl Case {
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
        let nodes = sim.flow().pressure().space().nodes();
        nodes.iter().zip(&sim.state().flow.p).map(|(x, p)| (p - exact(x)).abs()).fold(0.0, f64::max)
    }
}
