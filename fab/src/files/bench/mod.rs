//! `cast.pdf`: one or two pages for the bench, of all molds of a body: what to print and to weigh, times,
//! pictures, and the steps in their order.

mod layout;
mod pdf;
mod picture;
mod typeface;

use std::path::Path;

use mesh::io::{IoError, write_atomic};

use crate::files::output::{ASSEMBLED, EXPLODED};
use crate::files::report::MoldReport;
use crate::files::sheet::{self, Item, Sheet};
use crate::plan::report::{Material, PlanReport};
use layout::{Block, Mark};
use picture::Picture;
use typeface::Typefaces;

/// The sheet for the bench, beside plan.json.
pub const FILE: &str = "cast.pdf";

/// Points per millimetre.
const POINTS: f64 = 72.0 / 25.4;

/// Length of the ruler by which one sees that a sheet was printed in its own size [mm].
const RULER: f64 = 50.0;

/// Pictures beside each other, at most.
const PICTURES: usize = 3;

/// A mold with its sheet.
struct Cast {
    name: String,
    report: MoldReport,
    sheet: Sheet,
}

/// Writes the sheet of all molds of a plan, which are in `folder`, with the pictures that are there.
pub fn write(folder: &Path, plan: &PlanReport, title: &str) -> Result<(), IoError> {
    let mut casts = Vec::new();
    let mut pictures = Vec::new();
    for entry in &plan.molds {
        let below = folder.join(&entry.folder);
        let report = MoldReport::read(&below)?;
        let sheet = Sheet::new(&report).map_err(|message| IoError::content(&below, message))?;
        for name in [EXPLODED, ASSEMBLED] {
            let path = below.join(name);
            // of several molds only how their parts lie apart
            let wanted = plan.molds.len() == 1 || name == EXPLODED;
            if wanted && pictures.len() < PICTURES && path.exists() {
                pictures.push(Picture::read(&path)?);
            }
        }
        casts.push(Cast { name: entry.name.clone(), report, sheet });
    }
    let faces = Typefaces::new();
    let blocks = blocks(plan, &casts, title, pictures.len());
    let mut pages = layout::pages(&blocks, &pictures, &faces);
    let count = pages.len();
    for (i, page) in pages.iter_mut().enumerate() {
        page.extend(footer(plan, i + 1, count));
    }
    let bytes = pdf::file(&format!("{title}: bench sheet"), &pages, &pictures, &faces);
    write_atomic(&folder.join(FILE), |out| out.write_all(&bytes))
}

/// A ruler, the mesh that was cast, and the number of the page.
fn footer(plan: &PlanReport, page: usize, pages: usize) -> Vec<Mark> {
    let text =
        |x: f64, y: f64, text: String| Mark::Text { at: [x, y], size: 7.0, bold: false, text };
    let (left, low) = (45.0, 40.0);
    let length = RULER * POINTS;
    let ticks = [0.0, 10.0, 20.0, 30.0, 40.0, RULER].map(|at| {
        let high = if at % RULER == 0.0 { 7.0 } else { 4.0 };
        Mark::Line { at: [left + at * POINTS, low], along: [0.0, high] }
    });
    let hash = plan.input.sha256.get(..16).unwrap_or(&plan.input.sha256);
    let ruler = format!("{RULER:.0} mm, if this sheet is printed in its own size (100 %)");
    let about = format!("{}; mesh {hash}…; page {page} of {pages}", plan.program);
    let mut marks = vec![
        Mark::Line { at: [left, low], along: [length, 0.0] },
        text(left + length + 8.0, low, ruler),
        text(left, low - 14.0, about),
    ];
    marks.extend(ticks);
    marks
}

/// The blocks of the sheet, from its title to its last step.
fn blocks(plan: &PlanReport, casts: &[Cast], title: &str, pictures: usize) -> Vec<Block> {
    let mut blocks =
        vec![Block::Title(title.into(), format!("bench sheet, method {}", plan.method))];
    if pictures > 0 {
        blocks.push(Block::Pictures((0..pictures).collect()));
    }
    let mut warnings: Vec<String> = Vec::new();
    for warning in casts.iter().flat_map(|cast| &cast.sheet.warnings) {
        if !warnings.contains(warning) {
            warnings.push(warning.clone());
        }
    }
    blocks.extend(warnings.iter().map(|warning| Block::Text(plain(warning), true)));
    blocks.push(Block::Heading("Pour".into()));
    blocks.push(pour(plan, casts));
    blocks.extend(times(plan, casts).map(|text| Block::Text(text, false)));
    blocks.push(Block::Heading("Print".into()));
    blocks.push(print(casts));
    blocks.push(Block::Heading("Have ready".into()));
    blocks.push(Block::Text(ready(casts.iter().flat_map(|cast| &cast.sheet.materials)), false));
    for cast in casts {
        let of = if casts.len() > 1 { format!("Cast the {}", cast.name) } else { "Do".into() };
        blocks.push(Block::Heading(of));
        blocks.push(Block::Steps(cast.sheet.steps.iter().map(|step| plain(step)).collect()));
    }
    if casts.len() > 1 {
        blocks.push(Block::Heading("Put it together".into()));
        let steps = sheet::steps_of_whole(plan, casts.iter().map(|c| (&c.report, &c.sheet)));
        blocks.push(Block::Steps(steps.iter().map(|step| plain(step)).collect()));
    }
    blocks
}

/// Volumes and masses of each casting.
fn pour(plan: &PlanReport, casts: &[Cast]) -> Block {
    let head = vec!["casting", "of", "mix", "mass", "part A", "part B"];
    let grams = |mass: Option<f64>| mass.map_or("–".into(), |mass| format!("{mass:.1} g"));
    let row = |cast: &Cast| {
        let pour = cast.sheet.silicone.as_ref();
        let wax = plan.molds.iter().any(|m| m.name == cast.name && m.casts == Material::Wax);
        let of = match pour {
            _ if wax => "wax".into(),
            Some(pour) => pour.name.clone(),
            None => "silicone".into(),
        };
        vec![
            cast.name.clone(),
            of,
            format!("{:.1} mL", cast.sheet.mix_ml),
            grams(pour.and_then(|p| p.mass_g)),
            grams(pour.and_then(|p| p.parts_g).map(|[a, _]| a)),
            grams(pour.and_then(|p| p.parts_g).map(|[_, b]| b)),
        ]
    };
    Block::Table(head, casts.iter().map(row).collect())
}

/// Pot life, time in the mold, and what the finished body weighs.
fn times(plan: &PlanReport, casts: &[Cast]) -> Option<String> {
    let pour = casts.iter().find_map(|cast| cast.sheet.silicone.as_ref());
    let pot = pour.and_then(|p| p.pot_life_min).map(|t| format!("Pour within {t} min of mixing."));
    let cure = pour.and_then(|p| p.cure_h).map(|t| format!("Demold after {t} h at 23 °C."));
    let weight = plan.weight.as_ref();
    let weight = weight.map(|w| format!("The finished body weighs {}.", w.in_words()));
    let all: Vec<String> = [pot, cure, weight].into_iter().flatten().collect();
    (!all.is_empty()).then(|| all.join(" "))
}

/// What to print.
fn print(casts: &[Cast]) -> Block {
    let head = vec!["part", "file", "volume", "solid", "supports"];
    let mut rows = Vec::new();
    for Cast { name, sheet, .. } in casts {
        for part in &sheet.printed {
            let of =
                if casts.len() > 1 { format!("{name}: {}", part.name) } else { part.name.clone() };
            let supports = if part.supports { "yes" } else { "no" };
            rows.push(vec![
                of,
                part.file.clone(),
                format!("{:.1} mL", part.volume_ml),
                format!("{:.0} g", part.mass_g),
                supports.into(),
            ]);
        }
    }
    Block::Table(head, rows)
}

/// What to have, of all molds: what is used up is added, what is used again is had once.
fn ready<'a>(items: impl Iterator<Item = &'a Item>) -> String {
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
    let each = all.iter().map(|Item { count, what }| match what.chars().next() {
        Some(first) if first.is_ascii_digit() && *count == 1 => plain(what),
        _ => plain(&format!("{count} × {what}")),
    });
    each.collect::<Vec<_>>().join("; ") + "."
}

/// The number with which a text begins, if there is one, and the rest.
fn amount(text: &str) -> (Option<f64>, &str) {
    let (number, rest) = text.split_at(text.find(' ').unwrap_or(0));
    number.parse().map_or((None, text), |number| (Some(number), rest))
}

/// Text without the marks of Markdown.
fn plain(text: &str) -> String {
    text.replace('`', "")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_used_up_is_added() {
        let item = |count, what: &str| Item { count, what: what.into() };
        let items = [
            item(1, "58 g of PLA, if printed solid"),
            item(1, "18 g of Dragon Skin 20"),
            item(1, "spray of `release` agent"),
            item(4, "bolt M3 × 20 mm"),
        ];
        let said = ready(items.iter().chain(&items));
        let all = "116 g of PLA, if printed solid; 36 g of Dragon Skin 20; 1 × spray of release agent; 8 × bolt M3 × 20 mm.";
        assert_eq!(said, all);
    }
}
