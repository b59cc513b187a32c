//! Tables of what reports say, as HTML that needs no script. Every value is text: `html!` escapes it.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use maud::{Markup, html};
use mesh::io::read_text;
use program::InputFile;
use reports::{Chamber, End, ErrorBar, ErrorBars, PointKind};

use crate::prose::{digits, quantity};
use crate::reported::{CastSheet, Design, Provenance, read};
use crate::survey::{Reported, Survey, name};
use crate::wall;

/// A table, without columns in which no row has anything.
pub(crate) fn table(head: &[&str], rows: &[Vec<Markup>]) -> Markup {
    let holds = |c: usize| rows.iter().any(|row| row.get(c).is_some_and(|cell| !cell.0.is_empty()));
    let shown: Vec<usize> = (0..head.len()).filter(|&c| rows.is_empty() || holds(c)).collect();
    html! {
        div.scroll {
            table {
                thead { tr { @for &c in &shown { th scope="col" { (head[c]) } } } }
                tbody { @for row in rows { tr { @for &c in &shown { td { @if let Some(cell) = row.get(c) { (cell) } } } } } }
            }
        }
    }
}

/// A status of a report in words.
fn status_in_words(status: &str) -> String {
    status.replace('_', " ")
}

/// A row of a table of texts.
pub(crate) fn texts<T: AsRef<str>>(cells: impl IntoIterator<Item = T>) -> Vec<Markup> {
    cells.into_iter().map(|cell| html! { (cell.as_ref()) }).collect()
}

/// Texts below each other.
fn lines<T: maud::Render>(lines: &[T]) -> Markup {
    html! { @for (i, line) in lines.iter().enumerate() { @if i > 0 { br; } (line) } }
}

/// A section of the page; nothing if it has no content.
pub(crate) fn section(id: &str, title: &str, content: &Markup) -> Markup {
    html! { @if !content.0.is_empty() { section id=(id) { h2 { (title) } (content) } } }
}

fn whole_or_digits(value: f64) -> String {
    let whole = value.fract() == 0.0 && value.abs() < 1e15;
    if whole { format!("{value}") } else { digits(value) }
}

/// Path of a file as readers know it: from the folder that the page is of.
fn below(path: &Path, folder: &Path) -> String {
    system::portable(path.strip_prefix(folder).unwrap_or(path))
}

/// The largest displacement of a tag [m].
fn largest_displacement(end: &End) -> Option<f64> {
    end.tags.values().map(|tag| tag.max_displacement).reduce(f64::max)
}

/// What simulations and optimisations found, and the probes with their error bars.
pub fn results(survey: &Survey) -> Markup {
    let (mut rows, mut probes, mut limits) = (Vec::new(), Vec::new(), Vec::new());
    for Reported { folder, report } in &survey.runs {
        let end = report.end.as_ref();
        let chamber = |(tag, c): (&String, &Chamber)| {
            let (rest, now) = (quantity(c.volume_rest, "m3"), quantity(c.volume, "m3"));
            format!("{tag}: {}, {rest} → {now}", quantity(c.pressure, "Pa"))
        };
        let chambers = end.map(|end| end.chambers.iter().map(chamber).collect::<Vec<_>>());
        let largest = end.and_then(largest_displacement).map(|u| quantity(u, "m"));
        let time = end.map(|end| format!("{} s", digits(end.wall_s)));
        rows.push(vec![
            html! { (name(folder)) },
            html! { (status_in_words(&report.status)) },
            html! { (largest.unwrap_or_default()) },
            lines(&chambers.unwrap_or_default()),
            html! { (report.tets.map_or_else(String::new, |count| count.to_string())) },
            html! { (time.unwrap_or_default()) },
        ]);
        if let Some(end) = end {
            probe_rows(&name(folder), end, &mut probes);
            limit_rows(&name(folder), end, &mut limits);
        }
    }
    let heads = ["simulation", "status", "largest displacement", "chambers", "tetrahedra", "time"];
    let probe_heads = ["simulation", "probe", "value", "may be off by", "because of"];
    let limit_heads =
        ["simulation", "edge", "factor on the pressure", "may be off by", "because of"];
    let content = html! {
        @if !rows.is_empty() { (table(&heads, &rows)) }
        @if !probes.is_empty() { h3 { "Probes" } (table(&probe_heads, &probes)) }
        @if !limits.is_empty() { h3 { "Limits" } (table(&limit_heads, &limits)) }
        @for design in &survey.designs { (terms_of(design)) }
    };
    section("results", "Results", &content)
}

fn probe_rows(run: &str, end: &End, rows: &mut Vec<Vec<Markup>>) {
    for (probe, found) in end.probes.iter().flatten() {
        let bars = end.error_bars.as_ref().and_then(|bars| bars.get(probe));
        let value = found.value.map(|value| quantity(value, &found.unit));
        rows.push(row_with_bars([run, probe, &value.unwrap_or_default()], bars, &found.unit));
    }
}

/// Three cells, what the value of the last may be off by, and because of what.
fn row_with_bars(cells: [&str; 3], bars: Option<&ErrorBars>, unit: &str) -> Vec<Markup> {
    let number = |value: f64| quantity(value, unit);
    let each = bars.iter().flat_map(|bars| &bars.bars).filter(|bar| bar.on.is_none());
    let reason = |bar: &ErrorBar| {
        let [down, up] = bar.change.map(number);
        format!("{}: {down} to {up}", bar.of)
    };
    let reasons: Vec<String> = each.map(reason).collect();
    let together = bars.map(|bars| format!("± {}", number(bars.together)));
    let mut row = texts(cells);
    row.extend([html! { (together.unwrap_or_default()) }, lines(&reasons)]);
    row
}

/// The factors of a limit and of a burst, and the slope of the pressure.
fn limit_rows(run: &str, end: &End, rows: &mut Vec<Vec<Markup>>) {
    let Some(limit) = &end.limit else { return };
    let kind = match limit.kind {
        Some(PointKind::LimitPoint) => "no equilibrium beyond",
        Some(PointKind::Bifurcation) => "buckles",
        None => "stable at least to",
    };
    let value = digits(limit.factor.unwrap_or(limit.stable_to));
    rows.push(row_with_bars([run, kind, &value], limit.error_bars.get("factor"), "1"));
    if let Some(burst) = limit.burst {
        let cells = [run, "stretch at break", &digits(burst)];
        rows.push(row_with_bars(cells, limit.error_bars.get("burst"), "1"));
    }
    if let Some(slope) = limit.slope {
        let cells = [run, "slope of the pressure, of 1 in proportion", &digits(slope)];
        rows.push(row_with_bars(cells, limit.error_bars.get("slope"), "1"));
    }
}

/// Objective and terms of an optimisation before and after.
fn terms_of(Reported { folder, report }: &Reported<Design>) -> Markup {
    let Design { status: Some(status), designed } = report else { return html! {} };
    let text = |value: Option<f64>| value.map_or_else(String::new, whole_or_digits);
    let row = |label: &str, before, after| texts([label.to_owned(), text(before), text(after)]);
    let mut rows = Vec::new();
    if let Some(found) = designed {
        rows.push(row("objective", found.objective_before, found.objective_after));
        for (term, after) in &found.terms_after {
            rows.push(row(term, found.terms_before.get(term).copied().flatten(), *after));
        }
    }
    let head = ["term of the objective", "before", "after"];
    let levels = designed.iter().flat_map(|found| &found.levels);
    html! {
        h3 { (name(folder)) ": " (status_in_words(status)) }
        @for end in levels {
            p { "Level " (end.level) " " (end.ending.in_words()) ": " (end.why) "." }
        }
        (table(&head, &rows))
    }
}

/// What `fab verify` found, line by line; what failed comes first.
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
pub fn casting(survey: &Survey) -> Result<Markup> {
    let sheets =
        survey.sheets().map(|path| read::<CastSheet>(&path)).collect::<Result<Vec<_>>>()?;
    let content = html! {
        @for plan in &survey.plans {
            p { "Method: " strong { (plan.method) } "; " (plan.reason) "." }
        }
        @for sheet in &sheets {
            article.sheet {
                ul { @for warning in &sheet.warnings { li { strong { (warning) } } } }
                ol { @for step in &sheet.steps { li { (step) } } }
            }
        }
        @for plan in survey.plans.iter().filter(|plan| sheets.len() > 1 && !plan.steps.is_empty()) {
            ol { @for step in &plan.steps { li { (step) } } }
        }
    };
    Ok(section("casting", "Casting", &content))
}

/// Programs, inputs with their hashes, times and memory of everything that has a report.
pub fn provenance(survey: &Survey) -> Result<Markup> {
    let mut rows = Vec::new();
    for path in &survey.reports {
        let report: Provenance = read(path)?;
        let set = report.set.iter().map(|change| html! { "--set " code { (change) } });
        let inputs: Vec<Markup> = report.files().map(input).chain(set).collect();
        let number = |value: Option<f64>, unit| value.map(|v| format!("{} {unit}", digits(v)));
        rows.push(vec![
            html! { (below(path, &survey.folder)) },
            html! { (report.program.as_deref().unwrap_or_default()) },
            lines(&inputs),
            html! { (number(report.wall_s, "s").unwrap_or_default()) },
            html! { (number(report.peak_rss_mb, "MB").unwrap_or_default()) },
        ]);
    }
    let head = ["report", "program", "inputs, SHA-256", "time", "memory"];
    let content = html! {
        (table(&head, &rows))
        (timings(survey))
        p { "Page by cad2fem " (env!("CARGO_PKG_VERSION")) "." }
    };
    Ok(section("inputs", "Inputs and versions", &content))
}

fn input(input: &InputFile) -> Markup {
    html! { (input.path.to_string_lossy()) " " code { (input.sha256) } }
}

/// What took how long in simulations.
fn timings(survey: &Survey) -> Markup {
    let mut rows = Vec::new();
    for Reported { folder, report } in &survey.runs {
        let tasks = report.end.iter().flat_map(|end| end.timings.tasks());
        rows.extend(tasks.map(|(task, time)| {
            let [wall, processor] = [time.wall_s, time.processor_s].map(|t| digits(t) + " s");
            texts([name(folder), task.to_owned(), wall, processor])
        }));
    }
    let head = ["simulation", "task", "wall time", "processor time"];
    html! {
        @if !rows.is_empty() {
            details { summary { "where the time went" } (table(&head, &rows)) }
        }
    }
}

/// All pictures, in the page itself.
pub fn pictures(paths: &[PathBuf]) -> Result<Markup> {
    let content = html! {
        @if !paths.is_empty() {
            div.pictures { @for path in paths { (picture(path)?) } }
        }
    };
    Ok(section("pictures", "Pictures", &content))
}

/// A picture in an `img`, in which no browser runs scripts of an SVG file.
pub(crate) fn picture(path: &Path) -> Result<Markup> {
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
pub fn headlines(survey: &Survey) -> Result<Markup> {
    let mut tiles: Vec<(String, Vec<String>)> = Vec::new();
    let mut moved = Vec::new();
    for Reported { folder, report } in &survey.runs {
        if let Some(u) = report.end.as_ref().and_then(largest_displacement) {
            moved.push(format!("{} {}", quantity(u, "m"), name(folder)));
        }
    }
    if !moved.is_empty() {
        tiles.push(("largest displacement".into(), moved));
    }
    for Reported { folder, report } in &survey.designs {
        let designed = report.designed.as_ref();
        let objectives = designed.map(|found| (found.objective_before, found.objective_after));
        if let Some((Some(before), Some(after))) = objectives {
            let value = format!("{} → {}", digits(before), digits(after));
            tiles.push((format!("objective, {}", name(folder)), vec![value]));
        }
    }
    let walls = wall::all(survey);
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
    for sheet in survey.sheets() {
        if let Some(silicone) = read::<CastSheet>(&sheet)?.silicone {
            let value = format!("{:.1} g {}", silicone.mass_g, silicone.name);
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
    fn a_column_that_no_row_fills_is_left_out() {
        let rows = [texts(["beam", "", "1 mm"]), texts(["arm", ""])];
        let page = table(&["run", "may be off by", "value"], &rows).into_string();
        assert!(!page.contains("may be off by") && page.contains("value"), "{page}");
        assert_eq!(page.matches("<td>").count(), 4, "{page}");
        assert!(table(&["run"], &[]).into_string().contains("run"));
    }
}
