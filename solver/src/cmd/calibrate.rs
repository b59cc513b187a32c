//! `solver calibrate`: numbers of scenes from measurements.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use anyhow::Result;
use program::{Changes, FolderLock, Unusable};
use scene::law_table;
use serde::Serialize;
use serde_json::{Value, json};

use crate::plot::{Axes, Series, Style, draw};
use crate::study::calibration::{Calibration, Experiment, Point, Sought};
use crate::study::least_squares::{Minimum, minimise};

/// Find numbers of your scenes from measurements on your own device
///
/// CONFIG names scenes, what was measured of them with standard uncertainties (tables or values of their probes, the
/// mass, gauges of walls), and the numbers that are sought: factors on modulus, density and sheets, an offset of
/// pressures, or any number of the scene by its path, such as where a wall is. Writes to the output folder
/// calibration.json, with standard errors, correlations and what each experiment tells; residuals.svg; numbers.toml, to be
/// included by the scene; and, where the material was sought, material.toml, to be included by any scene.
#[derive(clap::Args)]
pub struct Arguments {
    /// What is sought, and from what (TOML)
    config: PathBuf,
    /// Folder for the results; made if missing
    #[arg(short, long)]
    output: PathBuf,
    #[command(flatten)]
    changes: Changes,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let calibration = Calibration::read_with(&arguments.config, &arguments.changes)?;
    let start: Vec<f64> = calibration.start.iter().map(|(_, value)| *value).collect();
    let names: Vec<String> = calibration.numbers.iter().map(Sought::title).collect();
    let found = minimise(&names, &start, |values| calibration.residuals(values))?;
    let found = found.map_err(|failure| {
        let why = failure.in_words(&names, calibration.measurements().len());
        Unusable(format!("{}: {why}", arguments.config.display()))
    })?;
    let folder = &arguments.output;
    let _lock = FolderLock::new(folder)?;
    let text = table(&calibration, &found)?;
    write!(program::stdout(), "{text}")?;
    program::write_json(&folder.join("calibration.json"), &report(&calibration, &found))?;
    picture(&calibration, &found, &folder.join("residuals.svg"))?;
    let numbers = BTreeMap::from([("numbers", calibration.found(&found.numbers))]);
    let numbers = toml::to_string(&numbers)?;
    mesh::io::write_atomic(&folder.join("numbers.toml"), |out| out.write_all(numbers.as_bytes()))?;
    let path = folder.join("material.toml");
    if calibration.numbers.iter().any(Sought::is_of_material) {
        let material = material(&calibration, &found, &text)?;
        mesh::io::write_atomic(&path, |out| out.write_all(material.as_bytes()))?;
    } else {
        // one of an earlier run must not remain beside a calibration of something else
        mesh::io::remove_output(&path)?;
    }
    Ok(())
}

/// The part of what is known of each number that each experiment tells, all others known.
fn shares<'a>(
    calibration: &'a Calibration,
    found: &Minimum,
    k: usize,
) -> impl Iterator<Item = (&'a str, f64)> {
    let column = found.residuals.jacobian.column(k).into_owned();
    calibration.experiments.iter().map(move |e| {
        let share = column.rows(e.first, e.points.len()).norm_squared() / column.norm_squared();
        (e.config.name.as_str(), share)
    })
}

/// The numbers in lines of text.
fn table(calibration: &Calibration, found: &Minimum) -> Result<String> {
    let mut text = String::new();
    let over = found.degrees_of_freedom();
    let chi2 = found.residuals.sum();
    writeln!(
        text,
        "measurements: {}, numbers: {}, iterations: {}, χ² {chi2:.3} for {over} degrees of freedom",
        found.residuals.r.len(),
        found.numbers.len(),
        found.iterations
    )?;
    if over > 0 && chi2 > 4.0 * over as f64 {
        writeln!(
            text,
            "the measurements are {:.1} standard uncertainties (rms) off the model: it lacks \
             something, or they are less certain than stated; look at residuals.svg",
            (chi2 / over as f64).sqrt()
        )?;
    }
    for (k, number) in calibration.numbers.iter().enumerate() {
        let (unit, start) = calibration.start[k];
        let shares = shares(calibration, found, k);
        let shares: Vec<_> =
            shares.map(|(name, share)| format!("{name} {:.0} %", 100.0 * share)).collect();
        writeln!(
            text,
            "{} ({}): {:.6} ± {:.2e}{}, was {start}; from {}",
            number.title(),
            number.meaning(),
            found.numbers[k],
            found.standard_error(k),
            if unit == "1" { String::new() } else { format!(" {unit}") },
            shares.join(", ")
        )?;
    }
    for i in 0..found.numbers.len() {
        for j in 0..i {
            let c = correlation(found, i, j);
            if c.abs() > 0.9 {
                let [a, b] = [i, j].map(|k| calibration.numbers[k].title());
                writeln!(text, "{b} and {a} are hardly told apart: correlation {c:+.3}")?;
            }
        }
    }
    Ok(text)
}

fn correlation(found: &Minimum, i: usize, j: usize) -> f64 {
    found.covariance[(i, j)] / (found.standard_error(i) * found.standard_error(j))
}

/// Measured and simulated points of an experiment, in the units of its column.
fn points(e: &Experiment, found: &Minimum) -> Value {
    let one = |(i, point): (usize, &Point)| {
        let simulated = |r: f64| point.measured / e.unit.1 + r * e.config.uncertainty;
        let r = found.residuals.r[i];
        json!({
            "t": point.t,
            "measured": point.measured / e.unit.1,
            "before": simulated(found.before[i]),
            "after": simulated(r),
            "residual": r,
        })
    };
    json!({
        "name": e.config.name,
        "probe": e.config.probe,
        "columns": e.config.columns,
        "uncertainty": e.config.uncertainty,
        "points": (e.first..).zip(&e.points).map(one).collect::<Vec<_>>(),
    })
}

fn report(calibration: &Calibration, found: &Minimum) -> Value {
    let one = |k: usize| {
        let number = &calibration.numbers[k];
        json!({
            "name": number.title(),
            "meaning": number.meaning(),
            "unit": calibration.start[k].0,
            "start": calibration.start[k].1,
            "value": found.numbers[k],
            "standard_error": found.standard_error(k),
            "shares": shares(calibration, found, k).collect::<BTreeMap<_, _>>(),
        })
    };
    let count = found.numbers.len();
    let row = |i: usize| (0..count).map(|j| correlation(found, i, j)).collect::<Vec<f64>>();
    let experiments = calibration.experiments.iter().map(|e| points(e, found));
    json!({
        "program": scene::PROGRAM,
        "set": calibration.set,
        "numbers": (0..count).map(one).collect::<Vec<_>>(),
        "correlations": (0..count).map(row).collect::<Vec<_>>(),
        "chi2": found.residuals.sum(),
        "degrees_of_freedom": found.degrees_of_freedom(),
        "iterations": found.iterations,
        "experiments": experiments.collect::<Vec<_>>(),
    })
}

/// Residuals over their standard uncertainties, experiment by experiment.
fn picture(calibration: &Calibration, found: &Minimum, path: &Path) -> Result<()> {
    let of = |(turn, e): (usize, &Experiment)| {
        let residuals = found.residuals.r.as_slice()[e.first..].iter().copied();
        let points = e.points.iter().map(|p| p.t).zip(residuals).collect();
        Series { label: Some(e.config.name.clone()), points, style: Style::Dotted(1), turn }
    };
    let series: Vec<Series> = calibration.experiments.iter().enumerate().map(of).collect();
    let y = "(simulated − measured) / standard uncertainty".to_owned();
    draw(path, &Axes { x: "t".to_owned(), y, ..Axes::default() }, &series)
}

/// The tables [material] of the scenes' bodies, and those of relaxation, softening and sheets, with
/// what was found.
fn material(calibration: &Calibration, found: &Minimum, provenance: &str) -> Result<String> {
    let scene = calibration.material(&found.numbers)?;
    let mut text = String::from("# From solver calibrate:\n");
    provenance.lines().try_for_each(|line| writeln!(text, "# {line}"))?;
    for experiment in &calibration.experiments {
        let own = &experiment.config;
        let table = own.measured.as_ref().map(|file| (own.columns.join(", "), file.display()));
        let table = table.map(|(columns, file)| format!(": {columns} of {file}"));
        let probe = own.probe.as_ref().map(|probe| format!(", probe {probe}"));
        let (table, probe) = (table.unwrap_or_default(), probe.unwrap_or_default());
        writeln!(text, "# {}{table}{probe}", own.name)?;
    }
    for law in &scene.laws {
        if scene.parts.len() > 1 {
            writeln!(text, "# body \"{}\"", scene.parts[law.part].config.name)?;
        }
        let material = &law.material;
        let modes: Vec<&str> = material.modes.iter().map(|mode| mode.state()).collect();
        let known: [(&str, Option<toml::Value>); 8] = [
            ("on", law.volume.clone().map(Into::into)),
            ("kind", Some(material.law.key.into())),
            ("density", material.density.map(Into::into)),
            ("stretch_range", material.stretch_range.map(|range| range.to_vec().into())),
            ("modes", (!modes.is_empty()).then(|| modes.into())),
            ("stretch_at_break", material.stretch_at_break.map(Into::into)),
            ("creep", material.softening.creep.map(Into::into)),
            ("mullins", material.softening.mullins.map(Into::into)),
        ];
        let known = known.into_iter().filter_map(|(key, value)| Some((key.to_owned(), value?)));
        let mut keys: toml::Table = known.collect();
        keys.extend(law_table::written(material.law, &material.values));
        let title = if law.volume.is_some() { "[[material]]" } else { "[material]" };
        writeln!(text, "{title}\n{keys}")?;
    }
    let config = &scene.config;
    let lists = [
        list("relaxation", &config.relaxation)?,
        list("mullins", &config.mullins)?,
        list("membrane", &config.membrane)?,
    ];
    Ok(text + &lists.into_iter().flatten().collect::<Vec<_>>().join("\n"))
}

/// The tables of a list, if it has any.
fn list<T: Serialize>(name: &str, tables: &[T]) -> Result<Option<String>> {
    let some = (!tables.is_empty()).then(|| toml::to_string(&BTreeMap::from([(name, tables)])));
    Ok(some.transpose()?)
}
