//! Tables of what reports say, as HTML that needs no script. Every value is text: `html!` escapes it.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use maud::{Markup, html};
use mesh::io::read_text;
use reports::{Chamber, End, ErrorBar};
use serde::Deserialize;
use serde_json::Value;

use crate::prose::{digits, markdown, quantity};
use crate::survey::{Survey, name};
use crate::{inputs, read_json, wall};

/// A table.
fn table(head: &[&str], rows: &[Vec<Markup>]) -> Markup {
    html! {
        div.scroll {
            table {
                thead { tr { @for name in head { th scope="col" { (name) } } } }
                tbody { @for row in rows { tr { @for cell in row { td { (cell) } } } } }
            }
        }
    }
}

/// A row of a table of texts.
fn texts<T: AsRef<str>>(cells: impl IntoIterator<Item = T>) -> Vec<Markup> {
    cells.into_iter().map(|cell| html! { (cell.as_ref()) }).collect()
}

/// Texts below each other.
fn lines<T: maud::Render>(lines: &[T]) -> Markup {
    html! { @for (i, line) in lines.iter().enumerate() { @if i > 0 { br; } (line) } }
}

/// A section of the page; nothing if it has no content.
fn section(id: &str, title: &str, content: &Markup) -> Markup {
    html! { @if !content.0.is_empty() { section id=(id) { h2 { (title) } (content) } } }
}

fn text(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(s) => s.clone(),
        Value::Number(n) => n.as_f64().map_or_else(String::new, whole_or_digits),
        other => other.to_string(),
    }
}

fn whole_or_digits(value: f64) -> String {
    let whole = value.fract() == 0.0 && value.abs() < 1e15;
    if whole { format!("{value}") } else { digits(value) }
}

/// Path of a file as readers know it: from the folder that the page is of.
fn below(path: &Path, folder: &Path) -> String {
    path.strip_prefix(folder).unwrap_or(path).display().to_string()
}

/// What the report of a simulation has of the state at the end, if there is one.
fn end_of(report: &Value) -> Option<End> {
    End::deserialize(report).ok()
}

/// The largest displacement of a tag [m].
fn largest_displacement(end: &End) -> Option<f64> {
    end.tags.values().map(|tag| tag.max_displacement).reduce(f64::max)
}

/// What simulations and optimisations found, and the probes with their error bars.
///
/// # Errors
/// If a report cannot be read.
pub fn results(survey: &Survey) -> Result<Markup> {
    let (mut rows, mut probes) = (Vec::new(), Vec::new());
    for folder in &survey.runs {
        let report = read_json(&folder.join("report.json"))?;
        let end = end_of(&report);
        let end = end.as_ref();
        let chamber = |(tag, c): (&String, &Chamber)| {
            let (rest, now) = (quantity(c.volume_rest, "m3"), quantity(c.volume, "m3"));
            format!("{tag}: {}, {rest} → {now}", quantity(c.pressure, "Pa"))
        };
        let chambers = end.map(|end| end.chambers.iter().map(chamber).collect::<Vec<_>>());
        let largest = end.and_then(largest_displacement).map(|u| quantity(u, "m"));
        let time = end.map(|end| format!("{} s", digits(end.wall_s)));
        rows.push(vec![
            html! { (name(folder)) },
            html! { (text(&report["status"])) },
            html! { (largest.unwrap_or_default()) },
            lines(&chambers.unwrap_or_default()),
            html! { (text(&report["tets"])) },
            html! { (time.unwrap_or_default()) },
        ]);
        end.into_iter().for_each(|end| probe_rows(&name(folder), end, &mut probes));
    }
    let heads = ["simulation", "status", "largest displacement", "chambers", "tetrahedra", "time"];
    let probe_heads = ["simulation", "probe", "value", "may be off by", "because of"];
    let content = html! {
        @if !rows.is_empty() { (table(&heads, &rows)) }
        @if !probes.is_empty() { h3 { "Probes" } (table(&probe_heads, &probes)) }
        @for folder in &survey.designs { (terms_of(folder)?) }
    };
    Ok(section("results", "Results", &content))
}

fn probe_rows(run: &str, end: &End, rows: &mut Vec<Vec<Markup>>) {
    for (probe, found) in end.probes.iter().flatten() {
        let bars = end.error_bars.as_ref().and_then(|bars| bars.get(probe));
        let number = |value: f64| quantity(value, &found.unit);
        let each = bars.iter().flat_map(|bars| &bars.bars).filter(|bar| bar.on.is_none());
        let reason = |bar: &ErrorBar| {
            let [down, up] = bar.change.map(number);
            format!("{}: {down} to {up}", bar.of)
        };
        let reasons: Vec<String> = each.map(reason).collect();
        let together = bars.map(|bars| format!("± {}", number(bars.together)));
        rows.push(vec![
            html! { (run) },
            html! { (probe) },
            html! { (number(found.value)) },
            html! { (together.unwrap_or_default()) },
            lines(&reasons),
        ]);
    }
}

/// Objective and terms of an optimisation before and after.
fn terms_of(folder: &Path) -> Result<Markup> {
    let path = folder.join("report.json");
    if !path.exists() {
        return Ok(html! {});
    }
    let report = read_json(&path)?;
    let row = |label: &str, before: &Value, after: &Value| {
        texts([label.to_owned(), text(before), text(after)])
    };
    let mut rows = vec![row("objective", &report["objective_before"], &report["objective_after"])];
    for (term, after) in report["terms_after"].as_object().into_iter().flatten() {
        rows.push(row(term, &report["terms_before"][term], after));
    }
    let head = ["term of the objective", "before", "after"];
    Ok(html! { h3 { (name(folder)) ": " (text(&report["status"])) } (table(&head, &rows)) })
}

/// What `fab verify` found, line by line; what failed comes first.
///
/// # Errors
/// If a file cannot be read.
pub fn checks(survey: &Survey) -> Result<Markup> {
    let each = survey.checks.iter().map(|path| Ok(checks_of(&name(path), &read_text(path)?)));
    let content = each.collect::<Result<Vec<_>>>()?;
    Ok(section("checks", "Checks of the mold", &html! { @for checks in content { (checks) } }))
}

fn checks_of(file: &str, text: &str) -> Markup {
    let all =
        text.lines().map(columns).filter(|l| matches!(l.first(), Some(&("ok" | "warn" | "FAIL"))));
    let is = |status: &'static str| move |l: &Vec<&str>| l.first() == Some(&status);
    let (good, others): (Vec<_>, Vec<_>) = all.partition(is("ok"));
    let failed = others.iter().filter(|l| is("FAIL")(l)).count();
    let head = ["", "check", "found", "wanted"];
    let rows = |lines: &[Vec<&str>]| lines.iter().map(texts).collect::<Vec<_>>();
    html! {
        p class=(if failed == 0 { "good" } else { "bad" }) {
            (file) ": " (good.len()) " checks hold, " (failed) " fail, " (others.len() - failed) " warn"
        }
        @if !others.is_empty() { (table(&head, &rows(&others))) }
        details { summary { "the checks that hold" } (table(&head, &rows(&good))) }
    }
}

/// Columns of a line: they are two blanks apart at least.
fn columns(line: &str) -> Vec<&str> {
    line.split("  ").map(str::trim).filter(|cell| !cell.is_empty()).collect()
}

/// Why the mold is as it is, and the casting sheets.
///
/// # Errors
/// If a file cannot be read.
pub fn casting(survey: &Survey) -> Result<Markup> {
    let plans = survey.reports.iter().filter(|path| name(path) == "plan.json");
    let plans = plans.map(|path| read_json(path)).collect::<Result<Vec<_>>>()?;
    let content = html! {
        @for plan in plans {
            p { "Method: " strong { (text(&plan["method"])) } "; " (text(&plan["reason"])) "." }
        }
        @for path in &survey.sheets { article.sheet { (markdown(&read_text(path)?)) } }
    };
    Ok(section("casting", "Casting", &content))
}

/// Programs, inputs with their hashes, times and memory of everything that has a report.
///
/// # Errors
/// If a report cannot be read.
pub fn provenance(survey: &Survey) -> Result<Markup> {
    let mut rows = Vec::new();
    for path in &survey.reports {
        let report = read_json(path)?;
        let kinds = report["inputs"].as_object().into_iter().flatten().map(|(_, kind)| kind);
        let all = kinds.chain([&report["input"]]).flat_map(inputs);
        let set = report["set"].as_array().into_iter().flatten();
        let set = set.map(|change| html! { "--set " code { (text(change)) } });
        let inputs: Vec<Markup> = all.map(input).chain(set).collect();
        let number =
            |key: &str, unit| report[key].as_f64().map(|v| format!("{} {unit}", digits(v)));
        let time = number("wall_s", "s").or_else(|| number("wall_s_of_this_run", "s"));
        rows.push(vec![
            html! { (below(path, &survey.folder)) },
            html! { (text(&report["program"])) },
            lines(&inputs),
            html! { (time.unwrap_or_default()) },
            html! { (number("peak_rss_mb", "MB").unwrap_or_default()) },
        ]);
    }
    let head = ["report", "program", "inputs, SHA-256", "time", "memory"];
    let content = html! {
        (table(&head, &rows))
        (timings(survey)?)
        p { "Page by cad2fem " (env!("CARGO_PKG_VERSION")) "." }
    };
    Ok(section("inputs", "Inputs and versions", &content))
}

fn input(input: &Value) -> Markup {
    html! { (text(&input["path"])) " " code { (text(&input["sha256"])) } }
}

/// What took how long in simulations.
fn timings(survey: &Survey) -> Result<Markup> {
    let mut rows = Vec::new();
    for folder in &survey.runs {
        let report = read_json(&folder.join("report.json"))?;
        for (task, time) in report["timings"].as_object().into_iter().flatten() {
            let of = |key: &str| time[key].as_f64().map(|t| format!("{} s", digits(t)));
            if let (Some(wall), Some(processor)) = (of("wall_s"), of("processor_s")) {
                rows.push(texts([name(folder), task.clone(), wall, processor]));
            }
        }
    }
    let head = ["simulation", "task", "wall time", "processor time"];
    Ok(html! {
        @if !rows.is_empty() {
            details { summary { "where the time went" } (table(&head, &rows)) }
        }
    })
}

/// All pictures, in the page itself.
///
/// # Errors
/// If a picture is neither PNG nor SVG or cannot be read.
pub fn pictures(paths: &[PathBuf]) -> Result<Markup> {
    let content = html! {
        @if !paths.is_empty() {
            div.pictures { @for path in paths { (picture(path)?) } }
        }
    };
    Ok(section("pictures", "Pictures", &content))
}

/// A picture in an `img`, in which no browser runs scripts of an SVG file.
fn picture(path: &Path) -> Result<Markup> {
    use base64::Engine as _;
    let kind = match path.extension().and_then(|e| e.to_str()) {
        Some("png") => "png",
        Some("svg") => "svg+xml",
        _ => bail!("{}: neither PNG nor SVG", path.display()),
    };
    let data = base64::engine::general_purpose::STANDARD.encode(mesh::io::read_bytes(path)?);
    let caption = path.file_stem().unwrap_or_default().to_string_lossy();
    Ok(html! {
        figure {
            img alt=(caption) src={ "data:image/" (kind) ";base64," (data) };
            figcaption { (caption) }
        }
    })
}

/// The numbers that stand at the top of a page: label and value.
///
/// # Errors
/// If a report cannot be read.
pub fn headlines(survey: &Survey) -> Result<Markup> {
    let mut tiles: Vec<(String, Vec<String>)> = Vec::new();
    let mut moved = Vec::new();
    for folder in &survey.runs {
        let report = read_json(&folder.join("report.json"))?;
        if let Some(u) = end_of(&report).as_ref().and_then(largest_displacement) {
            moved.push(format!("{} {}", quantity(u, "m"), name(folder)));
        }
    }
    if !moved.is_empty() {
        tiles.push(("largest displacement".into(), moved));
    }
    for folder in &survey.designs {
        let path = folder.join("report.json");
        let report = if path.exists() { read_json(&path)? } else { Value::Null };
        let of = |key: &str| report[key].as_f64();
        if let (Some(before), Some(after)) = (of("objective_before"), of("objective_after")) {
            let value = format!("{} → {}", digits(before), digits(after));
            tiles.push((format!("objective, {}", name(folder)), vec![value]));
        }
    }
    let walls = wall::all(survey)?;
    if !walls.is_empty() {
        let each = walls.iter().map(|wall| quantity(wall.thickness, "m")).collect();
        tiles.push(("thinnest wall".into(), each));
    }
    for path in &survey.checks {
        let text = read_text(path)?;
        let count = |status: &str| text.lines().filter(|l| l.starts_with(status)).count();
        let value = format!("{} hold, {} warn, {} fail", count("ok"), count("warn"), count("FAIL"));
        tiles.push(("checks of the mold".into(), vec![value]));
    }
    for sheet in survey.molds.iter().map(|m| m.join("cast.json")).filter(|p| p.exists()) {
        let cast = read_json(&sheet)?;
        if let Some(mass) = cast["silicone"]["mass_g"].as_f64() {
            let value = format!("{mass:.1} g {}", text(&cast["silicone"]["name"]));
            tiles.push(("silicone to mix".into(), vec![value]));
        }
    }
    Ok(html! {
        dl.tiles { @for (label, value) in &tiles { div { dt { (label) } dd { (lines(value)) } } } }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_two_blanks_apart() {
        let line = "ok    overlap: upper and core          0 mm³            at most 0.2 mm³";
        assert_eq!(columns(line), ["ok", "overlap: upper and core", "0 mm³", "at most 0.2 mm³"]);
    }
}
