//! Tensile tests as tables of text.
//!
//! A header names the columns and their units, as in `strain [%], stress [kPa]`;
//! others are ignored. `stretch` is deformed over rest length, `strain` is
//! stretch − 1, and `stress` is nominal: force over rest area. Columns are
//! separated by commas, tabs, or semicolons (then numbers may have decimal
//! commas) or commas with numbers in quotes. Lines that start with # are comments. As testing
//! machines write them, lines may come before the header, units may be in brackets on the line
//! below it, and true stress and strain may stand beside the nominal ones.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use csv::StringRecord;
use mechanics::material::response::Mode;

use crate::units;

/// Fewest points away from rest that make a test.
const FEWEST: usize = 5;

/// A test of homogeneous strain.
#[derive(Clone, Debug)]
pub struct Test {
    /// How it was pulled.
    pub mode: Mode,
    /// The file it came from.
    pub path: PathBuf,
    /// Stretch along the pull [1] and nominal stress [Pa].
    pub points: Vec<(f64, f64)>,
}

/// Units that the header does not give.
#[derive(Clone, Debug, Default)]
pub struct Units {
    /// Unit of strain: 1 or %.
    pub strain: Option<String>,
    /// Unit of stress: Pa, kPa, MPa, N/mm2 or psi.
    pub stress: Option<String>,
}

/// Columns and factors to SI.
struct Layout {
    /// Column of the stretch or strain, its factor, and 1 for strain.
    stretch: (usize, f64, f64),
    stress: (usize, f64),
}

/// Reads a test, as far as `up_to`.
pub fn read(path: &Path, mode: Mode, units: &Units, up_to: Option<f64>) -> Result<Test> {
    let text = mesh::io::read_text(path)?;
    let points = parse(&text, units, up_to).with_context(|| path.display().to_string())?;
    Ok(Test { mode, path: path.to_path_buf(), points })
}

fn parse(text: &str, units: &Units, up_to: Option<f64>) -> Result<Vec<(f64, f64)>> {
    let lines = lines(text.trim_start_matches('\u{feff}'))?;
    let header = header(&lines).context("empty; expected a header and a line per point")?;
    let below = lines.get(header + 1).filter(|line| are_units(line));
    let layout = layout(&lines[header], below, units)?;
    let mut points = Vec::new();
    for line in &lines[header + 1 + usize::from(below.is_some())..] {
        if line.iter().all(str::is_empty) {
            continue;
        }
        let number = line.position().map_or(0, csv::Position::line);
        let point = layout.point(line).with_context(|| format!("line {number}"))?;
        if up_to.is_none_or(|end| point.0 <= end) {
            points.push(point);
        }
    }
    check(&points)?;
    Ok(points)
}

/// All lines that have cells, which are parted as in the first one that names a stress, or else the first.
fn lines(text: &str) -> csv::Result<Vec<StringRecord>> {
    let mut texts = text.lines().filter(|line| !line.trim().is_empty() && !line.starts_with('#'));
    let titles = texts.clone().find(|line| line.to_lowercase().contains("stress"));
    let titles = titles.or_else(|| texts.next()).unwrap_or_default();
    let others = [b';', b'\t'].into_iter().find(|d| titles.as_bytes().contains(d));
    let mut reader = csv::ReaderBuilder::new()
        .delimiter(others.unwrap_or(b','))
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .has_headers(false)
        .flexible(true)
        .from_reader(text.as_bytes());
    reader.records().collect()
}

/// The line that names columns of stress and of strain or stretch; of several, as where a table of
/// results comes first, the one with the most lines up to the next. Without any, the first line.
fn header(lines: &[StringRecord]) -> Option<usize> {
    let names_both = |line: &StringRecord| {
        let at = |words: &[&str]| {
            line.iter().position(|cell| words.iter().any(|w| cell.to_lowercase().contains(w)))
        };
        let (stress, strain) = (at(&["stress"]), at(&["strain", "stretch"]));
        stress.is_some() && strain.is_some() && stress != strain
    };
    let candidates: Vec<usize> = (0..lines.len()).filter(|&i| names_both(&lines[i])).collect();
    let ends = candidates.iter().skip(1).copied().chain([lines.len()]);
    let longest = candidates.iter().zip(ends).max_by_key(|&(&i, end)| (end - i, usize::MAX - i));
    longest.map(|(&i, _)| i).or_else(|| (!lines.is_empty()).then_some(0))
}

/// Whether cells below a header are units in brackets, as testing machines write them.
fn are_units(cells: &StringRecord) -> bool {
    let ends = |cell: &str| (cell.chars().next(), cell.chars().next_back());
    let bracketed = |cell| matches!(ends(cell), (Some('('), Some(')')) | (Some('['), Some(']')));
    let mut filled = cells.iter().filter(|cell| !cell.is_empty()).peekable();
    filled.peek().is_some() && filled.all(bracketed)
}

/// A column's name in lower case and the unit in its brackets.
fn split(title: &str) -> (String, Option<String>) {
    let cut = title.find(['[', '(']);
    let name = cut.map_or(title, |at| &title[..at]);
    let unit = cut.map(|at| title[at + 1..].trim_end_matches([']', ')', ' ']).trim().to_owned());
    (name.trim().to_lowercase(), unit)
}

fn layout(header: &StringRecord, below: Option<&StringRecord>, units: &Units) -> Result<Layout> {
    let mut titles: Vec<_> = header.iter().map(split).collect();
    for (title, cell) in titles.iter_mut().zip(below.into_iter().flatten()) {
        title.1 = split(cell).1;
    }
    let is_true = |i: usize| ["true", "cauchy"].iter().any(|word| titles[i].0.contains(word));
    let find = |word: &str| -> Result<Option<usize>> {
        let mut found: Vec<_> = (0..titles.len()).filter(|&i| titles[i].0.contains(word)).collect();
        // beside true stress and strain there are those of the engineer
        if found.iter().any(|&i| !is_true(i)) {
            found.retain(|&i| !is_true(i));
        }
        ensure!(
            found.len() < 2,
            "columns {} all are named {word}; keep one",
            found.iter().map(|i| (i + 1).to_string()).collect::<Vec<_>>().join(", ")
        );
        Ok(found.first().copied())
    };
    let shown = header.iter().collect::<Vec<_>>().join(" | ");
    let stress = find("stress")?.with_context(|| {
        format!("no column named stress in the header: {shown}\n  as in: strain [%], stress [kPa]")
    })?;
    ensure!(
        !is_true(stress),
        "column {} is \"{}\": expected nominal stress, force over rest area",
        stress + 1,
        &header[stress]
    );
    let pascals = ("Pa", "kPa");
    let unit = factor("stress", pascals, titles[stress].1.as_ref(), units.stress.as_ref())?;
    let stress = (stress, unit);
    if let Some(stretch) = find("stretch")? {
        let unit = titles[stretch].1.as_deref();
        let plain = unit.is_none_or(|u| ["1", "-", "", "mm/mm", "m/m"].contains(&u));
        ensure!(plain, "stretch in {unit:?}: it is a ratio of lengths, with unit [1]");
        return Ok(Layout { stretch: (stretch, 1.0, 0.0), stress });
    }
    let strain = find("strain")?.with_context(|| {
        format!(
            "no column named stretch or strain in the header: {shown}\n  as in: strain [%], \
             stress [kPa]"
        )
    })?;
    ensure!(
        !is_true(strain),
        "column {} is \"{}\": expected the change of length over the rest length",
        strain + 1,
        &header[strain]
    );
    let unit = factor("strain", ("1", "%"), titles[strain].1.as_ref(), units.strain.as_ref())?;
    Ok(Layout { stretch: (strain, unit, 1.0), stress })
}

/// The factor to SI of the unit in the header or the one given apart, which must not differ.
fn factor(
    name: &str,
    (si, example): (&str, &str),
    header: Option<&String>,
    apart: Option<&String>,
) -> Result<f64> {
    if let (Some(header), Some(apart)) = (header, apart) {
        ensure!(
            header == apart,
            "the header gives {name} in \"{header}\", but --{name}-unit is \"{apart}\""
        );
    }
    let unit = header.or(apart).with_context(|| {
        format!("no unit of {name}: write it in the header, as in {name} [{example}], or give --{name}-unit {example}")
    })?;
    units::factor(unit, si).with_context(|| format!("{name} in \"{unit}\""))
}

impl Layout {
    fn point(&self, cells: &StringRecord) -> Result<(f64, f64)> {
        let (column, factor, offset) = self.stretch;
        let stretch = offset + factor * number(cells, column)?;
        ensure!(stretch > 0.0, "stretch {stretch}: must be positive (is the unit right?)");
        Ok((stretch, self.stress.1 * number(cells, self.stress.0)?))
    }
}

fn number(cells: &StringRecord, column: usize) -> Result<f64> {
    let text = cells
        .get(column)
        .with_context(|| format!("{} columns; expected column {}", cells.len(), column + 1))?;
    // a cell has a comma where that does not part columns, or in quotes
    let plain = text.replace(',', ".");
    let number = plain.parse::<f64>().ok().filter(|n| n.is_finite());
    number.with_context(|| format!("column {}: \"{text}\" is not a number", column + 1))
}

/// Refuses what cannot be a test of a rubber; warns of what may not be.
fn check(points: &[(f64, f64)]) -> Result<()> {
    let away = points.iter().filter(|p| (p.0 - 1.0).abs() > 1e-3).count();
    ensure!(
        away >= FEWEST,
        "{} points, {away} of them strained by more than 0.001; expected at least {FEWEST}",
        points.len()
    );
    let against: Vec<_> = points.iter().filter(|p| p.1 * (p.0 - 1.0) < 0.0).collect();
    ensure!(
        2 * against.len() < points.len(),
        "{} of {} points have stress against their strain, as {:.4e} Pa at stretch {:.4}: tension \
         is positive",
        against.len(),
        points.len(),
        against[0].1,
        against[0].0
    );
    let highest = points.iter().fold((1.0, 0.0), |m, p| if p.1 > m.1 { *p } else { m });
    if let Some(last) = points.last().filter(|p| p.0 > 1.0 && p.1 < 0.8 * highest.1) {
        log::warn!(
            "stress falls from {:.4e} Pa at stretch {:.3} to {:.4e} Pa at the end: if the specimen \
             broke or was unloaded, cut the data with --up-to {:.3}",
            highest.1,
            highest.0,
            last.1,
            highest.0
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(header: &str, line: impl Fn(f64) -> String) -> String {
        let lines: Vec<_> = (0..=6).map(|i| line(0.1 * f64::from(i))).collect();
        format!("{header}\n{}\n", lines.join("\n"))
    }

    fn points(text: &str) -> Vec<(f64, f64)> {
        parse(text, &Units::default(), None).expect("readable")
    }

    #[test]
    fn columns_and_units_come_from_the_header() {
        let si = points(&table("stretch,stress [Pa]", |e| format!("{},{}", 1.0 + e, 1e4 * e)));
        assert!((si[6].0 - 1.6).abs() < 1e-15 && (si[6].1 - 6e3).abs() < 1e-9);
        for other in [
            table("time [s], Stress (MPa), Strain (%)", |e| {
                format!("0,{},{}", 0.01 * e, 100.0 * e)
            }),
            table("\u{feff}strain [1]\tstress [N/mm2]", |e| format!("{e}\t{}", 0.01 * e)),
            table("# made by hand\nstrain [%];nominal stress [kPa]", |e| {
                format!("{};{}", 100.0 * e, 10.0 * e).replace('.', ",")
            }),
        ] {
            for (a, b) in points(&other).iter().zip(&si) {
                assert!((a.0 - b.0).abs() < 1e-12 && (a.1 - b.1).abs() < 1e-6, "{other}");
            }
        }
        let psi = points(&table("strain [1],stress [psi]", |e| format!("{e},{e}")));
        assert!((psi[6].1 / (0.6 * 6894.757293) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn files_of_machines_are_read_as_they_come() {
        let strains: Vec<f64> = (0..=6).map(|i| 0.1 * f64::from(i)).collect();
        let rows = |line: &dyn Fn(f64) -> String| -> String {
            strains.iter().map(|&e| line(e) + "\n").collect()
        };
        // as in the database of Marechal et al. 2021: what was tested, then true and nominal values
        let database =
            "PARAMETER;INFO;;;\nSpecimen Length (mm);33;;;\nStrain Measurement;Global;;;\n\
                        Machine;Instron  5569;;;\n;;;;\n\
                        Time (s);True Strain;True Stress (MPa);Engineering Strain;\
                        Engineering Stress (MPa)\n"
                .to_owned()
                + &rows(&|e| format!("{};{};9;{e};{}", 4.0 * e, (1.0 + e).ln(), 0.01 * e));
        // as Bluehill exports raw data: results, then names, units below them, numbers in quotes
        let bluehill = "\"Results Table 1\"\n\
                        ,\"Tensile stress at Maximum Load (MPa)\",\"Tensile strain at Maximum Load (%)\"\n\
                        1,0.006,60\n\n\"Time\",\"Extension\",\"Load\",\"Tensile strain (Extension)\",\
                        \"Tensile stress\"\n\"(s)\",\"(mm)\",\"(N)\",\"(mm/mm)\",\"(MPa)\"\n"
            .to_owned();
        let point = bluehill.clone()
            + &rows(&|e| format!("\"{e}\",\"{}\",\"1\",\"{e}\",\"{}\"", 33.0 * e, 0.01 * e));
        let quoted = |x: f64| format!("\"{x}\"").replace('.', ",");
        let comma =
            bluehill.clone() + &rows(&|e| [e, 33.0 * e, 1.0, e, 0.01 * e].map(quoted).join(","));
        let german = bluehill.replace(',', ";")
            + &rows(&|e| format!("{e};{};1;{e};{}", 33.0 * e, 0.01 * e).replace('.', ","));
        let ratio = Units { strain: Some("1".into()), stress: None };
        let none = Units::default();
        for (text, units) in [(database, &ratio), (point, &none), (comma, &none), (german, &none)] {
            let points = parse(&text, units, None).expect("readable");
            assert_eq!(points.len(), 7, "{text}");
            for (point, e) in points.iter().zip(&strains) {
                assert!((point.0 - 1.0 - e).abs() < 1e-12 && (point.1 - 1e4 * e).abs() < 1e-6);
            }
        }
        let text = "by hand\n\nstrain [%],stress [kPa]\n1,2\n2,oops\n";
        let message = format!("{:#}", parse(text, &none, None).expect_err("no number"));
        assert!(message.contains("line 5: column 2: \"oops\""), "{message}");
    }

    #[test]
    fn data_end_at_the_given_stretch() {
        let text = table("strain [1],stress [kPa]", |e| format!("{e},{e}"));
        assert_eq!(parse(&text, &Units::default(), Some(1.55)).expect("six points").len(), 6);
    }

    #[test]
    fn units_may_be_given_apart() {
        let text = table("strain,stress", |e| format!("{},{e}", 100.0 * e));
        let units = Units { strain: Some("%".into()), stress: Some("kPa".into()) };
        let last = *parse(&text, &units, None).expect("readable").last().expect("seven points");
        assert!((last.0 - 1.6).abs() < 1e-12 && (last.1 - 600.0).abs() < 1e-9);
        let text = table("strain [1],stress [Pa]", |e| format!("{e},{e}"));
        let message = format!("{:#}", parse(&text, &units, None).expect_err("two units"));
        assert!(message.contains("stress in \"Pa\", but --stress-unit is \"kPa\""), "{message}");
    }

    #[test]
    fn what_is_wrong_is_said_with_the_line() {
        let good = |header: &str| table(header, |e| format!("{},{}", 1.0 + e, e));
        for (text, needed) in [
            (String::new(), "empty"),
            (good("a,b"), "no column named stress in the header: a | b"),
            (good("elongation,stress [kPa]"), "no column named stretch or strain"),
            (good("strain,stress [kPa]"), "--strain-unit"),
            (good("strain [%],stress"), "--stress-unit"),
            (good("strain [inch],stress [kPa]"), "strain in \"inch\""),
            (good("strain [%],stress [bar]"), "stress in \"bar\""),
            (good("stretch [%],stress [kPa]"), "ratio of lengths"),
            (good("stretch,true stress [kPa]"), "nominal stress, force over rest area"),
            (good("stress 1 [kPa],stress 2 [kPa]"), "columns 1, 2"),
            (good("stretch,stress [kPa]") + "1.7,\n", "line 9: column 2: \"\" is not a number"),
            (good("stretch,stress [kPa]") + "1.7,nan\n", "line 9"),
            (good("stretch,stress [kPa]") + "1.7\n", "line 9: 1 columns; expected column 2"),
            (good("stretch,stress [kPa]") + "-1.7,3\n", "stretch -1.7: must be positive"),
            ("stretch,stress [kPa]\n1.5,3\n".into(), "1 points"),
            (table("stretch,stress [kPa]", |e| format!("{},{}", 1.0 + e, -e)), "against"),
        ] {
            let error = parse(&text, &Units::default(), None).expect_err(needed);
            let message = format!("{error:#}");
            assert!(message.contains(needed), "{needed} is not in: {message}");
        }
    }
}
