//! `solver calibrate`: numbers of scenes from measurements.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use anyhow::Result;
use mechanics::math::least_squares::Residuals;
use program::{Changes, FolderLock, Unusable};
use scene::SceneMembrane;
use scene::config::MembraneConfig;
use scene::law_table;
use serde_json::{Value, json};

use crate::plot::{Axes, Series, Style, draw};
use crate::study::calibration::least_squares::{Failure, Minimum, minimise};
use crate::study::calibration::{Calibration, Experiment, Point, Sought};

/// Find numbers of your scenes from measurements on your own device
///
/// CONFIG names scenes, measured tables of their probes with standard uncertainties, and the
/// numbers that are sought: factors on modulus and density, offsets of pressures and walls,
/// parameters of a law, or any number of the scene by its path. Writes to the output folder calibration.json, with standard errors,
/// correlations and what each experiment tells; residuals.svg; and, where the material was
/// sought, material.toml, to be included by a scene.
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
    let mut before = Vec::new();
    let observe = |iteration: usize, values: &[f64], residuals: &Residuals| {
        if iteration == 0 {
            before = residuals.r.as_slice().to_vec();
        }
        let named = calibration.numbers.iter().zip(values);
        let named: Vec<_> = named.map(|(n, v)| format!("{} {v:.5e}", n.title())).collect();
        log::info!("iteration {iteration}  χ² {:.4e}  {}", residuals.sum(), named.join("  "));
    };
    let found = minimise(&start, |values| calibration.residuals(values), observe)?;
    let found = found.map_err(|failure| {
        Unusable(format!("{}: {}", arguments.config.display(), why(&calibration, &failure)))
    })?;
    let points = points(&calibration, &found, &before);
    let folder = &arguments.output;
    let _lock = FolderLock::new(folder)?;
    let text = table(&calibration, &found)?;
    write!(std::io::stdout().lock(), "{text}")?;
    let report = report(&calibration, &found, &points);
    program::write_json(&folder.join("calibration.json"), &report)?;
    picture(&calibration, &found, &folder.join("residuals.svg"))?;
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

fn why(calibration: &Calibration, failure: &Failure) -> String {
    match failure {
        Failure::Start => {
            "a scene has no equilibrium with its numbers as they are; mend it first by solver \
             simulate"
                .to_owned()
        }
        Failure::Undetermined(numbers) => {
            let names: Vec<_> = numbers.iter().map(|&k| calibration.numbers[k].title()).collect();
            let count: usize = calibration.experiments.iter().map(|e| e.points.len()).sum();
            format!(
                "{count} measurements do not determine {}: changes of {} leave all of them as \
                 they are; measure something that tells them apart, or seek fewer",
                names.join(" and "),
                if names.len() > 1 { "these numbers together" } else { "this number" }
            )
        }
        Failure::Unsettled(_) => format!("{failure}"),
    }
}

fn standard_error(found: &Minimum, k: usize) -> f64 {
    found.covariance[(k, k)].sqrt()
}

/// Each experiment with the index of its first residual.
fn experiments(calibration: &Calibration) -> impl Iterator<Item = (&Experiment, usize)> {
    calibration.experiments.iter().scan(0, |next, e| {
        let first = *next;
        *next += e.points.len();
        Some((e, first))
    })
}

/// The part of what is known of each number that each experiment tells, all others known.
fn shares(calibration: &Calibration, found: &Minimum, k: usize) -> Vec<f64> {
    let column = found.residuals.jacobian.column(k);
    let of = |(e, first): (&Experiment, usize)| {
        column.rows(first, e.points.len()).norm_squared() / column.norm_squared()
    };
    experiments(calibration).map(of).collect()
}

fn degrees_of_freedom(found: &Minimum) -> usize {
    found.residuals.r.len().saturating_sub(found.numbers.len())
}

/// The numbers in lines of text.
fn table(calibration: &Calibration, found: &Minimum) -> Result<String> {
    let mut text = String::new();
    let over = degrees_of_freedom(found);
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
        let shares = shares(calibration, found, k).into_iter().zip(&calibration.experiments);
        let shares: Vec<_> =
            shares.map(|(s, e)| format!("{} {:.0} %", e.config.name, 100.0 * s)).collect();
        writeln!(
            text,
            "{} ({}): {:.6} ± {:.2e}{}, was {start}; from {}",
            number.title(),
            number.meaning(),
            found.numbers[k],
            standard_error(found, k),
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
    found.covariance[(i, j)] / (standard_error(found, i) * standard_error(found, j))
}

/// Measured and simulated points of each experiment, in the units of its column.
fn points(calibration: &Calibration, found: &Minimum, before: &[f64]) -> Vec<Value> {
    let of = |(e, first): (&Experiment, usize)| {
        let one = |(i, point): (usize, &Point)| {
            let simulated = |r: f64| point.measured / e.unit.1 + r * e.config.uncertainty;
            let r = found.residuals.r[i];
            json!({
                "t": point.t,
                "measured": point.measured / e.unit.1,
                "before": simulated(before[i]),
                "after": simulated(r),
                "residual": r,
            })
        };
        json!({
            "name": e.config.name,
            "probe": e.config.probe,
            "columns": e.config.columns,
            "uncertainty": e.config.uncertainty,
            "points": (first..).zip(&e.points).map(one).collect::<Vec<_>>(),
        })
    };
    experiments(calibration).map(of).collect()
}

fn report(calibration: &Calibration, found: &Minimum, points: &[Value]) -> Value {
    let one = |k: usize| {
        let number = &calibration.numbers[k];
        let names = calibration.experiments.iter().map(|e| e.config.name.clone());
        let shares: serde_json::Map<_, _> =
            names.zip(shares(calibration, found, k).into_iter().map(Value::from)).collect();
        json!({
            "name": number.title(),
            "meaning": number.meaning(),
            "unit": calibration.start[k].0,
            "start": calibration.start[k].1,
            "value": found.numbers[k],
            "standard_error": standard_error(found, k),
            "shares": shares,
        })
    };
    let count = found.numbers.len();
    let row = |i: usize| (0..count).map(|j| correlation(found, i, j)).collect::<Vec<f64>>();
    json!({
        "program": scene::PROGRAM,
        "set": calibration.set,
        "numbers": (0..count).map(one).collect::<Vec<_>>(),
        "correlations": (0..count).map(row).collect::<Vec<_>>(),
        "chi2": found.residuals.sum(),
        "degrees_of_freedom": degrees_of_freedom(found),
        "iterations": found.iterations,
        "experiments": points,
    })
}

/// Residuals over their standard uncertainties, experiment by experiment.
fn picture(calibration: &Calibration, found: &Minimum, path: &Path) -> Result<()> {
    let of = |(turn, (e, first)): (usize, (&Experiment, usize))| {
        let residuals = found.residuals.r.as_slice()[first..].iter().copied();
        let points = e.points.iter().map(|p| p.t).zip(residuals).collect();
        Series { label: Some(e.config.name.clone()), points, style: Style::Dotted(1), turn }
    };
    let series: Vec<Series> = experiments(calibration).enumerate().map(of).collect();
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
        let (columns, file) = (own.columns.join(", "), own.measured.display());
        writeln!(text, "# {}: {columns} of {file}, probe {}", own.name, own.probe)?;
    }
    for law in &scene.laws {
        if scene.parts.len() > 1 {
            writeln!(text, "# body \"{}\"", scene.parts[law.part].config.name)?;
        }
        let material = &law.material;
        let mut keys = toml::Table::new();
        if let Some(volume) = &law.volume {
            keys.insert("on".to_owned(), volume.clone().into());
        }
        keys.insert("kind".to_owned(), material.law.key.into());
        keys.extend(law_table::written(material.law, &material.values));
        if let Some(density) = material.density {
            keys.insert("density".to_owned(), density.into());
        }
        if let Some(range) = material.stretch_range {
            keys.insert("stretch_range".to_owned(), range.to_vec().into());
        }
        if !material.modes.is_empty() {
            let modes: Vec<&str> = material.modes.iter().map(|mode| mode.state()).collect();
            keys.insert("modes".to_owned(), modes.into());
        }
        if let Some(stretch) = material.stretch_at_break {
            keys.insert("stretch_at_break".to_owned(), stretch.into());
        }
        for (key, part) in
            [("creep", material.softening.creep), ("mullins", material.softening.mullins)]
        {
            keys.extend(part.map(|part| (key.to_owned(), part.into())));
        }
        let title = if law.volume.is_some() { "[[material]]" } else { "[material]" };
        writeln!(text, "{title}\n{keys}")?;
    }
    let mut lists = Vec::new();
    let (relaxation, mullins) = (&scene.config.relaxation, &scene.config.mullins);
    if !relaxation.is_empty() {
        lists.push(toml::to_string(&BTreeMap::from([("relaxation", relaxation)]))?);
    }
    if !mullins.is_empty() {
        lists.push(toml::to_string(&BTreeMap::from([("mullins", mullins)]))?);
    }
    let as_found = |membrane: &SceneMembrane| MembraneConfig {
        thickness: membrane.thickness,
        ..membrane.config.clone()
    };
    let membranes: Vec<MembraneConfig> = scene.membranes.iter().map(as_found).collect();
    if !membranes.is_empty() {
        lists.push(toml::to_string(&BTreeMap::from([("membrane", membranes)]))?);
    }
    Ok(text + &lists.join("\n"))
}
