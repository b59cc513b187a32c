//! `puffer studio` in a browser: from a STEP that is dropped to the page and the mold, with the studio killed on the way.

use std::io::{BufRead as _, BufReader};
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::json;
use tests::chromium::Chromium;
use tests::skip::skip;
use tests::workdir::{self, Workdir, program, repository};

use crate::run;

/// A block with a chamber that opens at one end, as `book/bring.md` makes it.
const HAND: &str = "SetFactory(\"OpenCASCADE\");
Box(1) = {0, 0, 0, 60, 16, 14};
Box(2) = {-1, 4, 5, 55, 8, 6};
BooleanDifference(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
Save \"hand.step\";
";

/// A studio in the folder `bodies`, killed when it is dropped.
struct Studio(Child, String);

impl Studio {
    fn start(dir: &Workdir, python: &Path) -> Self {
        let mut command = Command::new(python);
        command.args(["-B", "-m", "softpuffer", "studio", "bodies", "--no-browser"]);
        command.current_dir(dir.path("")).env("PYTHONPATH", dir.path(""));
        let mut child = command.stdout(Stdio::piped()).spawn().unwrap();
        let mut address = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut address).unwrap();
        Self(child, address.trim().to_owned())
    }
}

impl Drop for Studio {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A folder with the package, `hand.step` as a script makes it, and the Python that has gmsh, if there is one.
fn folder(script: &str) -> Option<(Workdir, PathBuf)> {
    let python = repository().join(".venv/bin/python");
    let gmsh = Command::new(&python).args(["-c", "import gmsh"]).output();
    if !gmsh.is_ok_and(|done| done.status.success()) {
        skip("the Python package gmsh is not installed");
        return None;
    }
    let dir = Workdir::new();
    symlink(program("cad2fem").parent().unwrap(), dir.put_python().join("bin")).unwrap();
    std::fs::create_dir(dir.path("bodies")).unwrap();
    dir.write("hand.geo", script);
    // the script writes the file, whatever of it becomes a body
    let done = dir.run("cad2fem", "model hand.geo --unit mm --trust -o scratch");
    assert!(dir.path("hand.step").is_file(), "{done:?}");
    Some((dir, python))
}

/// Drops `hand.step` and begins.
fn begin(browser: &mut Chromium, studio: &Studio, dir: &Workdir) {
    let start = Instant::now();
    browser.visit(&studio.1);
    browser.wait("home.largest > 0");
    // a browser that is busy takes what is let go for a drag that it has not seen
    while browser.evaluate("document.getElementById('called').value") != json!("hand") {
        assert!(start.elapsed() < Duration::from_secs(30), "the file is not taken");
        browser.drop_file([400.0, 190.0], &dir.path("hand.step"));
    }
    browser.click_button("Begin");
}

#[test]
#[ignore = "makes a body of a STEP, minutes: runs in make test-all"]
fn a_step_that_is_dropped_becomes_a_page_and_a_mold() {
    let Some((dir, python)) = folder(HAND) else { return };
    let studio = Studio::start(&dir, &python);
    let Some(mut browser) = Chromium::start([1280, 900]) else { return };
    let start = Instant::now();
    begin(&mut browser, &studio, &dir);
    browser.wait("state?.page > 0 && location.hash === '#hand'");
    browser.evaluate("document.getElementById('pick').scrollIntoView({ block: 'end' })");
    browser.within("pick.html", tags_are_clicked);
    browser.wait("state.files['tags.toml'] !== '0' && state.missing.length === 0");
    choose(&mut browser, "select", "dragon-skin-10-medium");
    browser.wait("state.silicone.name === 'dragon-skin-10-medium' && state.cast.name === state.silicone.name");
    choose(&mut browser, "input", "12");
    browser.wait("state.chambers[0].pressure === 12000");
    // a browser may take as long to start as the run
    let Some(second) = Chromium::start([1280, 900]) else { return };
    // the page still scrolls to the settings
    browser.press("Make all of it");
    browser.wait("state.run.running && state.run.done > 0 && document.querySelector('progress')");
    assert_eq!(browser.complaints(), [""; 0]);

    // nothing but the folder knows what goes on
    drop((studio, browser));
    let (studio, mut browser) = (Studio::start(&dir, &python), second);
    browser.visit(&format!("{}#hand", studio.1));
    browser.wait("state?.run.running && document.getElementById('make').textContent === 'Stop'");
    browser.press("Stop");
    browser.wait("!state.run.running && document.body.textContent.includes('It was stopped.')");
    browser.press("Make all of it");
    browser.wait("state.run.running");
    drop(browser);
    let ended = || dir.text("bodies/hand/build/studio.log").contains("\n# exit code ");
    while !ended() {
        assert!(start.elapsed() < Duration::from_secs(900), "it is not made in 15 minutes");
        std::thread::sleep(Duration::from_millis(500));
    }
    let took = start.elapsed();

    let Some(mut browser) = Chromium::start([1280, 900]) else { return };
    browser.visit(&format!("{}#hand", studio.1));
    browser.wait("state?.run.code === 0 && state.parts.length > 2 && state.zip");
    let pictures =
        "[...document.querySelectorAll('#pictures img')].map((i) => i.naturalWidth > 500)";
    browser.wait(&format!("{pictures}.length === 2"));
    browser.wait(&format!("{pictures}.every(Boolean)"));
    browser.evaluate("document.getElementById('report').scrollIntoView()");
    browser.within("report.html", |page| {
        page.wait("window.puffer?.state().firstPicture");
        let head = page.evaluate("document.querySelector('header').textContent");
        assert!(head.as_str().unwrap().contains("0 fail"), "{head}");
    });
    assert_eq!(browser.complaints(), [""; 0]);
    eprintln!("from the dropped STEP to its page: {:.1} minutes", took.as_secs_f64() / 60.0);
    // the folder is one that make understands
    let again = run(workdir::make().args(["-C", "hand"]).current_dir(dir.path("bodies")));
    assert!(again.contains("nothing to do"), "{again}");
}

#[test]
#[ignore = "reads a STEP of two solids: runs in make test-all"]
fn a_solid_that_is_air_is_taken_out_of_a_step() {
    let two: Vec<&str> = HAND.lines().filter(|line| !line.starts_with("Boolean")).collect();
    let Some((dir, python)) = folder(&two.join("\n")) else { return };
    let studio = Studio::start(&dir, &python);
    let Some(mut browser) = Chromium::start([1280, 900]) else { return };
    begin(&mut browser, &studio, &dir);
    browser.wait("document.querySelectorAll('.runs input').length === 2");
    browser.evaluate("document.querySelectorAll('.runs input')[1].click()");
    browser.press("Take out what is marked: it is air");
    browser.wait("state.page > 0 && !state.run.running");
    // make goes on with what is left
    let volume = dir.json("bodies/hand/build/model/model.json")["volume"].as_f64().unwrap();
    assert!((volume - 10.848e-6).abs() < 1e-9, "{volume}");
    let plan = run(workdir::make()
        .args(["-nC", "hand", "build/volume.msh"])
        .current_dir(dir.path("bodies")));
    assert!(plan.contains("tetmesh") && !plan.contains("cad2fem import"), "{plan}");
}

/// What is held and the wall of the chamber as proposed, the far end by a click on it, the rest by name.
fn tags_are_clicked(page: &mut Chromium) {
    page.wait("window.puffer?.state().firstPicture");
    page.click_button("cavity + fixed");
    page.click_button("iso");
    page.click_button("+ tip");
    let faces = "JSON.parse(document.getElementById('data').textContent).body.faces";
    let end =
        page.evaluate(&format!("window.puffer.seen({faces}.findIndex((f) => f.middle[0] > 59))"));
    page.click([0, 1].map(|i| end[i].as_f64().unwrap_or_else(|| panic!("the end is not seen"))));
    page.wait("window.puffer.state().of.includes(2)");
    page.click_button("+ skin");
    page.click_button("give them to skin");
    assert_eq!(page.evaluate("window.puffer.state().of.includes(-1)"), json!(false));
    page.click_button("Save tags.toml");
}

/// Gives the first list or field of the settings another value, as a person does.
fn choose(browser: &mut Chromium, kind: &str, value: &str) {
    browser.wait(&format!("document.querySelector('#settings {kind}')"));
    browser.evaluate(&format!(
        "(() => {{ const field = document.querySelector('#settings {kind}'); field.value = '{value}'; \
         field.dispatchEvent(new Event('change')); }})()"
    ));
}
