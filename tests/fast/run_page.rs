//! Parts of the page of a simulation in a real browser: threads and directions of fibres, and the path with what lies on it.

use mesh::Vec3;
use mesh::io::vtu::{Grid, read_vtu};
use reports::{Segment, SegmentEnd};
use serde_json::{Value, json};
use tests::chamber;
use tests::chromium::Chromium;
use tests::reported::number;
use tests::workdir::Workdir;

use crate::page::set;
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
    let segments = Segment::all(&dir.text("out/run/windings.csv")).unwrap();
    let length = |of: fn(&SegmentEnd) -> [f64; 3]| -> f64 {
        let ends = segments.iter().map(|segment| segment.ends.each_ref().map(of).map(Vec3::from));
        ends.map(|[start, end]| 1e3 * (end - start).norm()).sum()
    };
    [length(|end| end.rest), length(|end| end.now)]
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
    set(browser, "step", &json!(place));
    browser.wait(&format!("window.puffer.state().each[0].place === {place}"));
}

/// Lengths agree to the 16 bits of positions and displacements on the page: thresholds of 1e-4, set before.
#[test]
fn threads_and_fibres_move_with_the_body() {
    for degree in [1, 2] {
        let dir = page(degree);
        let [rest, now] = lengths(&dir);
        let Some(mut browser) = Chromium::start([900, 700]) else { return };
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

/// Circles of a colour in the chart.
fn circles(color: &str, pixels: f64) -> String {
    format!("document.querySelectorAll('#path circle[fill=\"{color}\"][r=\"{pixels}\"]')")
}

#[test]
fn a_path_is_drawn_with_its_limit_and_its_burst() {
    let dir = chamber::near_its_edges();
    let follow = "[solver]\nfollow = \"arc-length\"\n";
    dir.write("path.toml", &format!("{}\n{follow}", dir.text("p1.toml")));
    dir.solver("simulate path.toml -o out/run").assert_good();
    dir.run("cad2fem", "report out -o page.html").assert_good();
    let report = dir.json("out/run/report.json");
    let states = report["steps"].as_array().unwrap().len();
    let rest = usize::from(report["rest"].is_object());
    let way = report["limit"]["path"].as_array().unwrap();
    assert_eq!(way[0]["factor"], json!(1.0));
    assert_eq!(way.last().unwrap()["factor"], report["limit"]["factor"]);
    let Some(mut browser) = Chromium::start([1000, 700]) else { return };
    browser.show(&dir.path("page.html"));
    assert_eq!(browser.evaluate("document.getElementById('path').hidden"), json!(false));
    let points = browser.evaluate(&format!("{}.length", circles("#5b8db8", 3.5)));
    assert_eq!(points, json!(rest + states + way.len() - 1));
    let lines = browser.evaluate("document.querySelectorAll('#path polyline').length");
    assert_eq!(lines, json!(1), "marks have no line");
    for (color, name, value) in [
        ("#cf5f53", "limit point", &report["limit"]["factor"]),
        ("#d6336c", "stretch at break", &report["limit"]["burst"]),
    ] {
        let said = browser.evaluate(&format!("{}[0].textContent", circles(color, 7.0)));
        let (said, value) = (said.as_str().unwrap(), format!("{:.3}", number(value)));
        assert!(said.contains(name) && said.contains(&value), "{said} {value}");
        let keys = browser.evaluate("document.querySelector('#path .picks').textContent");
        assert!(keys.as_str().unwrap().contains(name), "{keys}");
    }
    // the load grows up to the limit, which is the highest point of the chart
    let highest = "Math.min(...[...document.querySelectorAll('#path circle')].map((c) => Number(c.getAttribute('cy'))))";
    let limit = format!("Number({}[0].getAttribute('cy'))", circles("#cf5f53", 7.0));
    assert_eq!(browser.evaluate(highest), browser.evaluate(&limit));
    let text = browser.evaluate("document.getElementById('results').textContent");
    let text = text.as_str().unwrap();
    assert!(text.contains("Limits") && text.contains("no equilibrium beyond"), "{text}");
    assert!(text.contains("slope of the pressure"), "{text}");
    assert_eq!(browser.complaints(), Vec::<String>::new());
}
