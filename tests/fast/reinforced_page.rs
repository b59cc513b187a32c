//! Threads and directions of fibres on the page of a simulation, in a real browser.

use mesh::Vec3;
use mesh::io::vtu::{Grid, read_vtu};
use serde_json::{Value, json};
use tests::chromium::Chromium;
use tests::reported::number;
use tests::workdir::{Run, Workdir};

use crate::samples::{WINDING, wound};

/// One direction, so that the stretch of a linear element is one number.
const FIBRE: &str = "\n[[fibre]]\nname = \"weave\"\ndirection = [1, 0, 0]\nk1 = 1e5\n";

/// The page of a run of two load steps.
fn page(degree: usize) -> Workdir {
    let dir = wound(&format!("{WINDING}{FIBRE}"));
    let text = dir.text("p1.toml");
    let steps = "[solver]\nfirst_load_step = 0.5\nlargest_load_step = 0.5\n\n[material]";
    dir.write("steps.toml", &text.replacen("[material]", steps, 1));
    dir.solver(&format!("simulate steps.toml --degree {degree} -o out/run")).assert_good();
    dir.run("cad2fem", "report out -o page.html").assert_good();
    dir
}

/// Lengths of all threads at rest and now [mm].
fn lengths(dir: &Workdir) -> [f64; 2] {
    let mut found = [0.0; 2];
    for line in dir.text("out/run/windings.csv").lines().skip(1) {
        let cells: Vec<f64> = line.split(',').skip(1).map(|cell| cell.parse().unwrap()).collect();
        let at = |k: usize| Vec3::from_column_slice(&cells[k..k + 3]);
        found[0] += 1e3 * (at(6) - at(0)).norm();
        found[1] += 1e3 * (at(9) - at(3)).norm();
    }
    found
}

/// Smallest and largest stretch of the cells behind the boundary, and the number of its facets.
fn stretches(grid: &Grid) -> ([f64; 2], usize) {
    let nodes = grid.cell_type.nodes();
    let tets: Vec<[usize; 4]> =
        grid.cells.chunks_exact(nodes).map(|c| [c[0], c[1], c[2], c[3]]).collect();
    let body = mesh::TetMesh { vertices: grid.points.clone(), tets };
    let boundary = mesh::topology::boundary(&body).facets;
    let outer =
        |tet: &[usize; 4]| boundary.iter().any(|facet| facet.iter().all(|v| tet.contains(v)));
    let field = grid.cell_fields.iter().find(|f| f.name == "fibre_weave_stretch").unwrap();
    let values = body.tets.iter().zip(&field.values).filter(|(tet, _)| outer(tet));
    let range =
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], (_, &s)| [a.min(s), b.max(s)]);
    (range, boundary.len())
}

fn run(browser: &mut Chromium) -> Value {
    browser.evaluate("window.puffer.state().each[0]")
}

fn click(browser: &mut Chromium, id: &str) {
    browser.evaluate(&format!("document.getElementById('{id}').click()"));
}

fn step(browser: &mut Chromium, place: usize) {
    browser.evaluate(&format!(
        "(() => {{ const c = document.getElementById('step'); c.value = {place}; \
         c.dispatchEvent(new Event('input')); }})()"
    ));
    browser.wait(&format!("window.puffer.state().each[0].place === {place}"));
}

/// Lengths agree to the 16 bits of positions and displacements on the page: thresholds of 1e-4, set before.
#[test]
fn threads_and_fibres_move_with_the_body() {
    let Some(program) = Chromium::installed() else { return };
    for degree in [1, 2] {
        let dir = page(degree);
        let [rest, now] = lengths(&dir);
        let mut browser = Chromium::start(program, [900, 700]);
        browser.show(&dir.path("page.html"));
        let near = |found: &Value, expected: f64| (number(found) / expected - 1.0).abs() < 1e-4;
        let segments = dir.json("out/run/report.json")["windings"][0]["segments"].clone();
        let threads = run(&mut browser)["threads"].clone();
        assert_eq!(threads["segments"], segments);
        assert!(near(&threads["length"], now), "{threads} {now}");
        let legend = "document.getElementById('legend').textContent.includes('thread [N]')";
        assert_eq!(browser.evaluate(legend), json!(true));

        let with_threads = browser.picture();
        click(&mut browser, "fibres-0");
        browser.wait("window.puffer.state().each[0].strokes.weave");
        assert!(browser.picture().differing(&with_threads) > 1e-3);
        let grid = read_vtu(&dir.path("out/run/result.vtu")).unwrap();
        let ([least, most], facets) = stretches(&grid);
        let strokes = run(&mut browser)["strokes"]["weave"].clone();
        assert_eq!(strokes["count"], json!(facets), "one at each facet of this coarse body");
        if degree == 1 {
            let found = &strokes["stretch"];
            assert!(near(&found[0], least) && near(&found[1], most), "{strokes} {least} {most}");
        }
        click(&mut browser, "threads");
        browser.wait("window.puffer.state().each[0].threads === null");
        assert!(browser.picture().differing(&with_threads) > 1e-3);
        click(&mut browser, "threads");
        browser.wait("window.puffer.state().each[0].threads");

        step(&mut browser, 0);
        let at_rest = run(&mut browser);
        assert!(near(&at_rest["threads"]["length"], rest), "{at_rest} {rest}");
        assert!(near(&at_rest["strokes"]["weave"]["stretch"][1], 1.0), "{at_rest}");
        assert_eq!(browser.evaluate(legend), json!(false), "forces are those of the last state");
        assert_eq!(browser.complaints(), [""; 0]);
    }
}
