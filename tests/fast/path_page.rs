//! The path of a simulation, and what lies on it, on its page in a real browser.

use serde_json::json;
use tests::chamber;
use tests::chromium::Chromium;
use tests::reported::number;
use tests::workdir::Run;

/// Circles of a colour in the chart.
fn circles(color: &str, pixels: f64) -> String {
    format!("document.querySelectorAll('#path circle[fill=\"{color}\"][r=\"{pixels}\"]')")
}

#[test]
fn a_path_is_drawn_with_its_limit_and_its_burst() {
    let Some(program) = Chromium::installed() else { return };
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
    let mut browser = Chromium::start(program, [1000, 700]);
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
