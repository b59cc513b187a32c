//! `cad2fem pick` in a real browser: faces are chosen with mouse, keys and finger, and the file that
//! the page saves makes `tagger` tag what a file written by hand does.

use std::fs;

use mesh::Vec3;
use mesh::topology::boundary;
use serde_json::{Value, json};
use tests::block;
use tests::chromium::Chromium;
use tests::workdir::{Run, Workdir};

/// Would run, if it were not text.
const HOSTILE: &str = "\"'><img src=x onerror=alert(1)>\n[[tag]]</script>";

/// What a person would write by hand for the bar.
const BY_HAND: &str = r#"
[[tag]]
name = "fixed"
plane = { point = [0.0399, 0, 0], normal = [1, 0, 0] }

[[tag]]
name = "cavity"
box = { min = [0.005, 0.001, 0.001], max = [0.0399, 0.019, 0.019] }
pressure = true
rim = "fixed"

[[tag]]
name = "far end"
plane = { point = [0.0001, 0, 0], normal = [-1, 0, 0] }

[[tag]]
name = "skin"
component = 0
"#;

/// A bar of 40 × 20 × 20 mm with a channel of 30 mm that opens at x = 40 mm: its tetrahedra in
/// `volume.msh`, its surface in millimetres in `bar.stl`.
fn bar() -> Workdir {
    let dir = Workdir::new();
    write_bar(&dir, [1.0, 1.0]);
    dir
}

/// The same, longer and wider by factors.
fn write_bar(dir: &Workdir, [longer, wider]: [f64; 2]) {
    let channel = |[x, y, z]: [usize; 3]| x > 1 && y == 1 && z == 1;
    // the channel is of one cell, 20/3 mm wide
    let stretched = |p: Vec3| Vec3::new(p.x * longer, p.y * wider * 20.0 / 15.0, p.z * 20.0 / 15.0);
    let mesh = block([8, 3, 3], 5e-3, channel, stretched);
    mesh::io::write_tets(&dir.path("volume.msh"), &mesh, &mesh::Tags::default()).unwrap();
    let mut surface = boundary(&mesh).surface(&mesh).0;
    surface.vertices.iter_mut().for_each(|p| *p *= 1e3);
    mesh::io::write_surface(&dir.path("bar.stl"), &surface).unwrap();
}

/// The bar and a browser that shows the page of its faces.
fn shown() -> Option<(Workdir, Chromium)> {
    let dir = bar();
    dir.run("cad2fem", "pick bar.stl -o pick.html").assert_good();
    let mut browser = Chromium::start([1200, 800])?;
    browser.show(&dir.path("pick.html"));
    Some((dir, browser))
}

/// The numbers of faces that stand on the body.
fn numbers(browser: &mut Chromium) -> Vec<String> {
    let labels = "[...document.querySelectorAll('#labels span')].map((l) => l.textContent).sort()";
    serde_json::from_value(browser.evaluate(labels)).unwrap()
}

/// A pixel that shows a face, which has to be seen.
fn seen(browser: &mut Chromium, face: usize) -> [f64; 2] {
    let place = browser.evaluate(&format!("window.puffer.seen({face})"));
    [0, 1].map(|i| place[i].as_f64().unwrap_or_else(|| panic!("face {face} is not seen")))
}

/// The number of the face whose middle is at a place [mm].
fn face_at(browser: &mut Chromium, middle: [f64; 3]) -> usize {
    let faces =
        browser.evaluate("JSON.parse(document.getElementById('data').textContent).body.faces");
    let close = |face: &Value| {
        (0..3).all(|i| (face["middle"][i].as_f64().unwrap() - middle[i]).abs() < 0.1)
    };
    faces.as_array().unwrap().iter().position(close).unwrap_or_else(|| panic!("{faces:#}"))
}

/// What the page knows of a face by a key.
fn said_of(browser: &mut Chromium, face: usize, key: &str) -> String {
    let faces = "JSON.parse(document.getElementById('data').textContent).body.faces";
    browser.evaluate(&format!("{faces}[{face}].{key}")).as_str().unwrap().to_owned()
}

#[test]
fn faces_that_are_clicked_are_those_that_are_tagged() {
    let Some((dir, mut browser)) = shown() else { return };
    fs::create_dir(dir.path("saved")).unwrap();
    browser.save_in(&dir.path("saved"));
    let whole = browser.picture();
    assert_eq!(browser.state()["faces"], json!(11), "six outside, five of the channel");

    // the open end, and the channel behind it with all its walls
    browser.click_button("side");
    browser.click_button("+ fixed");
    let seat = face_at(&mut browser, [40.0, 10.0, 10.0]);
    let place = seen(&mut browser, seat);
    browser.click(place);
    browser.click_button("+ cavity");
    browser.click_button("all connected");
    let bottom = face_at(&mut browser, [10.0, 10.0, 10.0]);
    let place = seen(&mut browser, bottom);
    browser.click(place);
    let now = browser.state();
    let of = |now: &Value, tag: i64| {
        now["of"].as_array().unwrap().iter().filter(|t| **t == json!(tag)).count()
    };
    assert_eq!((of(&now, 0), of(&now, 1)), (1, 5), "{now}");

    // by keys alone: a new tag, its name, the face at the other end
    browser.point("mouseMoved", [30.0, 700.0], false, false);
    browser.wait("window.puffer.state().hovered === null");
    browser.evaluate("document.querySelector('canvas').focus()");
    browser.key("f", 0);
    browser.key("n", 0);
    browser.call("Input.insertText", &json!({ "text": "far end" }));
    browser.key("Enter", 0);
    let end = face_at(&mut browser, [0.0, 10.0, 10.0]);
    for _ in 0..=end {
        browser.key("Tab", 0);
    }
    assert_eq!(browser.state()["hovered"], json!(end));
    browser.key("Enter", 0);
    assert_eq!(of(&browser.state(), 2), 1);

    // two sides are painted with one stroke, which is undone as a whole, and all that is left is given
    browser.click_button("iso");
    browser.click_button("+ skin");
    let sides = [[20.0, 0.0, 10.0], [20.0, 10.0, 20.0]].map(|p| face_at(&mut browser, p));
    let places = sides.map(|face| seen(&mut browser, face));
    browser.drag(&places, true);
    assert_eq!(of(&browser.state(), 3), 2, "{}", browser.state());
    browser.key("z", 2);
    assert_eq!(of(&browser.state(), 3), 0);
    browser.key("y", 2);
    browser.click_button("give them to skin");
    assert_eq!(of(&browser.state(), -1), 0);
    assert!(browser.picture().differing(&whole) > 0.05, "tags have colours");

    // it is kept, where the page is opened again
    let before = browser.state()["of"].clone();
    browser.show(&dir.path("pick.html"));
    assert_eq!(browser.state()["of"], before);
    browser.click_button("Download tags.toml");
    let file = dir.path("saved/tags.toml");
    for _ in 0..500 {
        if file.is_file() {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    let text = fs::read_to_string(&file).unwrap();
    assert_eq!(json!(text), browser.evaluate("window.puffer.toml()"));
    assert!(text.contains("# 5 faces") && text.contains("rim = \"fixed\""), "{text}");
    assert_eq!(browser.complaints(), [""; 0]);
    assert_eq!(browser.requests().iter().filter(|url| !url.starts_with("blob:")).count(), 2);

    dir.write("hand.toml", BY_HAND);
    assert_eq!(tagged(&dir, "saved/tags.toml"), tagged(&dir, "hand.toml"));
    assert!(dir.text("hand.toml.d/tags.txt").contains("fixed"));
    in_a_changed_body(&dir, &text);
}

/// The bar as the tags of a file make it, in a folder beside that.
fn tagged(dir: &Workdir, config: &str) -> Vec<u8> {
    let output = format!("{config}.d/tagged.msh");
    fs::create_dir(dir.path(&format!("{config}.d"))).unwrap();
    let of = "tag volume.msh --patches model/patches";
    dir.run("tagger", &format!("{of} --config {config} -o {output}")).assert_good();
    fs::read(dir.path(&output)).unwrap()
}

/// The same file of the page in a bar that is longer and wider, whose faces have other numbers.
fn in_a_changed_body(dir: &Workdir, text: &str) {
    assert!(text.contains("\nsplit = 40\n") && text.contains("\n[faces]\n"), "{text}");
    write_bar(dir, [1.1, 1.2]);
    dir.run("cad2fem", "import bar.stl --split 40 -o model").assert_good();
    let tag = |config: &str| {
        let of = "tag volume.msh --patches model/patches -o tagged.msh --config";
        dir.run("tagger", &format!("{of} {config}"))
    };
    let tagged = tag("saved/tags.toml");
    tagged.assert_good();
    let said = &tagged.stderr;
    assert!(said.contains("faces with other names than when they were picked"), "{said}");
    assert!(
        said.contains("between the same neighbours: 11, moved by up to")
            && !said.contains("may mean"),
        "{said}"
    );
    let tags = dir.json("tags.json");
    let area = |name: &str| {
        let i = tags["names"].as_array().unwrap().iter().position(|n| *n == json!(name)).unwrap();
        1e6 * tags["areas"][i].as_f64().unwrap()
    };
    let (mouth, walls) = (20.0 / 3.0 * 8.0, 2.0 * 33.0 * (20.0 / 3.0 + 8.0));
    let expected = [("fixed", 480.0 - mouth), ("far end", 480.0), ("cavity", walls + mouth)];
    for (name, expected) in expected {
        assert!((area(name) / expected - 1.0).abs() < 1e-5, "{name}: {} mm²", area(name));
    }
    // one face of a tag less, and a face of the wall of the channel twice as far away as any that could be it
    let wall = text.lines().find(|line| line.contains("middle = [0.01, 0.01, 0.01]")).unwrap();
    let gone = wall.replace("middle = [0.01, 0.01", "middle = [0.01, 0.9");
    dir.write("gone.toml", &text.replace(wall, &gone));
    tag("gone.toml").assert_refused(
        2,
        &["`cavity`", "no face is like outer-11.stl any more", "the nearest is"],
    );
    // the page shows what is left, and says what is not
    dir.run("cad2fem", "pick model --tags gone.toml -o pick.html")
        .assert_says(&["cavity: no face is like outer-11.stl"]);
}

/// Tags of the bar: two of faces, and between them one by a plane; a part, and a selection distance.
const GIVEN: &str = r#"
epsilon = 2e-4

[[tag]]
name = "seat"
plane = { point = [0.0399, 0, 0], normal = [1, 0, 0] }

[[tag]]
name = "far end"
patch = "FAR"

[[tag]]
name = "cavity"
patch = [WALLS]
pressure = true
rim = "seat"

[[volume]]
name = "stiff"
box = { min = [-1, -1, -1], max = [0.005, 1, 1] }
"#;

#[test]
fn tags_of_a_file_are_shown_and_come_back_as_they_were() {
    let Some((dir, mut browser)) = shown() else { return };
    let far = face_at(&mut browser, [0.0, 10.0, 10.0]);
    let file = |browser: &mut Chromium, face: usize| said_of(browser, face, "file");
    let channel = [[10.0, 10.0, 10.0], [25.0, 6.667, 10.0], [25.0, 13.333, 10.0]];
    let channel = [&channel[..], &[[25.0, 10.0, 6.667], [25.0, 10.0, 13.333]]].concat();
    let walls: Vec<String> = channel
        .iter()
        .map(|middle| {
            let face = face_at(&mut browser, *middle);
            format!("{:?}", file(&mut browser, face))
        })
        .collect();
    let text = GIVEN.replace("FAR", &file(&mut browser, far)).replace("WALLS", &walls.join(", "));
    dir.write("given.toml", &text);
    let from = |tags: &str| {
        let run = dir.run("cad2fem", &format!("pick model --tags {tags} -o pick.html"));
        run.assert_good();
        run.stderr
    };
    let said = from("given.toml");
    assert!(said.contains("tags on the page: far end, cavity"), "{said}");
    assert!(said.contains("seat cannot be shown, but is kept"), "{said}");
    assert!(said.contains("[[volume]] stiff is kept as it is"), "{said}");
    browser.show(&dir.path("pick.html"));
    let now = browser.state();
    let of = now["of"].as_array().unwrap();
    assert_eq!((&of[far], of.iter().filter(|t| **t == json!(2)).count()), (&json!(1), 5), "{now}");

    // the plane, the part and the distance are in the file, which tags as the first one does
    let again = browser.evaluate("window.puffer.toml()").as_str().unwrap().to_owned();
    dir.write("again.toml", &again);
    assert_eq!(tagged(&dir, "given.toml"), tagged(&dir, "again.toml"));

    // what the page wrote comes back word for word, and a click makes a tag of its own
    from("again.toml");
    browser.show(&dir.path("pick.html"));
    assert_eq!(browser.evaluate("window.puffer.toml()"), json!(again));
    browser.evaluate("document.querySelector('canvas').focus()");
    browser.key("1", 0);
    let top = face_at(&mut browser, [20.0, 10.0, 20.0]);
    let place = seen(&mut browser, top);
    browser.click(place);
    let now = browser.state();
    assert_eq!((&now["of"][top], &now["list"][3]["name"]), (&json!(3), &json!("tag")), "{now}");
    let text = browser.evaluate("window.puffer.toml()").as_str().unwrap().to_owned();
    assert!(text.contains("rim = \"seat\"") && text.contains("[[volume]]"), "{text}");
    assert_eq!(browser.complaints(), [""; 0]);
}

#[test]
fn faces_that_are_seen_have_numbers() {
    let Some((_dir, mut browser)) = shown() else { return };
    let name = |browser: &mut Chromium, middle: [f64; 3]| {
        let face = face_at(browser, middle);
        said_of(browser, face, "name").trim_start_matches("face-").to_owned()
    };
    assert_eq!(numbers(&mut browser), [""; 0]);
    browser.evaluate("document.querySelector('canvas').focus()");
    browser.key("l", 0);
    browser.wait("document.querySelectorAll('#labels span').length > 0");
    // from the corner x+, y−, z+: three sides; the walls of the channel are hidden
    let mut expected =
        [[20.0, 0.0, 10.0], [20.0, 10.0, 20.0], [40.0, 10.0, 10.0]].map(|p| name(&mut browser, p));
    expected.sort();
    assert_eq!(numbers(&mut browser), expected);
    browser.click_button("under");
    browser.wait("document.querySelectorAll('#labels span').length === 1");
    assert_eq!(numbers(&mut browser), [name(&mut browser, [20.0, 10.0, 0.0])]);
    browser.key("l", 0);
    browser.wait("document.querySelectorAll('#labels span').length === 0");
    assert_eq!(browser.complaints(), [""; 0]);
}

#[test]
fn a_finger_chooses_on_a_phone_and_titles_are_text() {
    let dir = bar();
    dir.run("cad2fem", "import bar.stl --split 40 -o model").assert_good();
    let mut pick = dir.command_of("cad2fem", "pick model -o pick.html --title");
    Run::from(pick.arg(HOSTILE).output().unwrap()).assert_good();
    let Some(mut browser) = Chromium::start([390, 844]) else { return };
    browser.become_phone();
    browser.show(&dir.path("pick.html"));
    let wide = "document.documentElement.scrollWidth > innerWidth";
    assert_eq!(browser.evaluate(wide), json!(false), "the page is wider than the phone");
    let top = face_at(&mut browser, [20.0, 10.0, 20.0]);
    let place = seen(&mut browser, top);
    // a finger is seldom still
    browser.touch(&[&[place], &[[place[0] + 9.0, place[1]]]]);
    browser.wait(&format!("window.puffer.state().of[{top}] === 0"));
    let title = browser.evaluate("document.querySelector('h1').textContent");
    assert_eq!(title, json!(HOSTILE));
    let text = browser.evaluate("window.puffer.toml()");
    let text = text.as_str().unwrap();
    let tables = text.lines().filter(|line| line.starts_with("[[tag]]")).count();
    assert_eq!(tables, 1, "{text}");
    dir.write("tags.toml", text);
    let tag = "tag volume.msh --config tags.toml --patches model/patches -o tagged.msh";
    dir.run("tagger", tag).assert_good();
    assert_eq!(browser.complaints(), [""; 0]);
}

#[test]
fn what_is_no_body_and_what_is_no_page_is_refused() {
    let dir = bar();
    let refused = |arguments: &str, words: &[&str]| {
        dir.run("cad2fem", &format!("pick {arguments}")).assert_refused(2, words);
    };
    refused("bar.stl -o tags.toml", &["tags.toml", "-o pick.html"]);
    fs::create_dir(dir.path("empty")).unwrap();
    refused("empty -o pick.html", &["empty", "model.json", "cad2fem import"]);
    refused("empty --split 30 -o pick.html", &["--split is for a file"]);
    dir.run("cad2fem", "import bar.stl --split 40 -o model").assert_good();
    dir.write("other.toml", "[[tag]]\nname = \"seat\"\npatch = \"face-99.stl\"\n");
    let words = ["other.toml", "`seat`", "called face-99.stl", "it has 11 faces"];
    refused("model --tags other.toml -o pick.html", &words);
    refused("none.stl -o pick.html", &["none.stl"]);
    assert!(!dir.path("pick.html").exists());
}
