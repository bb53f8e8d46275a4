//! Pictures, film, charts and report of a run that was truly computed.

use super::run_folder;
use immersa::scene::render::render;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Every file below a folder with its bytes.
fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut all = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() {
            all.extend(contents(&path).into_iter().map(|(k, v)| (format!("{name}/{k}"), v)));
        } else {
            all.insert(name, fs::read(path).unwrap());
        }
    }
    all
}

#[test]
fn a_run_is_rendered_whole_and_the_same_every_time() {
    let dir = tempfile::tempdir().unwrap();
    let run = dir.path().join("run");
    run_folder::write(&run, 20, 40, 10);
    let made = render(&run).unwrap();
    assert!(made.warnings.is_empty(), "{:?}", made.warnings);
    let first = contents(&run);
    let charts = [
        "axes-membrane",
        "chords-membrane",
        "stretch",
        "area",
        "energy",
        "energy-balance",
        "speed",
        "step",
        "probe-middle",
    ];
    let pictures = (0..5).map(|k| format!("pictures/{k:06}.png"));
    let others =
        ["film.gif", "charts/probe-inside.svg", "charts/profile-pressure.svg", "report.html"]
            .map(String::from);
    for name in pictures.chain(charts.map(|c| format!("charts/{c}.svg"))).chain(others) {
        assert!(first.contains_key(&name), "{name} was not made");
        assert!(made.files.contains(&run.join(&name)), "{name} is not among the files");
    }
    assert_eq!(made.report, run.join("report.html"));

    // Elsewhere, and in a process that has drawn before.
    let copy = dir.path().join("copy");
    for (name, bytes) in first.iter().filter(|(n, _)| !made.files.contains(&run.join(n))) {
        fs::create_dir_all(copy.join(name).parent().unwrap()).unwrap();
        fs::write(copy.join(name), bytes).unwrap();
    }
    render(&copy).unwrap();
    let second = contents(&copy);
    assert_eq!(first.keys().collect::<Vec<_>>(), second.keys().collect::<Vec<_>>());
    for (name, bytes) in &first {
        assert!(*bytes == second[name], "{name} differs the second time");
    }

    report_is_complete(std::str::from_utf8(&first["report.html"]).unwrap(), &run);
    nothing_is_on_the_page_twice(&first);
}

fn report_is_complete(page: &str, folder: &Path) {
    let alarm = page.find(run_folder::ALARM).expect("the alarm is on the page");
    assert!(alarm < page.find("class=\"numbers\"").unwrap(), "the alarm comes first");
    let headings = [
        "Pictures",
        "Charts",
        "Balances",
        "Numbers",
        "What was computed",
        "Settings",
        "Files in this folder",
    ];
    for text in headings.iter().chain(&[
        "ParaView",
        "membrane.level_set",
        "circle of the same area",
        "stretch = 1.2625316",
    ]) {
        assert!(page.contains(text), "{text} is missing");
    }
    // Nothing is fetched: every address is one that holds its data, and links lead to files of the
    // folder.
    for address in page.split("src=\"").skip(1) {
        assert!(address.starts_with("data:"), "src={address:.60}");
    }
    for address in page.split("url(").skip(1) {
        assert!(address.starts_with('#'), "url({address:.60}");
    }
    let links: Vec<&str> =
        page.split("<a href=\"").skip(1).map(|a| a.split('"').next().unwrap()).collect();
    assert_eq!(page.matches("href=").count(), links.len(), "only links have addresses");
    for file in ["series.csv", "charts/energy.svg", "charts/profile-pressure.svg"] {
        assert!(links.contains(&file), "no link to {file}");
    }
    for file in links {
        assert!(folder.join(file).exists(), "a link to {file}, which is not there");
    }
    for (i, _) in page.match_indices("http") {
        assert!(page[..i].ends_with("xmlns=\""), "an address: {:.80}", &page[i..]);
    }
    assert!(!page.contains("<script src") && !page.contains("<link") && !page.contains("@import"));
    for call in ["fetch(", "XMLHttpRequest", "import(", "eval("] {
        assert!(!page.contains(call), "{call}");
    }
}

/// The page holds the film and three pictures once, and little else.
fn nothing_is_on_the_page_twice(files: &BTreeMap<String, Vec<u8>>) {
    let shown = ["film.gif", "pictures/000000.png", "pictures/000002.png", "pictures/000004.png"];
    let size = |name: &str| files[name].len();
    let pictures: usize = shown.iter().map(|name| size(name)).sum();
    let page = size("report.html");
    let more = page - pictures * 4 / 3;
    let charts: usize = files.keys().filter(|n| n.ends_with(".svg")).map(|n| size(n)).sum();
    assert!(more < charts + size("series.csv") + 150_000, "{more} of {page} bytes");
}

#[test]
fn the_program_renders_a_run_and_refuses_what_is_none() {
    let dir = tempfile::tempdir().unwrap();
    let run = dir.path().join("run");
    run_folder::write(&run, 8, 4, 2);
    let program = || assert_cmd::Command::cargo_bin("immersa").unwrap();
    let good = program()
        .arg("render")
        .arg(&run)
        .args(["--set", "output.picture.size=300"])
        .assert()
        .code(0);
    let said = String::from_utf8_lossy(&good.get_output().stdout).into_owned();
    assert!(said.contains("report.html") && run.join("report.html").is_file(), "{said}");
    let other = dir.path().join("other");
    run_folder::write(&other, 8, 4, 2);
    let both = program()
        .arg("render")
        .args([&run, &other])
        .arg("--out")
        .arg(dir.path().join("two.html"))
        .assert()
        .code(0);
    let said = String::from_utf8_lossy(&both.get_output().stdout).into_owned();
    assert!(said.contains("two.html") && dir.path().join("two.html").is_file(), "{said}");
    program().arg("render").arg(&run).args(["--out", "one.html"]).assert().code(2);

    fs::write(
        run.join("fields/000001.vtu"),
        &fs::read(run.join("fields/000001.vtu")).unwrap()[..3000],
    )
    .unwrap();
    for (folder, texts) in [
        (&run, ["000001.vtu", "cut off"]),
        (&dir.path().to_path_buf(), ["no scene.toml", "immersa run"]),
    ] {
        let bad = program().arg("render").arg(folder).assert().code(3);
        let said = String::from_utf8_lossy(&bad.get_output().stderr).into_owned();
        assert!(texts.iter().all(|t| said.contains(t)), "{said}");
    }
}
