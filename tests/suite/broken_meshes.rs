//! Broken meshes: each gives an error of kind `Input` that names the place, the value and a remedy,
//! and nothing panics.

use super::meshes::recorded;
use immersa::base::{Kind, Result};
use immersa::mesh::gmsh::{self, MshData};
use immersa::mesh::{Mesh, check};
use proptest::prelude::*;
use std::path::Path;

/// A square of two triangles in version 2.2.
const OLD: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n1 1 \"wall\"\n2 \
    2 \"fluid\"\n$EndPhysicalNames\n\
    $Nodes\n4\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n$EndNodes\n\
    $Elements\n3\n1 1 2 1 1 1 2\n2 2 2 2 1 1 2 3\n3 2 2 2 1 1 3 4\n$EndElements\n";

/// The same in version 4.1.
const NEW: &str = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n1 1 \"wall\"\n2 \
    2 \"fluid\"\n$EndPhysicalNames\n\
    $Entities\n0 1 1 0\n1 0 0 0 1 0 0 1 1 0\n1 0 0 0 1 1 0 1 2 0\n$EndEntities\n\
    $Nodes\n1 4 1 4\n2 1 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n$EndNodes\n\
    $Elements\n2 3 1 3\n1 1 1 1\n1 1 2\n2 1 2 2\n2 1 2 3\n3 1 3 4\n$EndElements\n";

fn mesh<const D: usize>(bytes: &[u8]) -> Result<Mesh<D>> {
    Ok(MshData::parse(bytes, "broken.msh")?.mesh()?.0)
}

/// The error names the file and contains all the words.
fn refused(what: &str, result: Result<Mesh<2>>, words: &[&str]) {
    let Err(e) = result else { panic!("{what}: accepted") };
    let text = e.to_string();
    assert_eq!(e.kind(), Kind::Input, "{what}: {text}");
    assert!(e.place().contains("broken.msh"), "{what}: {text}");
    assert!(!e.wrong_value().is_empty() && !e.advice().is_empty(), "{what}: {text}");
    for word in words {
        assert!(text.contains(word), "{what}: {word} is missing in\n{text}");
    }
}

#[test]
fn the_unbroken_meshes_are_accepted() {
    for text in [OLD, NEW] {
        let m = mesh::<2>(text.as_bytes()).unwrap();
        assert_eq!(
            (m.cell_count(), m.boundary("wall").unwrap().len(), m.regions()["fluid"].len()),
            (2, 1, 2)
        );
    }
}

#[test]
fn broken_text_is_refused_with_place_value_and_remedy() {
    // What is wrong; the text, what to replace in it and by what; words of the message.
    let cases: &[(&str, &str, &str, &str, &[&str])] = &[
        ("version 1", OLD, "2.2 0 8", "1.0 0 8", &["line 2", "1.0", "-format msh41"]),
        ("version 5", NEW, "4.1 0 8", "5 0 8", &["line 2", "version", "-format msh41"]),
        ("kind 7", NEW, "4.1 0 8", "4.1 7 8", &["line 2", "ASCII", "7"]),
        ("header too short", NEW, "4.1 0 8", "4.1", &["line 2", "version"]),
        (
            "no end of header",
            NEW,
            "$EndMeshFormat\n",
            "",
            &["line 3", "$EndMeshFormat", "$PhysicalNames"],
        ),
        ("name without quotes", NEW, "\"wall\"", "wall", &["line 6", "quotation marks"]),
        (
            "dimension 9 of a name",
            NEW,
            "1 1 \"wall\"",
            "9 1 \"wall\"",
            &["line 6", "physical name"],
        ),
        (
            "coordinate NaN, 2.2",
            OLD,
            "3 1 1 0",
            "3 nan 1 0",
            &["line 13", "not a finite", "point 3", "NaN"],
        ),
        (
            "coordinate NaN, 4.1",
            NEW,
            "1 1 0\n0 1 0\n$",
            "1 NaN 0\n0 1 0\n$",
            &["line 23", "point 3", "NaN"],
        ),
        (
            "coordinate infinite",
            NEW,
            "1 1 0\n0 1 0\n$",
            "1 -1e999 0\n0 1 0\n$",
            &["line 23", "inf"],
        ),
        ("coordinate no number", OLD, "3 1 1 0", "3 1,0 1 0", &["line 13", "coordinate", "1,0"]),
        ("coordinate missing", OLD, "3 1 1 0", "3 1 1", &["line 15", "coordinate", "$EndNodes"]),
        ("point number twice", OLD, "3 1 1 0", "2 1 1 0", &["line 13", "same number", "2"]),
        ("point number negative", OLD, "3 1 1 0", "-3 1 1 0", &["line 13", "-3"]),
        ("count of points negative", OLD, "$Nodes\n4", "$Nodes\n-4", &["line 10", "-4"]),
        (
            "count of points huge",
            OLD,
            "$Nodes\n4",
            "$Nodes\n99999999999999999",
            &["line 10", "99999999999999999", "size"],
        ),
        ("count of points too great", OLD, "$Nodes\n4", "$Nodes\n5", &["line 15", "$EndNodes"]),
        ("count of points too small", OLD, "$Nodes\n4", "$Nodes\n3", &["line 14", "$EndNodes"]),
        (
            "count of blocks huge",
            NEW,
            "$Nodes\n1 4",
            "$Nodes\n4000000000 4",
            &["line 15", "4000000000"],
        ),
        ("count in block huge", NEW, "2 1 0 4", "2 1 0 40000000", &["line 16", "40000000", "size"]),
        ("count in block wrong", NEW, "$Nodes\n1 4", "$Nodes\n1 5", &["line 15", "4 instead of 5"]),
        (
            "count of elements huge",
            NEW,
            "2 1 2 2\n",
            "2 1 2 2000000000\n",
            &["line 30", "2000000000"],
        ),
        ("count of elements negative", NEW, "2 1 2 2\n", "2 1 2 -2\n", &["line 30", "-2"]),
        (
            "count of names huge",
            NEW,
            "$PhysicalNames\n2",
            "$PhysicalNames\n1e9",
            &["line 5", "1e9"],
        ),
        (
            "count of entities huge",
            NEW,
            "$Entities\n0 1 1 0",
            "$Entities\n0 1 1000000 0",
            &["line 10", "1000000"],
        ),
        ("flag of parameters wrong", NEW, "2 1 0 4", "2 1 5 4", &["line 16", "parameters"]),
        (
            "point that does not exist, 2.2",
            OLD,
            "1 1 3 4",
            "1 1 3 44",
            &["line 20", "point 44", "4 points"],
        ),
        (
            "point that does not exist, 4.1",
            NEW,
            "3 1 3 4",
            "3 1 3 44",
            &["line 32", "point 44", "4 points"],
        ),
        (
            "quadrangles, 2.2",
            OLD,
            "3 2 2 2 1 1 3 4",
            "3 3 2 2 1 1 2 3 4",
            &["line 20", "quadrangles", "type 3", "Recombine"],
        ),
        (
            "quadrangles, 4.1",
            NEW,
            "2 1 2 2\n2 1 2 3\n3 1 3 4",
            "2 1 3 1\n2 1 2 3 4",
            &["line 30", "quadrangles", "Recombine"],
        ),
        ("hexahedra", NEW, "2 1 2 2\n", "2 1 5 2\n", &["line 30", "hexahedra"]),
        ("prisms", NEW, "2 1 2 2\n", "2 1 6 2\n", &["line 30", "prisms"]),
        ("pyramids", NEW, "2 1 2 2\n", "2 1 7 2\n", &["line 30", "pyramids"]),
        ("order 3", NEW, "2 1 2 2\n", "2 1 21 2\n", &["line 30", "order 3", "-order 1"]),
        ("type 999", NEW, "2 1 2 2\n", "2 1 999 2\n", &["line 30", "999", "not known"]),
        ("negative number of tags", OLD, "3 2 2 2 1", "3 2 -2 2 1", &["line 20", "-2 tags"]),
        ("stray text", OLD, "$Elements", "Elements", &["line 16", "section", "Elements"]),
        (
            "no points",
            OLD,
            "$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n$EndNodes\n",
            "",
            &["line 11", "does not exist", "0 points"],
        ),
        (
            "points only",
            NEW,
            "$Elements\n2 3 1 3\n1 1 1 1\n1 1 2\n2 1 2 2\n2 1 2 3\n3 1 3 4\n$EndElements\n",
            "",
            &["$Elements", "4 points", "gmsh -2"],
        ),
        (
            "lines only",
            NEW,
            "2 3 1 3\n1 1 1 1\n1 1 2\n2 1 2 2\n2 1 2 3\n3 1 3 4\n",
            "1 1 1 1\n1 1 1 1\n1 1 2\n",
            &["neither triangles", "1 lines"],
        ),
        (
            "not flat",
            OLD,
            "3 1 1 0",
            "3 1 1 0.25",
            &["point 3 at [1.0, 1.0, 0.25]", "z = 0 and 0.25", "x-y plane"],
        ),
        ("degenerate", OLD, "3 1 1 0", "3 2 0 0", &["cell 0", "degenerate", "[2.0, 0.0]"]),
        ("a point twice in a cell", OLD, "1 1 3 4", "1 1 3 3", &["cell 1", "degenerate"]),
        (
            "not a manifold",
            NEW,
            "$Elements\n2 3 1 3\n1 1 1 1\n1 1 2\n2 1 2 2\n",
            "$Elements\n1 3 1 3\n2 1 2 3\n9 1 2 3\n",
            &["overlap", "cells [0, 1]"],
        ),
        (
            "tetrahedra among triangles",
            NEW,
            "2 3 1 3\n1 1 1 1\n1 1 2\n2 1 2 2\n2 1 2 3\n3 1 3 4",
            "3 3 1 3\n1 1 1 1\n1 1 2\n2 1 2 1\n2 1 2 3\n3 1 4 1\n3 1 2 3 4",
            &["dimension 3", "2 is needed"],
        ),
    ];
    for (what, text, old, new, words) in cases {
        assert_eq!(text.matches(old).count(), 1, "{what}: the case itself is wrong");
        refused(what, mesh(text.replace(old, new).as_bytes()), words);
    }
    assert!(cases.len() >= 40);
}

#[test]
fn other_files_are_refused() {
    refused("empty", mesh(b""), &["empty", "-format msh41"]);
    refused("spaces", mesh(b" \n\n "), &["empty"]);
    refused("text", mesh(b"Dear reader,\nthis is no mesh.\n"), &["line 1", "no MSH file", "Dear"]);
    refused("picture", mesh(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR"), &["no MSH file"]);
    refused("version 1", mesh(b"$NOD\n3\n1 0 0 0\n"), &["$NOD", "-format msh41"]);
    refused("header only", mesh(b"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"), &["$Nodes"]);
    refused("4.0 binary", mesh(b"$MeshFormat\n4 1 8\n"), &["4.0", "line 2"]);
    refused(
        "big-endian",
        mesh(b"$MeshFormat\n2.2 1 8\n\0\0\0\x01\n$EndMeshFormat\n"),
        &["big-endian", "byte 20", "-bin"],
    );
    refused(
        "32-bit",
        mesh(b"$MeshFormat\n4.1 1 4\n\x01\0\0\0\n$EndMeshFormat\n"),
        &["4", "64-bit"],
    );
    let e = gmsh::read::<2>(Path::new("no/such/broken.msh")).unwrap_err();
    assert!(
        e.kind() == Kind::Input
            && e.place() == "no/such/broken.msh"
            && e.to_string().contains("No such file")
    );
}

#[test]
fn three_triangles_on_an_edge_are_refused() {
    let points = "5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 -1 0\n5 1 -1 0\n";
    let text = format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{points}$EndNodes\n\
         $Elements\n3\n1 2 0 1 2 3\n2 2 0 1 4 2\n3 2 0 1 5 2\n$EndElements\n"
    );
    refused("fan", mesh(text.as_bytes()), &["manifold", "cell 2", "[1.0, 0.0]", "cells [0, 1, 2]"]);
}

#[test]
fn an_inverted_cell_is_turned_round_and_reported() {
    let m = mesh::<2>(OLD.replace("1 1 3 4", "1 1 4 3").as_bytes()).unwrap();
    assert_eq!(m.volume(), 1.0);
    let (_, warnings) = check(&m);
    let report = warnings.iter().find(|w| w.what.contains("inverted")).unwrap();
    assert!(report.what.contains("cell 1") && report.what.contains("0.333"), "{report}");
}

#[test]
fn a_file_cut_anywhere_is_refused() {
    for name in [
        "pieces-22.msh",
        "pieces-22-bin.msh",
        "pieces-40.msh",
        "pieces-41.msh",
        "pieces-41-bin.msh",
    ] {
        let whole = recorded(name);
        // Without its last line end a file is still whole.
        for length in 0..whole.len() - 1 {
            refused(&format!("{name}, {length} bytes"), mesh(&whole[..length]), &[]);
        }
    }
}

#[test]
fn a_binary_file_with_wrong_counts_is_refused_at_its_byte() {
    let whole = recorded("pieces-41-bin.msh");
    let nodes = whole.windows(7).position(|w| w == b"$Nodes\n").unwrap() + 7;
    for wrong in [u64::MAX, 1 << 40, 1 << 20] {
        let mut bytes = whole.clone();
        bytes[nodes..nodes + 8].copy_from_slice(&wrong.to_le_bytes());
        let byte = format!("byte {nodes}");
        refused("blocks", mesh(&bytes), &[&byte, &wrong.to_string(), "size of the file"]);
    }
    let whole = recorded("pieces-22-bin.msh");
    let elements = whole.windows(13).position(|w| w == b"$Elements\n53\n").unwrap() + 13;
    for wrong in [-1i32, 0, i32::MAX] {
        let mut bytes = whole.clone();
        bytes[elements + 4..elements + 8].copy_from_slice(&wrong.to_le_bytes());
        refused("block", mesh(&bytes), &[&format!("byte {elements}"), &wrong.to_string()]);
    }
    let mut bytes = whole.clone();
    let coordinate = whole.windows(10).position(|w| w == b"$Nodes\n21\n").unwrap() + 10 + 4;
    bytes[coordinate..coordinate + 8].copy_from_slice(&f64::NAN.to_le_bytes());
    refused("NaN", mesh(&bytes), &[&format!("byte {coordinate}"), "point 1", "NaN"]);
}

/// Whatever the bytes are, there is a mesh or an error of kind `Input`.
fn survives(bytes: &[u8]) {
    let outcome = |e: immersa::base::Error| {
        assert!(e.kind() == Kind::Input && !e.place().is_empty(), "{e}");
    };
    match MshData::parse(bytes, "any.msh") {
        Err(e) => outcome(e),
        Ok(data) => {
            data.mesh::<2>().map(|(m, _)| check(&m)).map_or_else(outcome, drop);
            data.mesh::<3>().map(|(m, _)| check(&m)).map_or_else(outcome, drop);
        }
    }
}

const VALID: [&str; 8] = [
    "pieces-22.msh",
    "pieces-22-bin.msh",
    "pieces-40-parametric.msh",
    "pieces-41.msh",
    "pieces-41-bin-parametric.msh",
    "pieces-41-partitioned.msh",
    "cube-41-bin.msh",
    "cube-22-bin-parametric.msh",
];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn arbitrary_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..300), start in 0usize..6) {
        let header = [
            "",
            "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n",
            "$MeshFormat\n2.2 1 8\n\x01\0\0\0\n$EndMeshFormat\n$Nodes\n3\n",
            "$MeshFormat\n4.1 1 8\n\x01\0\0\0\n$EndMeshFormat\n$Nodes\n",
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Elements\n",
            "$MeshFormat\n4.1 1 8\n\x01\0\0\0\n$EndMeshFormat\n$Entities\n",
        ][start];
        survives(&[header.as_bytes(), &bytes].concat());
    }

    #[test]
    fn damaged_files_never_panic(
        file in prop::sample::select(&VALID[..]),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0usize..5), 1..6),
    ) {
        let mut bytes = recorded(file);
        for (place, value, kind) in changes {
            let at = place.index(bytes.len());
            match kind {
                0 => bytes[at] = value,
                1 => bytes[at] ^= 1 << (value % 8),
                2 => { bytes.remove(at); }
                3 => bytes.insert(at, value),
                _ => { bytes.drain(at..(at + value as usize).min(bytes.len() - 1).max(at)); }
            }
        }
        survives(&bytes);
    }

    #[test]
    fn changed_numbers_never_panic(
        file in prop::sample::select(&["pieces-22.msh", "pieces-40.msh", "pieces-41.msh", "cube-41.msh"][..]),
        changes in prop::collection::vec((any::<prop::sample::Index>(), 0usize..9), 1..4),
    ) {
        let text = String::from_utf8(recorded(file)).unwrap();
        let mut words: Vec<&str> = text.split_inclusive([' ', '\n']).collect();
        let new = ["-1 ", "0 ", "99999999 ", "9223372036854775807 ", "-9223372036854775808 ", "nan ", "1e308 ", "", "15 "];
        for (place, k) in changes {
            let at = place.index(words.len());
            words[at] = new[k];
        }
        survives(words.concat().as_bytes());
    }
}
