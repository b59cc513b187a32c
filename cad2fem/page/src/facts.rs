//! Tables of what reports say, as HTML that needs no script.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use mesh::io::read_text;
use serde_json::Value;

use crate::prose::{digits, escape, markdown, quantity};
use crate::survey::{Survey, name};
use crate::{inputs, read_json};

/// A table; cells are HTML already.
fn table(head: &[&str], rows: &[Vec<String>]) -> String {
    let mut html = String::from("<div class=\"scroll\"><table><thead><tr>");
    head.iter().for_each(|h| html += &format!("<th scope=\"col\">{}</th>", escape(h)));
    html += "</tr></thead><tbody>";
    for row in rows {
        let cells: String = row.iter().map(|cell| format!("<td>{cell}</td>")).collect();
        html += &format!("<tr>{cells}</tr>");
    }
    html + "</tbody></table></div>"
}

/// A section of the page; nothing if it has no content.
fn section(id: &str, title: &str, content: &str) -> String {
    if content.is_empty() {
        return String::new();
    }
    format!("<section id=\"{id}\"><h2>{title}</h2>{content}</section>\n")
}

fn text(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(s) => escape(s),
        Value::Number(n) => n.as_f64().map_or_else(String::new, whole_or_digits),
        other => escape(&other.to_string()),
    }
}

fn whole_or_digits(value: f64) -> String {
    let whole = value.fract() == 0.0 && value.abs() < 1e15;
    if whole { format!("{value}") } else { digits(value) }
}

/// Path of a file as readers know it: from the folder that the page is of.
fn below(path: &Path, folder: &Path) -> String {
    escape(&path.strip_prefix(folder).unwrap_or(path).display().to_string())
}

/// The largest displacement of a report [m].
fn largest_displacement(report: &Value) -> Option<f64> {
    let tags = report["tags"].as_object()?.values();
    tags.filter_map(|tag| tag["max_displacement"].as_f64()).reduce(f64::max)
}

/// What simulations and optimisations found, and the probes with their error bars.
///
/// # Errors
/// If a report cannot be read.
pub fn results(survey: &Survey) -> Result<String> {
    let (mut rows, mut probes) = (Vec::new(), Vec::new());
    for folder in &survey.runs {
        let report = read_json(&folder.join("report.json"))?;
        let chambers: Vec<String> = report["chambers"]
            .as_object()
            .into_iter()
            .flatten()
            .map(|(tag, c)| {
                let of = |key: &str, unit| {
                    c[key].as_f64().map_or_else(String::new, |v| quantity(v, unit))
                };
                let (rest, now) = (of("volume_rest", "m3"), of("volume", "m3"));
                format!("{}: {}, {rest} → {now}", escape(tag), of("pressure", "Pa"))
            })
            .collect();
        let largest = largest_displacement(&report).map(|u| quantity(u, "m"));
        let time = report["wall_s"].as_f64().map(|t| format!("{} s", digits(t)));
        rows.push(vec![
            escape(&name(folder)),
            text(&report["status"]),
            largest.unwrap_or_default(),
            chambers.join("<br>"),
            text(&report["tets"]),
            time.unwrap_or_default(),
        ]);
        probe_rows(&name(folder), &report, &mut probes);
    }
    let mut html = String::new();
    if !rows.is_empty() {
        let head =
            ["simulation", "status", "largest displacement", "chambers", "tetrahedra", "time"];
        html += &table(&head, &rows);
    }
    if !probes.is_empty() {
        let head = ["simulation", "probe", "value", "may be off by", "because of"];
        html += &format!("<h3>Probes</h3>{}", table(&head, &probes));
    }
    let mut terms = String::new();
    for folder in &survey.designs {
        terms += &terms_of(folder)?;
    }
    Ok(section("results", "Results", &(html + &terms)))
}

fn probe_rows(run: &str, report: &Value, rows: &mut Vec<Vec<String>>) {
    for (probe, found) in report["probes"].as_object().into_iter().flatten() {
        let unit = found["unit"].as_str().unwrap_or_default();
        let bars = &report["error_bars"][probe];
        let change = |bar: &Value| {
            let of = |i: usize| bar[i].as_f64().map_or_else(String::new, |v| quantity(v, unit));
            if bar.is_array() { format!("{} to {}", of(0), of(1)) } else { String::new() }
        };
        let each = bars["bars"].as_array().into_iter().flatten().filter(|bar| bar["on"].is_null());
        let reasons: Vec<String> =
            each.map(|bar| format!("{}: {}", text(&bar["of"]), change(&bar["change"]))).collect();
        let together = bars["together"].as_f64().map(|v| format!("± {}", quantity(v, unit)));
        let value = found["value"].as_f64().map(|v| quantity(v, unit));
        rows.push(vec![
            escape(run),
            escape(probe),
            value.unwrap_or_default(),
            together.unwrap_or_else(|| change(&bars["together"])),
            reasons.join("<br>"),
        ]);
    }
}

/// Objective and terms of an optimisation before and after.
fn terms_of(folder: &Path) -> Result<String> {
    let path = folder.join("report.json");
    if !path.exists() {
        return Ok(String::new());
    }
    let report = read_json(&path)?;
    let row =
        |label: &str, before: &Value, after: &Value| vec![escape(label), text(before), text(after)];
    let mut rows = vec![row("objective", &report["objective_before"], &report["objective_after"])];
    for (term, after) in report["terms_after"].as_object().into_iter().flatten() {
        rows.push(row(term, &report["terms_before"][term], after));
    }
    let head = ["term of the objective", "before", "after"];
    let heading = format!("<h3>{}: {}</h3>", escape(&name(folder)), text(&report["status"]));
    Ok(heading + &table(&head, &rows))
}

/// What `fab verify` found, line by line; what failed comes first.
///
/// # Errors
/// If a file cannot be read.
pub fn checks(survey: &Survey) -> Result<String> {
    let mut html = String::new();
    for path in &survey.checks {
        let text = read_text(path)?;
        let lines: Vec<Vec<&str>> =
            text.lines().filter(|l| !l.trim().is_empty()).map(columns).collect();
        let is = |status: &'static str| move |l: &Vec<&str>| l.first() == Some(&status);
        let (good, others): (Vec<_>, Vec<_>) = lines.into_iter().partition(is("ok"));
        let failed = others.iter().filter(|l| is("FAIL")(l)).count();
        let head = ["", "check", "found", "wanted"];
        let rows = |lines: &[Vec<&str>]| -> Vec<Vec<String>> {
            lines.iter().map(|l| l.iter().map(|cell| escape(cell)).collect()).collect()
        };
        let state = if failed == 0 { "good" } else { "bad" };
        let _ = write!(
            html,
            "<p class=\"{state}\">{}: {} checks hold, {failed} fail, {} warn</p>",
            escape(&name(path)),
            good.len(),
            others.len() - failed
        );
        if !others.is_empty() {
            html += &table(&head, &rows(&others));
        }
        let _ = write!(
            html,
            "<details><summary>the checks that hold</summary>{}</details>",
            table(&head, &rows(&good))
        );
    }
    Ok(section("checks", "Checks of the mold", &html))
}

/// Columns of a line: they are two blanks apart at least.
fn columns(line: &str) -> Vec<&str> {
    line.split("  ").map(str::trim).filter(|cell| !cell.is_empty()).collect()
}

/// Why the mold is as it is, and the casting sheets.
///
/// # Errors
/// If a file cannot be read.
pub fn casting(survey: &Survey) -> Result<String> {
    let mut html = String::new();
    for path in survey.reports.iter().filter(|path| name(path) == "plan.json") {
        let plan = read_json(path)?;
        let of = |key: &str| text(&plan[key]);
        html += &format!("<p>Method: <strong>{}</strong>. {}</p>", of("method"), of("reason"));
    }
    for path in &survey.sheets {
        html += &format!("<article class=\"sheet\">{}</article>", markdown(&read_text(path)?));
    }
    Ok(section("casting", "Casting", &html))
}

/// Programs, inputs with their hashes, times and memory of everything that has a report.
///
/// # Errors
/// If a report cannot be read.
pub fn provenance(survey: &Survey) -> Result<String> {
    let mut rows = Vec::new();
    for path in &survey.reports {
        let report = read_json(path)?;
        let kinds = report["inputs"].as_object().into_iter().flatten().map(|(_, kind)| kind);
        let all = kinds.chain([&report["input"]]).flat_map(inputs);
        let set = report["set"].as_array().into_iter().flatten();
        let set = set.map(|change| format!("--set <code>{}</code>", text(change)));
        let inputs: Vec<String> = all.map(input).chain(set).collect();
        let number =
            |key: &str, unit| report[key].as_f64().map(|v| format!("{} {unit}", digits(v)));
        let time = number("wall_s", "s").or_else(|| number("wall_s_of_this_run", "s"));
        rows.push(vec![
            below(path, &survey.folder),
            text(&report["program"]),
            inputs.join("<br>"),
            time.unwrap_or_default(),
            number("peak_rss_mb", "MB").unwrap_or_default(),
        ]);
    }
    let head = ["report", "program", "inputs, SHA-256", "time", "memory"];
    let made = format!("<p>Page by cad2fem {}.</p>", env!("CARGO_PKG_VERSION"));
    let timings = timings(survey)?;
    Ok(section("inputs", "Inputs and versions", &(table(&head, &rows) + &timings + &made)))
}

fn input(input: &Value) -> String {
    format!("{} <code>{}</code>", text(&input["path"]), text(&input["sha256"]))
}

/// What took how long in simulations.
fn timings(survey: &Survey) -> Result<String> {
    let mut rows = Vec::new();
    for folder in &survey.runs {
        let report = read_json(&folder.join("report.json"))?;
        for (task, time) in report["timings"].as_object().into_iter().flatten() {
            let of = |key: &str| time[key].as_f64().map(|t| format!("{} s", digits(t)));
            if let (Some(wall), Some(processor)) = (of("wall_s"), of("processor_s")) {
                rows.push(vec![escape(&name(folder)), escape(task), wall, processor]);
            }
        }
    }
    if rows.is_empty() {
        return Ok(String::new());
    }
    let table = table(&["simulation", "task", "wall time", "processor time"], &rows);
    Ok(format!("<details><summary>where the time went</summary>{table}</details>"))
}

/// All pictures, in the page itself.
///
/// # Errors
/// If a picture is neither PNG nor SVG or cannot be read.
pub fn pictures(paths: &[PathBuf]) -> Result<String> {
    use base64::Engine as _;
    let mut html = String::new();
    for path in paths {
        let kind = match path.extension().and_then(|e| e.to_str()) {
            Some("png") => "png",
            Some("svg") => "svg+xml",
            _ => bail!("{}: neither PNG nor SVG", path.display()),
        };
        let bytes = mesh::io::read_bytes(path)?;
        let data = base64::engine::general_purpose::STANDARD.encode(bytes);
        let caption = escape(&path.file_stem().unwrap_or_default().to_string_lossy());
        let _ = write!(
            html,
            "<figure><img alt=\"{caption}\" src=\"data:image/{kind};base64,{data}\">\
             <figcaption>{caption}</figcaption></figure>"
        );
    }
    if !html.is_empty() {
        html = format!("<div class=\"pictures\">{html}</div>");
    }
    Ok(section("pictures", "Pictures", &html))
}

/// The numbers that stand at the top of a page: label and value.
///
/// # Errors
/// If a report cannot be read.
pub fn headlines(survey: &Survey) -> Result<String> {
    let mut tiles: Vec<(String, String)> = Vec::new();
    let mut moved = Vec::new();
    for folder in &survey.runs {
        let report = read_json(&folder.join("report.json"))?;
        if let Some(u) = largest_displacement(&report) {
            moved.push(format!("{} {}", quantity(u, "m"), escape(&name(folder))));
        }
    }
    if !moved.is_empty() {
        tiles.push(("largest displacement".into(), moved.join("<br>")));
    }
    for folder in &survey.designs {
        let path = folder.join("report.json");
        let report = if path.exists() { read_json(&path)? } else { Value::Null };
        let of = |key: &str| report[key].as_f64();
        if let (Some(before), Some(after)) = (of("objective_before"), of("objective_after")) {
            let value = format!("{} → {}", digits(before), digits(after));
            tiles.push((format!("objective, {}", escape(&name(folder))), value));
        }
    }
    for path in &survey.checks {
        let text = read_text(path)?;
        let count = |status: &str| text.lines().filter(|l| l.starts_with(status)).count();
        let value = format!("{} hold, {} warn, {} fail", count("ok"), count("warn"), count("FAIL"));
        tiles.push(("checks of the mold".into(), value));
    }
    for sheet in survey.molds.iter().map(|m| m.join("cast.json")).filter(|p| p.exists()) {
        let cast = read_json(&sheet)?;
        if let Some(mass) = cast["silicone"]["mass_g"].as_f64() {
            let value = format!("{mass:.1} g {}", text(&cast["silicone"]["name"]));
            tiles.push(("silicone to mix".into(), value));
        }
    }
    let tile =
        |(label, value): &(String, String)| format!("<div><dt>{label}</dt><dd>{value}</dd></div>");
    Ok(format!("<dl class=\"tiles\">{}</dl>", tiles.iter().map(tile).collect::<String>()))
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
