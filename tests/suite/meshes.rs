//! Meshes of gmsh: all formats give the same mesh, which is also what another reader finds.
//!
//! `tests/data/gmsh` holds recorded files (its `make.sh` says how they were made), so that no test
//! needs gmsh. One test also meshes the sources in `meshes/` afresh; without gmsh it compares
//! nothing and says so.

use immersa::base::Warning;
use immersa::mesh::gmsh::{self, MshData};
use immersa::mesh::{Location, Locator, Mesh, Point, check};
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

pub fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

pub fn recorded(name: &str) -> Vec<u8> {
    std::fs::read(root().join("tests/data/gmsh").join(name)).unwrap()
}

fn parse<const D: usize>(bytes: &[u8], name: &str) -> (Mesh<D>, Vec<Warning>) {
    let data = MshData::parse(bytes, name).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(data.dimension(), Ok(D));
    data.mesh().unwrap_or_else(|e| panic!("{e}"))
}

fn cells<const D: usize>(mesh: &Mesh<D>) -> Vec<u32> {
    (0..mesh.cell_count()).flat_map(|c| mesh.cell(c)).copied().collect()
}

/// Same numbers, same names; coordinates up to the 16 digits that gmsh writes in text.
fn assert_same<const D: usize>(a: &Mesh<D>, b: &Mesh<D>, name: &str) {
    assert_eq!(a.points().len(), b.points().len(), "{name}");
    for (p, q) in a.points().iter().zip(b.points()) {
        assert!((p - q).amax() <= 1e-15 * (1.0 + p.amax()), "{name}: {p:?} {q:?}");
    }
    assert_eq!(cells(a), cells(b), "{name}");
    assert_eq!(a.boundaries(), b.boundaries(), "{name}");
    assert_eq!(a.regions(), b.regions(), "{name}");
}

fn sizes(parts: &BTreeMap<String, Vec<u32>>) -> Vec<(&str, usize)> {
    parts.iter().map(|(name, members)| (name.as_str(), members.len())).collect()
}

/// Some warning contains all these words.
fn warned(warnings: &[Warning], words: &[&str]) -> bool {
    warnings.iter().any(|w| words.iter().all(|word| w.what.contains(word)) && !w.remedy.is_empty())
}

const VARIANTS: [&str; 11] = [
    "22.msh",
    "22-bin.msh",
    "40.msh",
    "41-bin.msh",
    "22-parametric.msh",
    "22-bin-parametric.msh",
    "40-parametric.msh",
    "41-parametric.msh",
    "41-bin-parametric.msh",
    "22-order2.msh",
    "41-order2.msh",
];

#[test]
fn all_formats_give_the_same_plane_mesh() {
    let (first, warnings) = parse::<2>(&recorded("pieces-41.msh"), "pieces-41");
    assert_eq!((first.points().len(), first.cell_count(), first.facets().len()), (21, 32, 8));
    assert!((first.volume() - 4.0).abs() < 1e-9);
    // Elements in two groups; a group without a name has its number; the rim lies inside.
    assert_eq!(sizes(first.regions()), [("all", 32), ("inner disc", 6)]);
    assert_eq!(sizes(first.boundaries()), [("17", 4), ("sides", 4)]);
    assert!(warned(&warnings, &["pieces-41", "6 sides", "\"rim\"", "[1.4, 1.0"]), "{warnings:?}");
    assert!(warned(&warnings, &["\"corner\"", "dimension 0"]), "{warnings:?}");
    for variant in VARIANTS {
        let (mesh, w) = parse::<2>(&recorded(&format!("pieces-{variant}")), variant);
        assert_same(&first, &mesh, variant);
        assert_eq!(warned(&w, &["order 2"]), variant.contains("order2"));
        assert_eq!(w.len(), 2 + usize::from(variant.contains("order2")), "{variant}: {w:?}");
    }
}

#[test]
fn all_formats_give_the_same_mesh_in_space() {
    let (first, warnings) = parse::<3>(&recorded("cube-41.msh"), "cube-41");
    assert_eq!((first.points().len(), first.cell_count(), first.facets().len()), (53, 155, 84));
    assert!((first.volume() - 1.0).abs() < 1e-14 && warnings.is_empty());
    assert_eq!(sizes(first.regions()), [("all", 155), ("ball", 9)]);
    assert_eq!(sizes(first.boundaries()), [("left", 14), ("right", 14)]);
    for &f in first.boundary("right").unwrap() {
        assert!(
            first
                .facet_points(&first.facets()[f as usize])
                .all(|v| first.points()[v as usize][0] == 1.0)
        );
    }
    for variant in VARIANTS {
        assert_same(&first, &parse::<3>(&recorded(&format!("cube-{variant}")), variant).0, variant);
    }
}

#[test]
fn files_with_all_elements_or_with_partitions_hold_the_same_cells() {
    let sorted = |mesh: &Mesh<2>| -> BTreeSet<Vec<[u64; 2]>> {
        let point = |v: &u32| mesh.points()[*v as usize].map(|x| (x * 1e9).round() as u64).into();
        let cell = |c: usize| {
            let mut points: Vec<[u64; 2]> = mesh.cell(c).iter().map(point).collect();
            points.sort_unstable();
            points
        };
        (0..mesh.cell_count()).map(cell).collect()
    };
    let (plain, _) = parse::<2>(&recorded("pieces-41.msh"), "plain");
    for name in ["pieces-41-bin-all.msh", "pieces-41-partitioned.msh", "pieces-22-partitioned.msh"]
    {
        let (mesh, _) = parse::<2>(&recorded(name), name);
        assert_eq!(sorted(&plain), sorted(&mesh), "{name}");
        assert_eq!(sizes(plain.regions()), sizes(mesh.regions()), "{name}");
        assert_eq!(sizes(plain.boundaries()), sizes(mesh.boundaries()), "{name}");
    }
    // The centre of the circle comes with -save_all; 2.2 loses the groups then, which is said.
    let (mesh, warnings) = parse::<2>(&recorded("pieces-22-bin-all.msh"), "all");
    assert_eq!(sorted(&plain), sorted(&mesh));
    assert!(warned(&warnings, &["point 5", "[1.0, 1.0, 0.0]", "no cell"]), "{warnings:?}");
    assert!(warned(&warnings, &["\"sides\"", "no elements"]), "{warnings:?}");
}

/// Points, cells (as coordinates) and groups of regions as mshio reads them.
fn compare_with_mshio<const D: usize>(name: &str) {
    let bytes = recorded(name);
    let (mesh, _) = parse::<D>(&bytes, name);
    let theirs = mshio::parse_msh_bytes(&bytes).unwrap_or_else(|e| panic!("{name}: {e:?}")).data;
    let mut points = BTreeMap::new();
    for block in theirs.nodes.unwrap().node_blocks {
        let first = points.len() as u64 + 1; // these files number points in order
        for (i, n) in block.nodes.iter().enumerate() {
            points.insert(first + i as u64, [n.x, n.y, n.z]);
        }
    }
    let wanted = if D == 2 { mshio::ElementType::Tri3 } else { mshio::ElementType::Tet4 };
    let entities = theirs.entities.unwrap();
    let groups: BTreeMap<i32, Vec<i32>> = if D == 2 {
        entities.surfaces.iter().map(|s| (s.tag, s.physical_tags.clone())).collect()
    } else {
        entities.volumes.iter().map(|v| (v.tag, v.physical_tags.clone())).collect()
    };
    let mut members: BTreeMap<i32, usize> = BTreeMap::new();
    let mut c = 0;
    for block in theirs.elements.unwrap().element_blocks.iter().filter(|b| b.element_type == wanted)
    {
        for element in &block.elements {
            for (v, tag) in mesh.cell(c).iter().zip(&element.nodes) {
                assert_eq!(
                    mesh.points()[*v as usize].as_slice(),
                    &points[tag][..D],
                    "{name}, cell {c}"
                );
            }
            c += 1;
        }
        for group in &groups[&block.entity_tag] {
            *members.entry(*group).or_default() += block.elements.len();
        }
    }
    assert_eq!(c, mesh.cell_count());
    let ours: Vec<usize> = mesh.regions().values().map(Vec::len).collect();
    let mut theirs: Vec<usize> = members.into_values().collect();
    theirs.sort_unstable_by(|a, b| b.cmp(a));
    assert_eq!(ours, theirs, "{name}");
}

#[test]
fn version_4_1_is_read_as_mshio_reads_it() {
    compare_with_mshio::<2>("pieces-41.msh");
    compare_with_mshio::<2>("pieces-41-bin.msh");
    compare_with_mshio::<3>("cube-41.msh");
    compare_with_mshio::<3>("cube-41-bin.msh");
}

#[test]
fn point_numbers_may_have_gaps_and_any_order() {
    let text = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Whatever\n1 2 3\n$EndWhatever\n\
        $Entities\n0 0 1 0\n-7 0 0 0 1 1 0 1 -4 0\n$EndEntities\n\
        $Nodes\n1 3 5 4000000000\n2 -7 0 3\n4000000000\n5\n77\n0 0 3\n1 0 3\n0 1 3\n$EndNodes\n\
        $Elements\n1 1 9 9\n2 -7 2 1\n9 77 4000000000 5\n$EndElements\n";
    // Windows line ends and space at both ends change nothing.
    for text in [text.to_owned(), text.replace('\n', "\r\n"), format!("\n\n{text}\n\n  ")] {
        let (mesh, warnings) = parse::<2>(text.as_bytes(), "gaps");
        assert_eq!((cells(&mesh), mesh.volume(), warnings.len()), (vec![2, 0, 1], 0.5, 0));
        assert_eq!(sizes(mesh.regions()), [("4", 1)]);
    }
}

#[test]
fn meshes_that_come_with_the_program_are_sound_and_named() {
    let read = |name: &str| root().join("meshes").join(name);
    let (square, w) = gmsh::read::<2>(&read("box.msh")).unwrap();
    assert!(w.is_empty() && (square.volume() - 4.0).abs() < 1e-12);
    assert_eq!(
        square.boundaries().keys().collect::<Vec<_>>(),
        ["bottom", "left", "right", "top", "walls"]
    );
    let (channel, w) = gmsh::read::<2>(&read("channel.msh")).unwrap();
    assert!(w.is_empty() && channel.boundaries().len() == 4);
    // A polygon inscribed in the cylinder is cut out.
    let n = channel.boundary("cylinder").unwrap().len() as f64;
    let polygon = 0.5 * n * 0.05f64.powi(2) * (std::f64::consts::TAU / n).sin();
    assert!((channel.volume() - (2.2 * 0.41 - polygon)).abs() < 1e-6);
    let (disc, w) = gmsh::read::<2>(&read("disc.msh")).unwrap();
    assert!(w.is_empty() && disc.boundary("wall").unwrap().len() == disc.facets().len());
    let (ball, w) = gmsh::read::<3>(&read("ball.msh")).unwrap();
    assert!(w.is_empty() && (ball.volume() - 8.0).abs() < 1e-12 && ball.regions().len() == 2);
    for (quality, warnings) in [check(&square), check(&channel), check(&disc)] {
        assert!(
            warnings.is_empty() && quality.smallest_angle.value > 30.0 && quality.parts == 1,
            "{warnings:?}"
        );
    }
    let (quality, warnings) = check(&ball);
    assert!(warnings.is_empty() && quality.smallest_angle.value > 15.0, "{warnings:?}");
}

#[test]
fn a_ball_in_a_box_is_fine_about_the_sphere_alone() {
    let (mesh, warnings) = gmsh::read::<3>(&root().join("meshes/ball-in-box.msh")).unwrap();
    assert!(warnings.is_empty() && (mesh.volume() - 8.0).abs() < 1e-12, "{warnings:?}");
    let names: Vec<&str> = mesh.boundaries().keys().map(String::as_str).collect();
    assert_eq!(names, ["back", "bottom", "front", "left", "right", "top", "walls"]);
    assert_eq!(mesh.boundary("walls").unwrap().len(), mesh.facets().len());
    let centre =
        |c: usize| mesh.cell(c).iter().map(|&v| mesh.points()[v as usize]).sum::<Point<3>>() / 4.0;
    let ball = &mesh.regions()["ball"];
    assert!(ball.iter().all(|&c| centre(c as usize).norm() < 0.5));
    assert_eq!(ball.len() + mesh.regions()["fluid"].len(), mesh.cell_count());
    // A polyhedron with its corners on the sphere.
    let volume: f64 = ball.iter().map(|&c| mesh.map(c as usize).volume).sum::<f64>()
        / (std::f64::consts::PI / 6.0);
    assert!((0.97..1.0).contains(&volume), "{volume}");
    for c in 0..mesh.cell_count() {
        if (centre(c).norm() - 0.5).abs() < 0.05 {
            assert!(mesh.diameter(c) < 0.3, "cell {c}: {}", mesh.diameter(c));
        }
    }
    let (quality, warnings) = check(&mesh);
    assert!(warnings.is_empty() && quality.greatest_diameter.value > 0.4, "{warnings:?}");
    assert!(quality.smallest_angle.value > 15.0, "{}", quality.smallest_angle.value);
}

#[test]
fn walks_round_the_cylinder_of_the_channel_agree_with_the_grid() {
    let (mesh, _) = gmsh::read::<2>(&root().join("meshes/channel.msh")).unwrap();
    let locator = Locator::new(&mesh);
    let strategy = (0..mesh.cell_count(), (0.0..1.0f64, 0.0..1.0f64), (0.0..0.6f64, -0.1..0.5f64));
    let mut runner = TestRunner::new(Config::with_cases(5000));
    let outcome = runner.run(&strategy, |(c, (a, b), (x, y))| {
        let (a, b) = if a + b > 1.0 { (1.0 - a, 1.0 - b) } else { (a, b) };
        let from =
            mesh.point_at(&Location { cell: c as u32, barycentric: [1.0 - a - b, a, b, 0.0] });
        let to = Point::<2>::new(x, y);
        let (end, arrived) = mesh.walk(c as u32, &from, &to);
        let p = mesh.point_at(&end);
        let direction = (to - from).normalize();
        // The end lies on the segment, and what is before it is inside.
        prop_assert!(
            (p - from).perp(&direction).abs() < 1e-12 && (p - from).dot(&direction) > -1e-12
        );
        for i in 0..20 {
            prop_assert!(
                locator.locate(&mesh, &(from + (p - from) * (f64::from(i) / 20.0))).is_some()
            );
        }
        if arrived {
            prop_assert!((p - to).norm() < 1e-12 && locator.locate(&mesh, &to).is_some());
        } else {
            // The boundary is left there. Parts that the segment misses by less than 1e-7 cannot be
            // told from touched ones.
            let beyond = p + direction * 1e-7;
            prop_assert!(end.barycentric[..3].iter().any(|&l| l < 1e-12));
            prop_assert!(locator.locate(&mesh, &beyond).is_none() || (to - p).norm() < 1e-7);
        }
        Ok(())
    });
    assert!(outcome.is_ok(), "{}", outcome.unwrap_err());
}

/// Meshes a source with the gmsh of this machine; `None` if there is none.
fn meshed(source: &Path, options: &[&str], folder: &Path) -> Option<Vec<u8>> {
    let out = folder.join("out.msh");
    let run =
        Command::new("gmsh").arg(source).args(options).args(["-v", "1", "-o"]).arg(&out).output();
    let output = match run {
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return None,
        run => run.unwrap(),
    };
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    Some(std::fs::read(out).unwrap())
}

#[test]
#[expect(clippy::print_stderr, reason = "a test that has nothing to compare must say so")]
fn the_gmsh_of_this_machine_gives_the_same_mesh_in_all_formats() {
    let folder = tempfile::tempdir().unwrap();
    for (name, dimension) in
        [("box", "-2"), ("channel", "-2"), ("disc", "-2"), ("ball", "-3"), ("ball-in-box", "-3")]
    {
        let source = root().join("meshes").join(format!("{name}.geo"));
        let formats: [&[&str]; 5] =
            [&["msh41"], &["msh41", "-bin"], &["msh22"], &["msh22", "-bin"], &["msh40"]];
        let mut files = Vec::new();
        for format in formats {
            let options: Vec<&str> = [&[dimension, "-format"], format].concat();
            match meshed(&source, &options, folder.path()) {
                Some(bytes) => files.push((format.join(" "), bytes)),
                None => {
                    eprintln!("gmsh is not installed: only recorded meshes are compared");
                    return;
                }
            }
        }
        for (format, bytes) in &files[1..] {
            let label = format!("{name} {format}");
            if dimension == "-2" {
                assert_same(&parse::<2>(&files[0].1, name).0, &parse::<2>(bytes, &label).0, &label);
            } else {
                assert_same(&parse::<3>(&files[0].1, name).0, &parse::<3>(bytes, &label).0, &label);
            }
        }
    }
}
