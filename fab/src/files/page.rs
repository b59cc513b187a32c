//! `cast.html`: the sheet for the one who casts, of all molds of a body: pictures, what to weigh, to print and to have,
//! and the steps in their order. It is one file, and is printed on A4.

use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use mesh::io::{IoError, read_bytes, write_atomic};

use crate::files::output::{ASSEMBLED, EXPLODED};
use crate::files::report::MoldReport;
use crate::files::sheet::{Item, Sheet};
use crate::plan::report::{Entry, PlanReport};

/// The sheet, beside plan.json.
pub const FILE: &str = "cast.html";

const STYLE: &str = include_str!("page.css");

/// What the browser may do: show the pictures that are in the page.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'";

/// A mold of the plan.
struct Cast<'a> {
    entry: &'a Entry,
    sheet: Sheet,
    /// Pictures, in base 64.
    pictures: Vec<String>,
}

/// Writes the sheet of all molds of a plan, which are in `folder`, with the pictures that are there.
pub fn write<'a>(
    folder: &Path,
    plan: &PlanReport,
    molds: impl Iterator<Item = (&'a Entry, &'a MoldReport)>,
    title: &str,
) -> Result<(), IoError> {
    let mut casts = Vec::new();
    for (entry, report) in molds {
        let below = folder.join(&entry.folder);
        let drawn = [EXPLODED, ASSEMBLED].map(|name| below.join(name));
        let drawn = drawn.iter().filter(|path| path.exists());
        let pictures = drawn.map(|path| Ok(STANDARD.encode(read_bytes(path)?)));
        let pictures = pictures.collect::<Result<_, IoError>>()?;
        casts.push(Cast { entry, sheet: Sheet::new(report), pictures });
    }
    let page = page(plan, &casts, title).into_string();
    write_atomic(&folder.join(FILE), |out| out.write_all(page.as_bytes()))
}

fn page(plan: &PlanReport, casts: &[Cast], title: &str) -> Markup {
    let warnings = once(casts.iter().flat_map(|cast| &cast.sheet.warnings));
    let sources = once(casts.iter().flat_map(|cast| &cast.sheet.sources));
    let together = plan.steps.iter();
    let together: Vec<&String> = match casts.iter().find(|cast| !cast.sheet.finish.is_empty()) {
        Some(cast) => together.chain(&cast.sheet.finish).collect(),
        None => together.collect(),
    };
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                title { (title) ": casting" }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { (title) }
                p { "Method: " (plan.method) "; " (plan.reason) "." }
                @for warning in warnings { p.warning { (marked(warning)) } }
                @if let Some(weight) = &plan.weight {
                    p { "The finished cast weighs " (weight.in_words()) ", without glue." }
                }
                h2 { "Have ready" }
                ul { @for item in ready(casts.iter().flat_map(|cast| &cast.sheet.materials)) { li { (marked(&item)) } } }
                @for cast in casts { (casting(cast, casts.len() > 1)) }
                @if casts.len() > 1 && !together.is_empty() {
                    h2 { "Put it together" }
                    (steps(together))
                }
                @if !sources.is_empty() {
                    h2 { "Sources" }
                    ul { @for source in sources { li { (source) } } }
                }
                footer {
                    div.ruler { }
                    p { "50 mm, if this sheet is printed in its own size (100 %). " (plan.program) "; mesh " (plan.input.sha256) }
                }
            }
        }
    }
}

/// What to pour, to print and to do for one mold.
fn casting(cast: &Cast, is_one_of_several: bool) -> Markup {
    let Cast { entry, sheet, pictures } = cast;
    let place = |file: &str| match entry.folder.as_str() {
        "." => file.to_owned(),
        folder => format!("{folder}/{file}"),
    };
    html! {
        h2 {
            @if is_one_of_several { "Cast the " (entry.name) } @else { "Cast" }
        }
        div.pictures { @for picture in pictures { img alt="" src={ "data:image/png;base64," (picture) }; } }
        table { @for (what, value) in sheet.rows() { tr { th scope="row" { (what) } td { (value) } } } }
        @if let Some(pour) = &sheet.silicone { p { (pour.pressure_in_words()) } }
        table {
            tr { @for head in ["part", "file [mm]", "volume", "mass, if solid", "supports"] { th { (head) } } }
            @for part in &sheet.printed {
                tr {
                    td { (part.name) }
                    td { code { (place(&part.file)) } }
                    td { (format!("{:.1} mL", part.volume_ml)) }
                    td { (format!("{:.0} g", part.mass_g)) }
                    td { @if part.supports { "yes" } @else { "no" } }
                }
            }
        }
        (steps(sheet.steps.iter()))
    }
}

/// Steps to be ticked, in order.
fn steps<'a>(steps: impl IntoIterator<Item = &'a String>) -> Markup {
    html! { ol { @for step in steps { li { input type="checkbox"; " " (marked(step)) } } } }
}

/// A text whose words between ` are code.
fn marked(text: &str) -> Markup {
    html! {
        @for (i, part) in text.split('`').enumerate() { @if i % 2 == 1 { code { (part) } } @else { (part) } }
    }
}

/// Texts, each of them once.
fn once<'a>(texts: impl Iterator<Item = &'a String>) -> Vec<&'a String> {
    let mut found: Vec<&String> = Vec::new();
    for text in texts {
        if !found.contains(&text) {
            found.push(text);
        }
    }
    found
}

/// What to have, of all molds: what is used up is added, what is used again is had once.
fn ready<'a>(items: impl Iterator<Item = &'a Item>) -> Vec<String> {
    let mut all: Vec<Item> = Vec::new();
    for item in items {
        let same = |known: &&mut Item| amount(&known.what).1 == amount(&item.what).1;
        let Some(known) = all.iter_mut().find(same) else {
            all.push(item.clone());
            continue;
        };
        match (amount(&known.what), amount(&item.what)) {
            ((Some(a), rest), (Some(b), _)) => known.what = format!("{:.0}{rest}", a + b),
            _ if item.what.starts_with("bolt") => known.count += item.count,
            _ => known.count = known.count.max(item.count),
        }
    }
    let each = all.into_iter().map(|Item { count, what }| match what.chars().next() {
        Some(first) if first.is_ascii_digit() && count == 1 => what,
        _ => format!("{count} × {what}"),
    });
    each.collect()
}

/// The number with which a text begins, if there is one, and the rest.
fn amount(text: &str) -> (Option<f64>, &str) {
    let (number, rest) = text.split_at(text.find(' ').unwrap_or(0));
    number.parse().map_or((None, text), |number| (Some(number), rest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_used_up_is_added() {
        let item = |count, what: &str| Item { count, what: what.into() };
        let items = [
            item(1, "58 g of PLA, if printed solid"),
            item(1, "spray of release agent"),
            item(4, "bolt M3 × 20 mm"),
        ];
        let all =
            ["116 g of PLA, if printed solid", "1 × spray of release agent", "8 × bolt M3 × 20 mm"];
        assert_eq!(ready(items.iter().chain(&items)), all);
    }

    #[test]
    fn texts_are_texts() {
        let shown = marked("cut by `top.svg`: <b>").into_string();
        assert_eq!(shown, "cut by <code>top.svg</code>: &lt;b&gt;");
    }
}
