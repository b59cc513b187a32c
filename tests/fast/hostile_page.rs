//! Each text of the reports in a folder of results is replaced by what would run if a page took it for markup.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::{Map, Value, json};
use tests::chromium::Chromium;
use tests::workdir::{Run, Workdir};

/// An SVG file that would run, ask a server and open its page.
const SVG: &str = "<svg xmlns=\"http://www.w3.org/2000/svg\" onload=\"parent.hit=1;window.hit=1\">\
                   <script>parent.hit=1</script><image href=\"http://localhost/x.png\" onerror=\"parent.hit=1\"/>\
                   <foreignObject><iframe xmlns=\"http://www.w3.org/1999/xhtml\" src=\"javascript:parent.hit=1\"/>\
                   </foreignObject></svg>";

/// Small, as it is drawn in software [px].
const SIZE: [u32; 2] = [500, 400];

/// Objects whose keys are names that people give, or parts of a program.
const NAMED: [&str; 11] = [
    "probes",
    "chambers",
    "tags",
    "error_bars",
    "mean_displacement",
    "reactions",
    "terms",
    "terms_before",
    "terms_after",
    "energies",
    "set",
];

/// Texts that are replaced, with the number by which each is known.
#[derive(Default)]
struct Hostile(BTreeMap<String, usize>);

impl Hostile {
    /// What stands for a text: it ends or begins whatever it may stand in, and then runs.
    fn text(&mut self, text: &str) -> String {
        let next = self.0.len() + 1;
        let n = *self.0.entry(text.to_owned()).or_insert(next);
        let run = format!("window.hit={n}");
        format!(
            "#{n};\"'>--></script></style></title><script>{run}</script><img src=x onerror={run}>\
             <svg onload=\"{run}\"></svg><script src=\"data:text/javascript,{run}\"></script>\
             <iframe srcdoc=\"<script>parent.{run}</script>\"></iframe><a href='javascript:{run}'>x</a>\
             <link rel=stylesheet href='data:text/css,*{{display:none}}'><style>body{{display:none}}</style>\
             `${{{run}}}` {{{{{run}}}}} ]]>&lt;b&gt; javascript:{run}"
        )
    }

    /// The value of a key with all its texts, and keys that are names, replaced.
    fn json(&mut self, key: &str, value: &Value) -> Value {
        // by folders and hashes a page finds files
        let is_hash = |text: &str| text.len() == 64 && text.chars().all(|c| c.is_ascii_hexdigit());
        match value {
            Value::String(text) if key == "folder" || is_hash(text) => json!(text),
            Value::String(text) => json!(self.text(text)),
            Value::Array(list) => list.iter().map(|item| self.json(key, item)).collect(),
            Value::Object(map) => {
                let named = NAMED.contains(&key);
                let mut changed = Map::new();
                for (name, below) in map {
                    let below = self.json(if named { "" } else { name }, below);
                    changed.insert(if named { self.text(name) } else { name.clone() }, below);
                }
                changed.into()
            }
            other => other.clone(),
        }
    }

    /// Replaces the texts of a file of JSON, a value in all or in each line.
    fn file(&mut self, path: &Path) {
        let text = fs::read_to_string(path).unwrap();
        let mut hostile =
            |text: &str| self.json("", &serde_json::from_str(text).unwrap()).to_string();
        let changed = match path.extension().is_some_and(|e| e == "jsonl") {
            true => text.lines().map(|line| hostile(line) + "\n").collect(),
            false => hostile(&text),
        };
        fs::write(path, changed).unwrap();
    }
}

/// All files below a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().flatten().map(|entry| entry.path());
    entries.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

/// Pages of the results in `dir/out`, which are in no other folder, with hostile texts in all reports.
pub fn every_text_is_text(dir: &Workdir) {
    let (mut hostile, folder) = (Hostile::default(), dir.path("hostile"));
    let status = Command::new("cp").arg("-r").arg(dir.path("out")).arg(&folder).status().unwrap();
    assert!(status.success());
    for path in files(&folder) {
        if path.extension().is_some_and(|e| e == "json" || e == "jsonl") {
            hostile.file(&path);
        }
    }
    assert!(hostile.0.len() > 80, "{} texts", hostile.0.len());
    fs::create_dir_all(folder.join("pictures")).unwrap();
    for name in ["pictures/<img src=x onerror=window.hit=1>.svg", "pictures/a.png"] {
        fs::write(folder.join(name), SVG).unwrap();
    }
    let page = dir.path("hostile.html");
    let mut report = dir.command_of("cad2fem", "report");
    report.arg(&folder).arg("-o").arg(&page).arg(format!("--title={}", hostile.text("title")));
    Run::from(report.output().unwrap()).assert_good();
    let mut most = 0;
    for page in [without_policy(&page), page] {
        let Some(mut browser) = Chromium::start(SIZE) else { return };
        browser.show(&page);
        most = most.max(look_around(&mut browser));
        assert_text_alone(&mut browser);
    }
    assert!(most > 40, "{most} texts of {} are shown", hostile.0.len());
}

/// The page without its policy, which might hide what is not escaped.
fn without_policy(page: &Path) -> PathBuf {
    let text = fs::read_to_string(page).unwrap();
    let policy = "http-equiv=\"Content-Security-Policy\"";
    assert_eq!(text.matches(policy).count(), 1);
    let bare = page.with_extension("bare.html");
    fs::write(&bare, text.replace(policy, "name=\"none\"")).unwrap();
    bare
}

/// Goes through all that a page can show; how many of the texts were seen at most.
fn look_around(browser: &mut Chromium) -> u64 {
    let mut most = 0;
    for view in ["Shapes", "Mold", "Under load"] {
        let tab = format!(
            "[...document.querySelectorAll('.tabs button')].find((b) => b.textContent.startsWith('{view}'))"
        );
        browser.evaluate(&format!("{tab}?.click()"));
        browser.wait("document.getElementById('loading').hidden");
        let all = "(async () => { for (const select of document.querySelectorAll('select')) \
                     for (const option of [...select.options].slice(0, 4)) { \
                       select.value = option.value; select.dispatchEvent(new Event('change')); } \
                   for (const dot of [...document.querySelectorAll('svg *')].slice(0, 400)) \
                     for (const kind of ['pointerenter', 'pointermove', 'mouseover', 'focus']) \
                       dot.dispatchEvent(new Event(kind)); })()";
        browser.evaluate(all);
        let shown = "new Set(document.body.textContent.match(/#\\d+;/g)).size";
        most = most.max(browser.evaluate(shown).as_u64().unwrap());
    }
    assert_ne!(browser.evaluate("window.puffer.state().view"), json!(null));
    most
}

/// Whether nothing of the texts became part of the open page: nothing has run, nothing was
/// asked for, there are no elements and attributes that ours has not.
fn assert_text_alone(browser: &mut Chromium) {
    assert_eq!(browser.evaluate("window.hit ?? null"), Value::Null, "a text has run");
    let foreign = "iframe, object, embed, base, a:not([href^=\"./\"]), b, [srcdoc], [src]:not([src^=\"data:image/\"]), main script, \
                   header script, main style, link:not([rel=icon])";
    let all = format!(
        "[...document.querySelectorAll({foreign:?})].map((e) => e.outerHTML.slice(0, 300))"
    );
    assert_eq!(browser.evaluate(&all), json!([]), "elements of a text");
    let handlers = "[...document.querySelectorAll('*')].flatMap((e) => e.getAttributeNames())\
                    .filter((name) => name.startsWith('on') || !/^[\\w:-]+$/.test(name))";
    assert_eq!(browser.evaluate(handlers), json!([]), "attributes of a text");
    assert_eq!(browser.complaints(), [""; 0]);
    let page = |url: &String| url.starts_with("file://") && url.ends_with(".html");
    assert!(browser.requests().iter().all(page), "{:?}", browser.requests());
}
