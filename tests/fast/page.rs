//! `cad2fem report` on what the programs made of a small body, in a real browser.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};
use tests::chamber;
use tests::chromium::Chromium;
use tests::reported::number;
use tests::workdir::Workdir;

/// Names of folders may be like this.
const RUN: &str = "base<b>'\"&line";

/// A simulation of four load steps with a probe and its error bars.
fn simulated(dir: &Workdir, output: &str) {
    let steps = "[solver]\nfirst_load_step = 0.25\nlargest_load_step = 0.25\n\n[material]";
    let uncertain = "[uncertainty]\nmodulus = 0.1\npressure = 200\n";
    let scene = chamber::SIM.replace("[material]", steps);
    dir.write("steps.toml", &format!("{scene}\n{}\n{uncertain}", chamber::PROBES));
    dir.solver(&format!("simulate steps.toml -o {output}")).assert_good();
}

/// All that a page can show of the small body.
fn results() -> Workdir {
    let dir = chamber::workdir();
    let baseline = format!("out/{RUN}");
    simulated(&dir, &baseline);
    let design = chamber::DESIGN.replace("sim.toml", "p1.toml");
    dir.write("design.toml", &design.replace("iterations = 3", "iterations = 1"));
    dir.solver("optimize design.toml -o out/optimize").assert_good();
    dir.run("fab", "mold out/optimize/design.msh --no-pictures -o out/mold").assert_good();
    let checks = dir.run("fab", "verify --all out/mold").stdout;
    dir.write("out/mold.checks.txt", &checks);
    dir
}

fn write_page(dir: &Workdir, folder: &str, page: &str) {
    dir.run("cad2fem", &format!("report {folder} -o {page}")).assert_good();
}

/// Sets a control as a user does, and waits for what follows.
pub fn set(browser: &mut Chromium, id: &str, value: &Value) {
    browser.evaluate(&format!(
        "(() => {{ const c = document.getElementById('{id}'); c.value = {value}; \
         for (const e of ['input', 'change']) c.dispatchEvent(new Event(e)); }})()"
    ));
}

#[test]
fn a_page_shows_what_the_reports_say() {
    let dir = results();
    write_page(&dir, "out", "page.html");
    let Some(mut browser) = Chromium::start([1000, 700]) else { return };
    browser.show(&dir.path("page.html"));

    let report = dir.json(&format!("out/{RUN}/report.json"));
    let tags = report["tags"].as_object().unwrap();
    let largest = tags.values().map(|t| number(&t["max_displacement"])).fold(0.0, f64::max);
    let shown = browser.state();
    // 16 bits of the range of each component
    let near = |found: &Value, value: f64| (number(found) - value).abs() < 1e-4 * largest;
    let run = &shown["each"][0];
    assert_eq!((&run["run"], &run["states"], &run["place"]), (&json!(RUN), &json!(4), &json!(4)));
    assert!(near(&run["largestDisplacement"], largest), "{run} {largest}");
    let boundary = mesh::topology::boundary(&chamber::chamber().mesh).facets.len();
    assert_eq!(run["triangles"], json!(4 * boundary), "of quadratic facets");
    let loaded = browser.picture();
    assert!(loaded.colors() > 1000, "{} colours", loaded.colors());
    nothing_covers(
        &mut browser,
        &[("#legend", "canvas"), ("#legend", "#views"), ("#names span", "#views")],
    );
    let beyond = "document.getElementById('panel').scrollWidth > document.getElementById('panel').clientWidth";
    assert_eq!(browser.evaluate(beyond), json!(false), "the panel is wider than it shows");

    step_through(&mut browser, &dir, largest);
    cut(&mut browser);
    measured(&mut browser, &dir, largest);
    downloads(&mut browser, &dir);
    links(&mut browser, &dir);
    shapes_and_mold(&mut browser, &dir);
    assert_eq!(browser.complaints(), [""; 0]);
    assert_eq!(browser.requests(), [format!("file://{}", dir.path("page.html").display())]);
    without_webgl(&mut browser, &dir.path("page.html"));
    drop(browser);
    crate::hostile_page::every_text_is_text(&dir);
}

/// No element of the first selector lies over one of the second.
fn nothing_covers(browser: &mut Chromium, pairs: &[(&str, &str)]) {
    for (above, below) in pairs {
        let both = format!(
            "(() => {{ const of = (s) => [...document.querySelectorAll(s)].map((e) => e.getBoundingClientRect()); \
             return of('{above}').some((a) => of('{below}').some((b) => a.left < b.right - 1 && b.left < a.right - 1 \
             && a.top < b.bottom - 1 && b.top < a.bottom - 1)); }})()"
        );
        assert_eq!(browser.evaluate(&both), json!(false), "{above} lies over {below}");
    }
}

/// The slider goes through the load steps; in the middle of two it is linear.
fn step_through(browser: &mut Chromium, dir: &Workdir, largest: f64) {
    let loaded = browser.picture();
    let mut before = f64::INFINITY;
    for place in [3, 2, 1, 0] {
        set(browser, "step", &json!(place));
        browser.wait(&format!("window.puffer.state().each[0].place === {place}"));
        let found = number(&browser.state()["each"][0]["largestDisplacement"]);
        assert!(found < before, "{found} at {place}");
        if place > 0 {
            let file = format!("out/{RUN}/step_00{}.vtu", place - 1);
            let grid = mesh::io::vtu::read_vtu(&dir.path(&file)).unwrap();
            let all = grid.point_fields[0].values.chunks_exact(3);
            let exact =
                all.map(|u| u.iter().map(|x| x * x).sum::<f64>().sqrt()).fold(0.0, f64::max);
            assert!((found - exact).abs() < 1e-4 * largest, "{place}: {found} {exact}");
        }
        before = found;
    }
    assert_eq!(before, 0.0, "at rest");
    assert!(browser.picture().differing(&loaded) > 0.02);
    browser.press("step ▸");
    browser.wait("window.puffer.state().each[0].place === 1");
    set(browser, "step", &json!(4));
    browser.wait("window.puffer.state().each[0].place === 4");
    assert!(browser.picture().differing(&loaded) < 1e-3, "the same as at first");
}

/// The cut has a face, which follows the slider.
fn cut(browser: &mut Chromium) {
    let whole = browser.picture();
    set(browser, "cut", &json!("y"));
    browser.wait("window.puffer.state().each[0].sectionTriangles > 20");
    let middle = browser.picture();
    assert!(middle.differing(&whole) > 0.05);
    set(browser, "place", &json!(0.8));
    assert!(browser.picture().differing(&middle) > 0.02);
    set(browser, "cut", &json!("none"));
    browser.wait("window.puffer.state().each[0].sectionTriangles === 0");
}

/// Where on the screen the middle of an element is, moved by parts of its size.
fn place(browser: &mut Chromium, of: &str, [right, down]: [f64; 2]) -> [f64; 2] {
    let found = browser.evaluate(&format!(
        "(() => {{ const r = document.querySelector('{of}').getBoundingClientRect(); \
         return [r.x + (0.5 + {right}) * r.width, r.y + (0.5 + {down}) * r.height]; }})()"
    ));
    [number(&found[0]), number(&found[1])]
}

/// Value and coordinates under the pointer, a distance that goes with the body, and a cut that is dragged.
fn measured(browser: &mut Chromium, dir: &Workdir, largest: f64) {
    browser.press("front");
    let said = |browser: &mut Chromium, part: &str| {
        browser.wait(&format!("document.getElementById('said').textContent.includes('{part}')"));
        browser.evaluate("document.getElementById('said').textContent").as_str().unwrap().to_owned()
    };
    // two simulations are beside each other: that on the left
    let middle = place(browser, "canvas", [-0.25, 0.0]);
    browser.point("mouseMoved", middle, false, false);
    let text = said(browser, "displacement");
    let value: f64 = text.split(' ').nth(1).unwrap().parse().unwrap();
    assert!((0.0..=1.001e3 * largest).contains(&value) && text.ends_with(") mm"), "{text}");

    // from left to right across the body at rest, which has a known width
    browser.press("ruler");
    set(browser, "step", &json!(0));
    browser.wait("window.puffer.state().each[0].place === 0");
    for right in [-0.28, -0.22] {
        let at = place(browser, "canvas", [right, 0.0]);
        browser.click(at);
    }
    browser.wait("window.puffer.state().ruler > 0");
    let pixels = 0.06 * number(&browser.evaluate("document.querySelector('canvas').clientWidth"));
    let scale = browser.evaluate(
        "parseFloat(document.querySelector('#scale span').textContent) / \
         parseFloat(document.querySelector('#scale span').style.width)",
    );
    let rest = number(&browser.state()["ruler"]);
    let expected = pixels * number(&scale);
    assert!(
        (0.98..1.5).contains(&(rest / expected)),
        "{rest} mm, seen as {expected} from in front"
    );
    assert!(said(browser, "ruler").contains(" mm"));
    set(browser, "step", &json!(4));
    browser.wait("window.puffer.state().each[0].place === 4");
    let loaded = number(&browser.state()["ruler"]);
    assert!((loaded - rest).abs() > 1e-3 * rest, "it goes with the body: {rest} {loaded}");
    browser.evaluate("document.querySelector('canvas').focus()");
    browser.key("r", 0);
    browser.wait("window.puffer.state().ruler === null");

    // the run is of the body before the design, whose walls no mold was planned for
    let marks = browser.state()["marks"].clone();
    assert_eq!(marks.as_array().unwrap().len(), 2, "one of each simulation: {marks}");
    let report = dir.json(&format!("out/{RUN}/report.json"));
    let stretch = number(&report["stretch_range"]["largest"]);
    assert!(
        marks[0].as_str().unwrap().contains(&format!("largest stretch {stretch:.3}")),
        "{marks}"
    );

    set(browser, "cut", &json!("x"));
    browser.wait("!document.getElementById('grip').hidden");
    let grip = place(browser, "#grip", [0.0, 0.0]);
    let way: Vec<[f64; 2]> = (0..=4).map(|i| [grip[0] + 10.0 * f64::from(i), grip[1]]).collect();
    browser.drag(&way, false);
    let there = place(browser, "#grip", [0.0, 0.0]);
    assert!((there[0] - grip[0] - 40.0).abs() < 3.0, "{grip:?} {there:?}");
    let slider = browser.evaluate("document.getElementById('place').valueAsNumber");
    assert!(number(&slider) > 0.8, "{slider}, dragged from 0.8");
    set(browser, "place", &json!(0.8));
    set(browser, "cut", &json!("none"));
    browser.wait("document.getElementById('grip').hidden");
    browser.press("iso");
}

/// The curve as a table, and the picture with its legend.
fn downloads(browser: &mut Chromium, dir: &Workdir) {
    let caught = "window.saved = []; window.saving = URL.createObjectURL; \
                  URL.createObjectURL = (blob) => { saved.push(blob); return 'about:blank'; }; \
                  HTMLAnchorElement.prototype.click = function () { window.named = this.download; }";
    browser.evaluate(caught);
    browser.press("download CSV");
    browser.wait("window.saved.length === 1");
    let table = browser.evaluate("saved[0].text()");
    let rows: Vec<&str> = table.as_str().unwrap().lines().collect();
    assert_eq!(rows.len(), 6, "a head, rest and four steps: {rows:?}");
    assert!(rows[0].contains("pressure of cavity [kPa]"), "{}", rows[0]);
    assert!(!rows[0].contains('_'), "{}", rows[0]);
    let report = dir.json(&format!("out/{RUN}/report.json"));
    let pressure = number(&report["steps"][3]["chambers"]["cavity"]["pressure"]) * 1e-3;
    let cells = || rows[5].split(',').filter_map(|cell| cell.parse::<f64>().ok());
    assert!(
        cells().any(|cell| (cell - pressure).abs() < 1e-9 * pressure),
        "{} {pressure}",
        rows[5]
    );
    // the first curve is over the pressure, from rest on
    let chart =
        browser.evaluate("document.querySelector('#response .chart').getAttribute('aria-label')");
    assert!(chart.as_str().unwrap().ends_with(" over pressure of cavity [kPa]"), "{chart}");
    let points = browser.evaluate("document.querySelectorAll('#response .dot').length");
    assert_eq!(points, json!(5));
    browser.press("save picture");
    browser.wait("window.saved.length === 2");
    assert_eq!(browser.evaluate("saved[1].type"), json!("image/png"));
    assert!(number(&browser.evaluate("saved[1].size")) > 5e3);
    let named = browser.evaluate("named");
    assert!(named.as_str().unwrap().ends_with("picture.png"), "{named}");
    assert!(!named.as_str().unwrap().contains(['<', '/', '"']), "{named}");
}

/// All links lead to files of the folder.
fn links(browser: &mut Chromium, dir: &Workdir) {
    let all = browser.evaluate(
        "[...document.querySelectorAll('#files a')].map((a) => decodeURIComponent(new URL(a.href).pathname))",
    );
    let all: Vec<&str> = all.as_array().unwrap().iter().map(|p| p.as_str().unwrap()).collect();
    assert!(all.iter().all(|path| Path::new(path).is_file()), "{all:#?}");
    for file in [&format!("out/{RUN}/curve.csv"), "out/mold/base.stl", "out/mold/cast.html"] {
        let there = all.iter().any(|path| Path::new(path) == dir.path(file));
        let none = !dir.path(file).is_file();
        assert!(there || none, "{file} of {all:#?}");
    }
    assert!(all.iter().any(|path| path.ends_with(".3mf")), "{all:#?}");
}

fn shapes_and_mold(browser: &mut Chromium, dir: &Workdir) {
    browser.press("Shapes");
    browser.wait("window.puffer.state().files?.[0] === 'design.msh'");
    let design = browser.picture();
    assert!(design.colors() > 100);
    // the large points of the history are the shapes on disk
    let shapes = browser.evaluate("document.querySelectorAll('#history .shape').length");
    assert_eq!(shapes, json!(3), "the start, the second level and the design");
    browser.evaluate("document.querySelector('#history .shape').dispatchEvent(new Event('click'))");
    browser.wait("window.puffer.state().files?.[0] === 'level-1.msh'");

    browser.press("Mold");
    browser.wait("window.puffer.state().triangles > 0 && window.puffer.state().parts");
    let shown = browser.state();
    let parts = dir.json("out/mold/mold.json")["parts"].clone();
    let mut names: Vec<Value> =
        parts.as_array().unwrap().iter().map(|p| p["name"].clone()).collect();
    names.push(json!("cast"));
    assert_eq!(shown["parts"], json!(names));
    let wall = number(&dir.json("out/mold/plan.json")["wall"]["thickness"]);
    assert!((0.5..10.0).contains(&wall), "{wall} mm");
    let mark = shown["marks"][0].as_str().unwrap_or_else(|| panic!("no mark: {shown}"));
    let told = mark.strip_prefix("thinnest wall ").unwrap().split(' ').next().unwrap();
    assert!((told.parse::<f64>().unwrap() / wall - 1.0).abs() < 1e-3, "{mark}, {wall}");
    let text = format!("thinnest wall {told}");
    let tile = "[...document.querySelectorAll('.tiles div')].map((t) => t.textContent).join()";
    let tiles = browser.evaluate(tile);
    assert!(tiles.as_str().unwrap().contains(&text.replace("wall ", "wall")), "{tiles}, {text}");
    let printed: f64 = parts.as_array().unwrap().iter().map(|p| number(&p["triangles"])).sum();
    assert!(number(&shown["triangles"]) > printed, "and the cast");
    let apart = browser.picture();
    set(browser, "apart", &json!(0));
    let closed = browser.picture();
    assert!(closed.differing(&apart) > 0.02);
    set(browser, "cut", &json!("x"));
    assert!(browser.picture().differing(&closed) > 0.02);
}

/// Where nothing can be drawn, the page says so, and the rest of it is there.
fn without_webgl(browser: &mut Chromium, page: &Path) {
    let blind = "HTMLCanvasElement.prototype.getContext = () => null";
    browser.call("Page.addScriptToEvaluateOnNewDocument", &json!({ "source": blind }));
    browser.open(page);
    browser.wait("document.body?.classList.contains('unseen')");
    assert_eq!(browser.evaluate("document.getElementById('viewer').hidden"), json!(true));
    let said = browser.evaluate("document.getElementById('notice').textContent");
    assert!(said.as_str().unwrap().contains("no WebGL"), "{said}");
    assert_eq!(
        browser.evaluate("document.querySelectorAll('#history .dot').length > 0"),
        json!(true)
    );
}

/// Fingers turn, enlarge and measure: a point is where a finger came down, although it turns the body by some
/// pixels before it is lifted.
#[test]
fn a_finger_measures_on_a_phone() {
    let dir = chamber::workdir();
    simulated(&dir, "alone");
    write_page(&dir, "alone", "alone.html");
    let Some(mut browser) = Chromium::start([390, 844]) else { return };
    browser.become_phone();
    browser.show(&dir.path("alone.html"));
    browser.evaluate("document.getElementById('viewer').scrollIntoView()");
    let above =
        ["#legend", "#views"].map(|key| [(key, "canvas"), (key, "#names span"), (key, "#scale")]);
    nothing_covers(&mut browser, &above.concat());
    nothing_covers(&mut browser, &[("#legend", "#views")]);
    browser.press("front");
    browser.click_button("ruler");
    let said = "document.getElementById('said').textContent";
    browser.wait(&format!("{said} === 'ruler: tap the first point'"));
    let ends = [[-0.05, 0.0], [0.05, 0.0]].map(|at| place(&mut browser, "canvas", at));
    let measured = |browser: &mut Chromium, wobble: f64| {
        for [x, y] in ends {
            browser.press("front");
            browser.picture();
            browser.touch(&[&[[x, y]], &[[x + 0.5 * wobble, y]], &[[x + wobble, y]]]);
        }
        browser.wait("window.puffer.state().ruler > 0");
        number(&browser.state()["ruler"])
    };
    let steady = measured(&mut browser, 0.0);
    for wobble in [5.0, 9.0, 12.0] {
        let found = measured(&mut browser, wobble);
        assert!((found - steady).abs() < 1e-3 * steady, "{wobble} px: {found}, {steady} mm");
    }
    // a stroke turns, two fingers enlarge: neither sets a point
    let scale = "document.querySelector('#scale span').style.width";
    let (before, [x, y]) = (browser.evaluate(scale), ends[0]);
    browser.touch(&[&[[x, y]], &[[x + 30.0, y]], &[[x + 60.0, y]]]);
    browser.touch(&[&[[x - 20.0, y], [x + 20.0, y]], &[[x - 36.0, y], [x + 36.0, y]]]);
    browser.wait(&format!("{scale} !== '{}'", before.as_str().unwrap()));
    let kept = number(&browser.state()["ruler"]);
    assert!((kept - steady).abs() < 1e-3 * steady, "{kept}, {steady} mm");
    assert_eq!(browser.complaints(), [""; 0]);
}

/// A page for mail has the last of four states, and all numbers of the others.
#[test]
fn a_page_has_what_there_is() {
    let dir = chamber::workdir();
    simulated(&dir, "alone");
    write_page(&dir, "alone", "alone.html");
    let page = dir.text("alone.html");
    assert!(page.contains("<section id=\"results\"") && !page.contains("<section id=\"casting\""));
    dir.run("cad2fem", "report alone -o last.html --final-only").assert_good();
    let [all, last] = ["alone.html", "last.html"].map(|page| dir.text(page));
    let blobs = |page: &str| page.matches("id=\"blob-").count();
    assert!(last.len() < all.len() && blobs(&last) < blobs(&all), "{} {}", last.len(), all.len());
    for step in ["step_000.vtu", "step_002.vtu"] {
        assert!(all.contains(step) && !last.contains(step), "{step}");
    }
    assert!(last.contains("step_003.vtu") && last.contains("others are left out"));
    let data = |page: &str| -> Value {
        let (_, data) = page.split_once("id=\"data\">").unwrap();
        serde_json::from_str(data.split_once("</script>").unwrap().0).unwrap()
    };
    let [all, last] = [data(&all), data(&last)].map(|page| page["runs"][0].clone());
    assert_eq!((&last["steps"], &last["rest"]), (&all["steps"], &all["rest"]));
    assert_eq!(last["states"].as_array().unwrap().len(), 1);

    fs::create_dir(dir.path("empty")).unwrap();
    let refused = |folder: &str, words: &[&str]| {
        dir.run("cad2fem", &format!("report {folder} -o none.html")).assert_refused(2, words);
        assert!(!dir.path("none.html").exists());
    };
    refused("nowhere", &["nowhere"]);
    refused("empty", &["empty", "nothing to show", "solver simulate"]);
    fs::write(dir.path("alone/step_002.vtu"), "cut off").unwrap();
    refused("alone", &["alone/step_002.vtu"]);
    let other = dir.text("alone/report.json").replacen('{', "[", 1);
    dir.write("alone/report.json", &other);
    refused("alone", &["alone/report.json"]);
}
