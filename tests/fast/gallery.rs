//! `pipelines/gallery.py`: one page that shows what was made of many bodies.

use std::fs;
use std::process::{Command, Output};

use tests::workdir::{Workdir, repository};

fn gallery(dir: &Workdir, bodies: &[&str]) -> Output {
    let mut command = Command::new("python3");
    command.arg("-B").arg(repository().join("pipelines/gallery.py")).arg("gallery");
    command.args(bodies).current_dir(dir.path("")).output().unwrap()
}

#[test]
fn a_gallery_shows_what_was_made_and_names_the_rest() {
    let dir = Workdir::new();
    for folder in ["pipelines/one", "build/one/baseline", "build/one/pictures"] {
        fs::create_dir_all(dir.path(folder)).unwrap();
    }
    let put = |path: &str, text: &str| fs::write(dir.path(path), text).unwrap();
    put("pipelines/one/README.md", "# One\n\nAfter Gjoka et al. 2024, <b>1</b> body. More.\n");
    put("build/one/report.html", "the page");
    put("build/one/pictures/baseline.png", "a picture");
    put(
        "build/one/baseline/report.json",
        r#"{"usable": true, "chambers": {"a": {"pressure": 8000}}, "probes": {"bend": {"value": 70.77, "unit": "deg"}}}"#,
    );
    let made = gallery(&dir, &["one=pipelines/one=build/one", "two=pipelines/two=build/two"]);
    assert!(made.status.success(), "{made:?}");
    let page = dir.text("gallery/index.html");
    for part in [
        r#"<a href="one.html"><img src="one.png""#,
        "After Gjoka et al. 2024, &lt;b&gt;1&lt;/b&gt; body.",
        "<dd>8 kPa</dd>",
        "<dd>70.8°</dd>",
        "<b>two</b>: <code>make two</code>",
    ] {
        assert!(page.contains(part), "{part}: {page}");
    }
    assert_eq!(dir.text("gallery/one.html"), "the page");
    // the page of a body that is made again is another file
    put("build/one/report.html.new", "another page");
    fs::rename(dir.path("build/one/report.html.new"), dir.path("build/one/report.html")).unwrap();
    assert_eq!(dir.text("gallery/one.html"), "the page");
    assert_eq!(gallery(&dir, &["two=pipelines/two=build/two"]).status.code(), Some(1));
    assert_eq!(gallery(&dir, &["../two=pipelines/two=build/two"]).status.code(), Some(2));
}
