//! The program of section 3.6.1.1 of the book, written against the library: a stretched elliptical
//! membrane relaxes to a circle in a viscous fluid. Line by line the FreeFEM original, with a
//! grad-div term, which it needs to be stable.
//!
//!     cargo run --release --example membrane

#![allow(clippy::print_stdout, reason = "an example prints its results")]

use immersa::base::Result;
use immersa::elastic::{AreaLaw, Membrane};
use immersa::fem::{Condition, Element, Rule, Space};
use immersa::flow::{Coefficient, FlowSolver, History, Step};
use immersa::levelset::{Contour, Ellipse, signed_distance};
use immersa::mesh::{Diagonals, Point, rectangle};
use immersa::output::{FieldData, write_pvd, write_vtu};
use immersa::transport::{Feet, Tracer, carry_nodal};
use std::path::Path;
use std::sync::Arc;

fn main() -> Result<()> {
    // Settings
    let n = 30; // squares in each direction
    let (a, b) = (0.75, 0.5); // axes of the ellipse
    let lambda = 1.0; // stiffness
    let reynolds = 100.0;
    let stretch = 1.26253110; // at the start
    let (dt, end, shown) = (5e-3, 0.4, 0.1);
    let eps = 1.5 * 2.0 / n as f64; // half-width of the band
    let grad_div = 1.0;

    // Mesh and spaces
    let mesh = Arc::new(rectangle([0.0, 0.0], [2.0, 2.0], [n, n], Diagonals::UnionJack)?);
    let p2 = Arc::new(Space::new(&mesh, Element::P2)); // velocity and level set
    let p1 = Arc::new(Space::new(&mesh, Element::P1)); // pressure
    let rule = Arc::new(Rule::simplex(2, 5));

    // The ellipse: its signed distance carries the initial stretch
    let ellipse = Ellipse::new(Point::<2>::new(1.0, 1.0), Point::<2>::new(a, b), 0.0)?;
    let mut phi: Vec<f64> = signed_distance(&p2, &ellipse).iter().map(|d| stretch * d).collect();
    let area = Contour::new(&p2, &phi)?.measures()?.area;

    // Navier-Stokes, with the stress (3.16) of the membrane: E'(r) = lambda (r - 1)
    let walls = vec![("walls".to_string(), Condition::NoSlip)];
    let mut flow = FlowSolver::new(&p2, &p1, &rule, &walls, grad_div)?;
    flow.set_materials(Coefficient::Constant(1.0), Coefficient::Constant(1.0 / reynolds));
    let mut membrane = Membrane::new(AreaLaw::Linear { modulus: lambda }, eps);
    let mut state = flow.at_rest();

    // Characteristics: FreeFEM's convect
    let tracer = Tracer::new(&p2, &[]);
    let (mut points, mut nodes) = (Feet::default(), Feet::default());

    std::fs::create_dir_all("runs").ok();
    let mut files = Vec::new();
    for k in 1..=(end / dt + 0.5) as usize {
        let t = k as f64 * dt;

        // Navier-Stokes equations
        let old = state.u.clone();
        tracer.from_quadrature(&old, dt, flow.velocity(), &mut points);
        membrane.prepare(flow.velocity(), &phi, None);
        let history = [History { weight: 1.0, u: &old, feet: Some(&points) }];
        flow.step(
            &Step { terms: &[&membrane], ..Step::backward_euler(t, dt, &history) },
            &mut state,
        )?;

        // Transport of phi
        tracer.from_nodes(&state.u, dt, &mut nodes);
        carry_nodal(&p2, &phi.clone(), &nodes, &mut phi);

        if k % (shown / dt + 0.5) as usize == 0 {
            let m = Contour::new(&p2, &phi)?.measures()?;
            let change = 100.0 * (m.area / area - 1.0);
            println!("t = {t:.2}  axes {:.5} {:.5}  area {change:+.4} %", m.extent_x, m.extent_y);
            let name = format!("membrane_{k:04}.vtu");
            let fields = [
                ("velocity", FieldData::Vector(&state.u)),
                ("pressure", FieldData::Scalar(&state.p)),
                ("phi", FieldData::Scalar(&phi)),
            ];
            write_vtu(&Path::new("runs").join(&name), &p2, t, &fields)?;
            files.push((t, name));
        }
    }
    write_pvd(Path::new("runs/membrane.pvd"), &files)
}
