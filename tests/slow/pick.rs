//! A CAD finger of 179 faces is picked in a real browser, meshed and tagged, and its tags are those of a
//! file written by hand from what OpenCASCADE says of its faces.

use std::fs;
use std::process::Command;

use serde_json::{Value, json};
use tests::chromium::Chromium;
use tests::workdir::{Workdir, python, repository};

use super::run;

/// Clicks on what a person sees, counted.
struct Person {
    browser: Chromium,
    clicks: usize,
}

impl Person {
    fn press(&mut self, text: &str) {
        self.clicks += 1;
        self.browser.click_button(text);
    }

    /// Clicks a face by its name, which has to be seen.
    fn face(&mut self, name: &str) {
        self.clicks += 1;
        let faces = "JSON.parse(document.getElementById('data').textContent).body.faces";
        let index = format!("{faces}.findIndex((f) => f.name === '{name}')");
        let place = self.browser.evaluate(&format!("window.puffer.seen({index})"));
        let at = |i: usize| place[i].as_f64().unwrap_or_else(|| panic!("{name} is not seen"));
        self.browser.click([at(0), at(1)]);
    }
}

#[test]
#[ignore = "meshes a finger with fillets, some minutes: runs in make test-all"]
fn a_finger_of_179_faces_is_tagged_with_a_few_clicks() {
    let Some(program) = Chromium::installed() else { return };
    let Some(python) = python("gmsh, wildmeshing") else { return };
    let dir = Workdir::new();
    let script = repository().join("tests/slow/finger.py");
    run(Command::new(&python).arg(script).current_dir(dir.path("")));
    let cad2fem = |arguments: &str| run(&mut dir.command_of("cad2fem", arguments));
    // fewer triangles than by default, as the mesher takes minutes for all of them
    cad2fem("import finger.step --chord 1e-4 -o model");
    cad2fem("pick model -o pick.html");
    let mut browser = Chromium::start(program, [1440, 900]);
    fs::create_dir(dir.path("saved")).unwrap();
    browser.save_in(&dir.path("saved"));
    browser.show(&dir.path("pick.html"));
    let ends = dir.json("ends.json");
    let name = |value: &Value| value.as_str().unwrap().to_owned();
    let tip: Vec<String> = ends["tip"].as_array().unwrap().iter().map(name).collect();

    let mut person = Person { browser, clicks: 0 };
    person.press("cavity + fixed");
    person.press("+ tip");
    person.press("side");
    tip.iter().for_each(|face| person.face(face));
    person.press("+ skin");
    person.press("give them to skin");
    person.press("Download tags.toml");
    assert!(person.clicks < 10, "{}", person.clicks);
    let given = person.browser.state()["of"].clone();
    assert_eq!(given.as_array().unwrap().len(), 179);

    let wall = dir.json("wall.json");
    let files = |names: &[String]| {
        json!(names.iter().map(|name| format!("{name}.stl")).collect::<Vec<_>>()).to_string()
    };
    let wall: Vec<String> = wall.as_array().unwrap().iter().map(name).collect();
    let seat = vec![name(&ends["seat"][0])];
    let rest: Vec<String> = (1..=179).map(|i| format!("face-{i}")).collect();
    let rest: Vec<String> =
        rest.into_iter().filter(|f| ![&wall, &seat, &tip].iter().any(|l| l.contains(f))).collect();
    let table = |name: &str, faces: &[String], more: &str| {
        format!("[[tag]]\nname = \"{name}\"\npatch = {}\n{more}\n", files(faces))
    };
    let cavity = table("cavity", &wall, "pressure = true\nrim = \"fixed\"");
    let tables =
        [table("fixed", &seat, ""), cavity, table("tip", &tip, ""), table("skin", &rest, "")];
    dir.write("hand.toml", &tables.concat());
    cad2fem("tetmesh model/model.stl --mesher gmsh -o volume.msh");
    let tagged = |config: &str, to: &str| {
        fs::create_dir(dir.path(to)).unwrap();
        let arguments =
            format!("tag volume.msh --config {config} --patches model/patches -o {to}/tagged.msh");
        run(&mut dir.command_of("tagger", &arguments));
        mesh::io::read_tets(&dir.path(&format!("{to}/tagged.msh"))).unwrap().tags
    };
    let by_page = tagged("saved/tags.toml", "page");
    eprintln!("{} facets with tags", by_page.facets.len());
    assert_eq!(by_page, tagged("hand.toml", "hand"));
}
