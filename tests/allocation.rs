//! What a step allocates, and that what a scene does not need is not there. In a program of its
//! own: it counts all allocations.

use immersa::mesh::Location;
use immersa::scene::{ImmersedFlow, Scene};
use std::alloc::{GlobalAlloc, Layout, System};
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// The system's allocator, with a count of the calls and of the bytes that are held.
struct Counting;

static CALLS: AtomicUsize = AtomicUsize::new(0);
static BYTES: AtomicUsize = AtomicUsize::new(0);
static HELD: AtomicUsize = AtomicUsize::new(0);

#[allow(
    unsafe_code,
    reason = "an allocator can be watched only from within; each call is handed on as it came"
)]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        CALLS.fetch_add(1, Relaxed);
        BYTES.fetch_add(layout.size(), Relaxed);
        HELD.fetch_add(layout.size(), Relaxed);
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size(), Relaxed);
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// The counts are of the whole program: one test at a time.
static ALONE: Mutex<()> = Mutex::new(());

/// A cavity with `n` x `n` squares, and what is added to its scene.
fn cavity(n: usize, fluid: &str, more: &str) -> ImmersedFlow {
    // Along characteristics, whose matrix stays: iterations keep vectors of their own.
    let traced = "[numerics]\nconvection = \"pironneau1982\"\n";
    let more = match (more.contains("convection"), more.contains("[numerics]\n")) {
        (true, _) => more.to_string(),
        (_, true) => more.replace("[numerics]\n", traced),
        _ => format!("{more}\n{traced}"),
    };
    let text = format!(
        "[mesh]\nrectangle = {{ min = [0, 0], max = [2, 2], cells = [{n}, {n}] }}\n\
         [fluid]\nviscosity = 0.01\n{fluid}\n\
         [boundary.walls]\nno_slip = true\n[boundary.top]\nvelocity = [\"sin(pi * x)\", 0]\n\
         [time]\nend = 1\nstep = 0.01\n{more}"
    );
    ImmersedFlow::<2>::new(&Scene::parse(&text, Path::new("scene.toml")).unwrap()).unwrap()
}

const MEMBRANE: &str = "[[membrane]]\nshape.circle = { centre = [1, 1], radius = 0.5 }\nstretch = \
    1.2\narea.linear = { modulus = 1 }\nforce = \"smeared\"\n\
                        [numerics]\nthickness = 0.2\ncoupling = \"explicit\"\n";

/// The same scene with the semi-implicit coupling.
fn semi_implicit() -> String {
    format!("order = 1\n{}", MEMBRANE.replace("explicit", "semi-implicit"))
}

/// Allocations of one step, after others have made room.
fn calls_of_a_step(mut model: ImmersedFlow, constant_matrix: bool) -> usize {
    for _ in 0..3 {
        model.simulation.step().unwrap();
    }
    let before = CALLS.load(Relaxed);
    let report = model.simulation.step().unwrap();
    assert_eq!(report.refactored || report.solve.iterations > 0, !constant_matrix);
    CALLS.load(Relaxed) - before
}

/// Bytes that a scene holds after two steps.
fn bytes_held(n: usize, fluid: &str, more: &str) -> usize {
    let before = HELD.load(Relaxed);
    let mut model = cavity(n, fluid, more);
    for _ in 0..2 {
        model.simulation.step().unwrap();
    }
    HELD.load(Relaxed) - before
}

#[test]
fn a_step_allocates_no_more_often_on_a_finer_mesh() {
    let _alone = ALONE.lock();
    let implicit = MEMBRANE.replace("explicit", "implicit");
    let semi = semi_implicit();
    for (fluid, more, constant_matrix) in [
        ("", "", true),
        ("density = 0", "", true),
        ("", MEMBRANE, true),
        ("", &implicit, false),
        ("", &semi, true),
    ] {
        let coarse = calls_of_a_step(cavity(16, fluid, more), constant_matrix);
        let fine = calls_of_a_step(cavity(32, fluid, more), constant_matrix);
        // Lists that grow by doubling, and the queues of the threads, may ask a few times more.
        assert!(coarse < 60, "{coarse} allocations in a step");
        assert!(fine <= coarse + 15, "{coarse} allocations in a step on 512 cells, {fine} on 2048");
    }
}

/// Less than a number for each node of the coarser mesh takes.
const LITTLE: usize = 6_000;

#[test]
fn a_warmed_up_step_allocates_nothing_that_grows_with_the_mesh() {
    let _alone = ALONE.lock();
    // Lists are made for the first time, and threads start.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let first = format!("order = 1\n{MEMBRANE}");
    let projected = format!("{MEMBRANE}transport = \"projected\"\n");
    let implicit = MEMBRANE.replace("explicit", "implicit");
    for (fluid, more) in [
        ("", ""),
        ("density = 0", ""),
        ("", &first[..]),
        ("", MEMBRANE),
        ("", &projected),
        ("", &implicit),
    ] {
        for n in [16, 32] {
            let mut model = cavity(n, fluid, more);
            let mut step = || {
                let before = BYTES.load(Relaxed);
                model.simulation.step().unwrap();
                BYTES.load(Relaxed) - before
            };
            let bytes = pool.install(|| {
                for _ in 0..4 {
                    step();
                }
                // Lists that follow the band, and the vectors of iterations, grow by doubling now
                // and then.
                (0..4).map(|_| step()).min().unwrap_or_default()
            });
            assert!(
                bytes < LITTLE,
                "{bytes} bytes allocated in a step on {n} x {n} squares: {fluid} {more}"
            );
        }
    }
}

#[test]
fn what_a_scene_does_not_need_is_not_allocated() {
    let _alone = ALONE.lock();
    let (n, cells) = (24, 2 * 24 * 24);
    // Feet of the quadrature points: a cell and barycentric coordinates each, two sets for the
    // second order.
    let feet = 2 * cells * 7 * size_of::<Location>();
    let projection = format!("{MEMBRANE}transport = \"projected\"\n");
    // Threads and libraries make their own buffers at the first use.
    bytes_held(n, "", &projection);
    let navier_stokes = bytes_held(n, "", "");
    let stokes = bytes_held(n, "density = 0", "");
    let unconvected = bytes_held(n, "", "[numerics]\nconvection = false\n");
    let membrane = bytes_held(n, "", MEMBRANE);
    let projected = bytes_held(n, "", &projection);
    assert!(
        navier_stokes - stokes >= feet,
        "Stokes flow: {stokes} bytes, Navier-Stokes flow: {navier_stokes}, feet: {feet}"
    );
    assert!(navier_stokes - unconvected >= feet);
    assert!(membrane > navier_stokes);
    // Nodal transport has no mass matrix, and only the semi-implicit coupling has a predictor: no
    // factor is held but that of the flow.
    let factors = |more: &str| {
        let mut model = cavity(n, "", more);
        model.simulation.step().unwrap();
        model.simulation.factor_bytes() - model.simulation.flow().factor().unwrap().bytes()
    };
    assert_eq!(factors(MEMBRANE), 0);
    let mass = factors(&projection);
    assert_eq!(factors(&semi_implicit()), mass);
    assert!(mass > 0 && projected - membrane > mass);
}
