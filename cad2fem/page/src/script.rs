//! The modules of the page as one script, as a page opened from a file has no folder to import from.
//!
//! Each module becomes a function that returns what it exports, under a name of its own. Of the
//! language of modules only what ours use is known: `import` of names or of all, at the
//! beginning of a line; `export` before `function`, `class` or `const`, or of a list at the end.

/// The main module of the page of results.
pub const RESULTS: &str = include_str!("../web/main.js");
/// The main module of the page to pick faces on.
pub const PICK: &str = include_str!("../web/pick/main.js");

/// The modules of the page by the names under which they import each other; each imports only
/// those before it.
const MODULES: &[(&str, &str)] = &[
    ("three", include_str!("../vendor/three/three.module.min.js")),
    ("three/orbit", include_str!("../vendor/three/OrbitControls.js")),
    ("page/arrays", include_str!("../web/arrays.js")),
    ("page/color", include_str!("../web/color.js")),
    ("page/words", include_str!("../web/words.js")),
    ("page/chart", include_str!("../web/chart.js")),
    ("page/controls", include_str!("../web/controls.js")),
    ("page/save", include_str!("../web/save.js")),
    ("page/pointer", include_str!("../web/pointer.js")),
    ("page/grip", include_str!("../web/grip.js")),
    ("page/history", include_str!("../web/history.js")),
    ("page/section", include_str!("../web/section.js")),
    ("page/cap", include_str!("../web/cap.js")),
    ("page/surface", include_str!("../web/surface.js")),
    ("page/solid", include_str!("../web/solid.js")),
    ("page/bars", include_str!("../web/bars.js")),
    ("page/threads", include_str!("../web/threads.js")),
    ("page/strokes", include_str!("../web/strokes.js")),
    ("page/reinforcement", include_str!("../web/reinforcement.js")),
    ("page/load", include_str!("../web/load.js")),
    ("page/mold", include_str!("../web/mold.js")),
    ("page/path", include_str!("../web/path.js")),
    ("page/response", include_str!("../web/response.js")),
    ("page/shapes", include_str!("../web/shapes.js")),
    ("page/stage", include_str!("../web/stage.js")),
    ("pick/tags", include_str!("../web/pick/tags.js")),
    ("pick/toml", include_str!("../web/pick/toml.js")),
    ("pick/body", include_str!("../web/pick/body.js")),
    ("pick/labels", include_str!("../web/pick/labels.js")),
    ("pick/hand", include_str!("../web/pick/hand.js")),
    ("pick/panel", include_str!("../web/pick/panel.js")),
];

/// The modules that a main one needs, and itself after them.
pub fn linked(main: &str) -> String {
    let mut needed = vec![false; MODULES.len()];
    mark(main, &mut needed);
    let module = |(name, source): &(&str, &str)| {
        let (body, exports) = parts(source);
        format!("const {} = (() => {{\n{body}\nreturn {{ {exports} }};\n}})();\n", variable(name))
    };
    let used = MODULES.iter().zip(&needed).filter(|(_, needed)| **needed).map(|(m, _)| m);
    used.map(module).collect::<String>() + &parts(main).0
}

/// Marks what a module imports, and what that imports.
fn mark(source: &str, needed: &mut [bool]) {
    for (i, (name, text)) in MODULES.iter().enumerate() {
        if !needed[i] && (source.contains(&format!("from '{name}'"))) {
            needed[i] = true;
            mark(text, needed);
        }
    }
}

/// The variable that holds a module.
fn variable(module: &str) -> String {
    format!("module_{}", module.replace('/', "_"))
}

/// A module without its imports and exports, and what it exports.
fn parts(source: &str) -> (String, String) {
    let (source, mut exports) = match source.rfind("export{").or(source.rfind("export {")) {
        Some(at) => (&source[..at], renamed(&source[at..])),
        None => (source, String::new()),
    };
    let mut body = String::new();
    let mut rest = source;
    while let Some(line) = rest.split_inclusive('\n').next() {
        let import = line.starts_with("import ").then(|| rest.split_once(';')).flatten();
        if let Some((import, after)) = import {
            body += &imported(import);
            rest = after;
            continue;
        }
        let declared = line.strip_prefix("export ");
        if let Some(name) = declared.and_then(|code| code.split([' ', '(']).nth(1)) {
            exports += &format!("{name}, ");
        }
        body += declared.unwrap_or(line);
        rest = &rest[line.len()..];
    }
    (body, exports)
}

/// `import { a, b as c } from 'm'` and `import * as a from 'm'` as constants.
fn imported(import: &str) -> String {
    let (names, module) = import.split_once(" from ").unwrap_or((import, ""));
    let module = variable(module.trim_matches(['\'', '"']));
    match names.split_once("* as ") {
        Some((_, all)) => format!("const {all} = {module};"),
        None => format!("const {{ {} }} = {module};", renamed(names)),
    }
}

/// What stands in the braces of an import or export, as in those of an object; an export
/// `a as b` is the entry `b: a`.
fn renamed(list: &str) -> String {
    let inside = list.split(['{', '}']).nth(1).unwrap_or_default();
    let entry = |name: &str| match name.trim().split_once(" as ") {
        Some((own, other)) if list.starts_with("export") => format!("{other}: {own}, "),
        Some((other, own)) => format!("{other}: {own}, "),
        None if name.trim().is_empty() => String::new(),
        None => format!("{}, ", name.trim()),
    };
    inside.split(',').map(entry).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modules_become_functions_of_what_they_import() {
        let source = "import * as T from 'three';\nimport {\n  a,\n  b as c,\n} from 'page/x';\n\
                      export const D = 1;\nexport function e(f) { return \"export \"; }\nlet g;\n\
                      export { g as h, c };\n";
        let (body, exports) = parts(source);
        assert_eq!(exports, "h: g, c, D, e, ");
        let lines: Vec<&str> = body.lines().filter(|l| !l.is_empty()).collect();
        assert_eq!(lines[0], "const T = module_three;");
        assert_eq!(lines[1], "const { a, b: c,  } = module_page_x;");
        assert_eq!(lines[2..4], ["const D = 1;", "function e(f) { return \"export \"; }"]);
    }

    #[test]
    fn modules_import_only_those_before_them() {
        let mut before = Vec::new();
        for (name, source) in MODULES.iter().chain(&[("main", RESULTS), ("pick/main", PICK)]) {
            let from = source.lines().filter(|l| l.starts_with("import") || l.starts_with('}'));
            for found in from.filter_map(|l| l.split_once(" from ")) {
                let module = found.1.trim_matches(['\'', '"', ';', ' ']);
                assert!(before.contains(&module), "{name} imports {module}");
            }
            before.push(*name);
        }
        for main in [RESULTS, PICK] {
            let script = linked(main);
            assert!(!script.to_lowercase().contains("</script"), "it would end there");
            assert!(!script.contains("<!--"), "it would be a comment");
            let left = |l: &&str| l.starts_with("import ") || l.starts_with("export ");
            assert_eq!(script.lines().find(left), None);
            assert!(script.contains("WebGLRenderer: ec,"), "what three.js exports");
        }
        assert!(
            !linked(PICK).contains("module_page_history") && !linked(RESULTS).contains("pick_")
        );
    }

    /// The hashes in `vendor/three/README.md`.
    #[test]
    fn three_is_the_one_that_the_note_says() {
        let note = include_str!("../vendor/three/README.md");
        for (name, source) in MODULES.iter().filter(|(name, _)| name.starts_with("three")) {
            assert!(note.contains(&program::sha256(source.as_bytes())), "{name}");
        }
        assert!(note.contains(&program::sha256(crate::document::LICENCE.as_bytes())));
    }
}
