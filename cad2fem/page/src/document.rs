//! The page from its parts: markup, style, scripts and data in one file.

use anyhow::Result;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Map, Value, json};
use sha2::{Digest, Sha256};

use crate::facts;
use crate::prose::{escape, script_data};
use crate::store::Store;
use crate::survey::Survey;

const MARKUP: &str = include_str!("../web/page.html");
const STYLE: &str = include_str!("../web/page.css");
const MAIN: &str = include_str!("../web/main.js");
const LICENCE: &str = include_str!("../vendor/three/LICENSE");

/// The modules of the page by the names under which they import each other.
const MODULES: &[(&str, &str)] = &[
    ("three", include_str!("../vendor/three/three.module.min.js")),
    ("three/orbit", include_str!("../vendor/three/OrbitControls.js")),
    ("page/arrays", include_str!("../web/arrays.js")),
    ("page/chart", include_str!("../web/chart.js")),
    ("page/color", include_str!("../web/color.js")),
    ("page/controls", include_str!("../web/controls.js")),
    ("page/history", include_str!("../web/history.js")),
    ("page/load", include_str!("../web/load.js")),
    ("page/mold", include_str!("../web/mold.js")),
    ("page/response", include_str!("../web/response.js")),
    ("page/section", include_str!("../web/section.js")),
    ("page/shapes", include_str!("../web/shapes.js")),
    ("page/solid", include_str!("../web/solid.js")),
    ("page/stage", include_str!("../web/stage.js")),
    ("page/surface", include_str!("../web/surface.js")),
];

/// Puts a page together.
///
/// # Errors
/// If a file that it shows cannot be read.
pub fn assemble(title: &str, survey: &Survey, data: &Value, store: &Store) -> Result<String> {
    let imports = script_data(&imports());
    let blob = |(i, blob): (usize, &String)| {
        format!("<script type=\"application/octet-stream\" id=\"blob-{i}\">{blob}</script>\n")
    };
    let blobs: String = store.blobs.iter().enumerate().map(blob).collect();
    let facts = [
        facts::results(survey)?,
        facts::checks(survey)?,
        facts::casting(survey)?,
        facts::pictures(&survey.pictures)?,
        facts::provenance(survey)?,
    ];
    Ok(fill(&[
        ("policy", &policy(&[&imports, MAIN])),
        ("title", &escape(title)),
        ("style", STYLE),
        ("imports", &imports),
        ("headlines", &facts::headlines(survey)?),
        ("facts", &facts.concat()),
        ("licence", &escape(LICENCE)),
        ("data", &script_data(data)),
        ("blobs", &blobs),
        ("main", MAIN),
    ]))
}

/// Modules as `data:` URLs: a page opened from a file has no folder to import from.
fn imports() -> Value {
    let url = |source: &str| format!("data:text/javascript;base64,{}", STANDARD.encode(source));
    let all: Map<String, Value> =
        MODULES.iter().map(|(name, source)| ((*name).to_owned(), json!(url(source)))).collect();
    json!({ "imports": all })
}

/// What the browser may do for this page: run these inline scripts and modules in `data:`
/// URLs, and show pictures that are in the page. It asks no server for anything.
fn policy(scripts: &[&str]) -> String {
    let hash = |script: &&str| format!("'sha256-{}'", STANDARD.encode(Sha256::digest(script)));
    let hashes: Vec<String> = scripts.iter().map(hash).collect();
    format!(
        "default-src 'none'; script-src {} data:; style-src 'unsafe-inline'; img-src data:; \
         base-uri 'none'; form-action 'none'",
        hashes.join(" ")
    )
}

/// The markup with `{{name}}` replaced; what is put in is not searched again.
fn fill(parts: &[(&str, &str)]) -> String {
    let mut page = String::new();
    let mut rest = MARKUP;
    while let Some((before, after)) = rest.split_once("{{") {
        page += before;
        let (name, after) = after.split_once("}}").unwrap_or((after, ""));
        page += parts.iter().find(|(n, _)| *n == name).map_or("", |(_, value)| value);
        rest = after;
    }
    page + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_markup_asks_for_what_there_is() {
        let asked: Vec<&str> =
            MARKUP.split("{{").skip(1).filter_map(|rest| Some(rest.split_once("}}")?.0)).collect();
        let page = fill(&[("title", "{{data}}"), ("data", "DATA")]);
        assert!(page.contains("{{data}}"), "what is put in is not searched again");
        assert_eq!(page.matches("DATA").count(), 1);
        for name in ["policy", "style", "imports", "headlines", "facts", "licence", "blobs", "main"]
        {
            assert!(asked.contains(&name), "{name}");
        }
    }

    #[test]
    fn modules_import_only_what_the_page_has() {
        let names: Vec<&str> = MODULES.iter().map(|(name, _)| *name).collect();
        for (name, source) in MODULES.iter().chain(&[("main", MAIN)]) {
            let from = source.lines().filter(|l| l.starts_with("import") || l.starts_with('}'));
            for found in from.filter_map(|l| l.split_once(" from ")) {
                let module = found.1.trim_matches(['\'', '"', ';', ' ']);
                assert!(names.contains(&module), "{name} imports {module}");
            }
        }
        assert!(!MAIN.contains("</script"), "it would end there");
    }

    /// The hashes in `vendor/three/README.md`.
    #[test]
    fn three_is_the_one_that_the_note_says() {
        let note = include_str!("../vendor/three/README.md");
        for (name, source) in MODULES.iter().filter(|(name, _)| name.starts_with("three")) {
            assert!(note.contains(&program::sha256(source.as_bytes())), "{name}");
        }
        assert!(note.contains(&program::sha256(LICENCE.as_bytes())));
    }
}
