//! Simulations beside measurements: what `solver validate` found, row by row with its picture.

use std::path::Path;

use anyhow::Result;
use maud::{Markup, html};
use reports::{Comparison, Validation};

use crate::facts::{picture, section, table, texts};
use crate::prose::digits;
use crate::reported::read;
use crate::survey::Survey;

/// All comparisons: a table of errors, then each row with what was measured and simulated, assumed and held back.
pub fn all(survey: &Survey) -> Result<Markup> {
    let mut content = Vec::new();
    for path in &survey.validations {
        let found: Validation = read(path)?;
        let folder = path.parent().unwrap_or(Path::new("."));
        content.push(errors(&found.rows));
        let mut drawn: Vec<&str> = Vec::new();
        for row in found.rows.chunk_by(|a, b| a.row == b.row) {
            content.push(details(row, folder, &mut drawn)?);
        }
    }
    Ok(section("validation", "Beside measurements", &html! { @for part in content { (part) } }))
}

/// The errors of all rows.
fn errors(rows: &[Comparison]) -> Markup {
    let head = ["measured", "simulated", "points", "mean error", "rms", "largest", "tolerance", ""];
    let row = |one: &Comparison| {
        let reached = one.simulated.iter().flatten().count();
        let [low, high] = one.tolerance.map(percent);
        texts([
            one.row.clone(),
            one.run.clone(),
            format!("{reached} of {}", one.measured.len()),
            format!("{}, {} {}", percent(one.mean), digits(one.mean_difference), one.unit),
            format!("{:.1} %, {} {}", 100.0 * one.rms, digits(one.rms_difference), one.unit),
            percent(one.largest),
            format!("{low} to {high}"),
            one.verdict().to_owned(),
        ])
    };
    table(&head, &rows.iter().map(row).collect::<Vec<_>>())
}

/// The comparisons of one row: what was assumed, its points, and its picture where that was not shown before.
fn details<'a>(row: &'a [Comparison], folder: &Path, drawn: &mut Vec<&'a str>) -> Result<Markup> {
    let Some(first) = row.first() else { return Ok(html! {}) };
    let drawing = folder.join(format!("{}.svg", first.plot));
    let is_new = drawing.is_file() && !drawn.contains(&&first.plot[..]);
    drawn.push(&first.plot);
    let notes = [
        ("tolerance", &first.reason),
        ("assumed", &first.assumed),
        ("held back", &first.held_back),
    ];
    let notes = notes.iter().filter_map(|(what, text)| Some((what, text.as_ref()?)));
    Ok(html! {
        h3 { (first.row) }
        @for (what, text) in notes { p { strong { (what) ": " } (text) } }
        @if is_new { div.pictures { (picture(&drawing)?) } }
        @for one in row { (points(one)) }
    })
}

/// The points of a comparison, to be unfolded.
fn points(one: &Comparison) -> Markup {
    let row = |(point, value): (&reports::MeasuredPoint, &Option<f64>)| {
        texts([
            digits(point.x),
            format!("{} ± {}", digits(point.y), digits(point.spread)),
            value.map_or_else(|| "not reached".to_owned(), digits),
            value.map_or_else(String::new, |value| percent(value / point.y - 1.0)),
        ])
    };
    let rows: Vec<_> = one.measured.iter().zip(&one.simulated).map(row).collect();
    let head =
        ["at".to_owned(), format!("measured [{}]", one.unit), one.run.clone(), "error".into()];
    let head: Vec<&str> = head.iter().map(String::as_str).collect();
    html! { details { summary { (one.run) ": " (one.measured.len()) " points" } (table(&head, &rows)) } }
}

fn percent(part: f64) -> String {
    format!("{:+.1} %", 100.0 * part)
}
