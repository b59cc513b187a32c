//! `solver fit`: a tensile test to a material.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::PathBuf;

use anyhow::{Result, bail, ensure};
use mechanics::material::BULK_RATIO;
use mechanics::material::response::Mode;
use program::{FolderLock, Unusable};
use scene::law_table;
use serde_json::{Value, json};

use crate::fit::{self, CANDIDATES, Fitted, Spread, Test, Units};

/// R² below which no law describes the data.
const USABLE: f64 = 0.95;

/// Fit material laws to your own tensile test
///
/// DATA is a table with a header such as `strain [%], stress [kPa]`: stretch or
/// strain, and nominal stress (force over rest area). Writes to the output
/// folder material.toml, to be pasted into a scene, fit.svg with data and
/// curves, and fit.json. The material keeps the range of stretch it was fitted
/// to; `solver simulate` warns beyond it.
#[derive(clap::Args)]
pub struct Arguments {
    /// Uniaxial test
    data: PathBuf,
    /// Equibiaxial test of the same silicone
    #[arg(long)]
    biaxial: Option<PathBuf>,
    /// Planar ("pure shear") test of the same silicone
    #[arg(long)]
    planar: Option<PathBuf>,
    /// Folder for the results; made if missing
    #[arg(short, long)]
    output: PathBuf,
    /// Unit of strain, where the header has none: 1 or %
    #[arg(long)]
    strain_unit: Option<String>,
    /// Unit of stress, where the header has none: Pa, kPa, MPa, N/mm2 or psi
    #[arg(long)]
    stress_unit: Option<String>,
    /// Use data up to this stretch: fit the range you will need, not rupture
    #[arg(long)]
    up_to: Option<f64>,
    /// Write this law, not the recommended one
    #[arg(long)]
    law: Option<String>,
    /// Bulk over shear modulus at rest, which a tensile test does not determine
    #[arg(long, default_value_t = BULK_RATIO)]
    bulk_ratio: f64,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let tests = read(arguments)?;
    if let Some(law) = &arguments.law {
        let known: Vec<_> = CANDIDATES.iter().map(|c| c.name).collect();
        ensure!(
            known.contains(&law.as_str()),
            "--law {law}: can be fitted are {}",
            known.join(", ")
        );
    }
    let fits: Vec<Fitted> =
        CANDIDATES.iter().filter_map(|c| fit::fit(c, &tests, arguments.bulk_ratio)).collect();
    let chosen = match &arguments.law {
        Some(law) => fits.iter().find(|f| f.candidate.name == law),
        None => fit::choose(&fits, &tests),
    };
    let Some(chosen) = chosen else {
        return Err(Unusable(format!(
            "{}: no admissible parameters describe the data",
            arguments.data.display()
        ))
        .into());
    };
    let remarks = remarks(&tests, &fits, chosen)?;
    print(&fits, chosen, &remarks)?;
    let folder = &arguments.output;
    let _lock = FolderLock::new(folder)?;
    fit::draw(&folder.join("fit.svg"), &tests, &fits, chosen)?;
    program::write_json(&folder.join("fit.json"), &report(&tests, &fits, chosen)?)?;
    let material = folder.join("material.toml");
    if chosen.quality.r2 < USABLE {
        // one of an earlier run must not remain beside a fit that failed
        mesh::io::remove_output(&material)?;
        return Err(Unusable(format!(
            "{}: the best law has R² {:.4}, expected at least {USABLE}; look at {}",
            arguments.data.display(),
            chosen.quality.r2,
            folder.join("fit.svg").display()
        ))
        .into());
    }
    let text = snippet(&tests, chosen, &remarks)?;
    mesh::io::write_atomic(&material, |out| out.write_all(text.as_bytes()))?;
    Ok(())
}

fn read(arguments: &Arguments) -> Result<Vec<Test>> {
    let units =
        Units { strain: arguments.strain_unit.clone(), stress: arguments.stress_unit.clone() };
    ensure!(
        arguments.bulk_ratio.is_finite() && arguments.bulk_ratio > 2.0 / 3.0,
        "--bulk-ratio {}: must be above 2/3, where Poisson's ratio is 0",
        arguments.bulk_ratio
    );
    if let Some(end) = arguments.up_to {
        ensure!(end.is_finite() && end > 1.0, "--up-to {end}: must be a stretch above 1");
    }
    let files = [
        (Some(&arguments.data), Mode::Uniaxial),
        (arguments.biaxial.as_ref(), Mode::Biaxial),
        (arguments.planar.as_ref(), Mode::Planar),
    ];
    let one = |(path, mode): (Option<&PathBuf>, Mode)| {
        path.map(|path| fit::read(path, mode, &units, arguments.up_to))
    };
    files.into_iter().filter_map(one).collect()
}

/// "4.00", or "all" where nothing turns down.
fn end(stretch: Option<f64>) -> String {
    stretch.map_or("all".to_owned(), |s| format!("{s:.2}"))
}

fn print(fits: &[Fitted], chosen: &Fitted, remarks: &[String]) -> Result<()> {
    let mut out = program::stdout();
    let [low, high] = chosen.quality.fitted;
    writeln!(out, "data: stretch {low:.3} to {high:.3}")?;
    let several = chosen.quality.left_out.is_some();
    writeln!(
        out,
        "law             R²        rms [kPa]  shear [kPa]  {}stable up to stretch (uni, bi, planar)",
        if several { "mode from the others  " } else { "" }
    )?;
    for fit in fits {
        let q = &fit.quality;
        let ends: Vec<_> = q.stable_up_to.iter().map(|(_, e)| end(*e)).collect();
        let error = q.left_out.map_or("none".to_owned(), |part| format!("{:.1} %", 100.0 * part));
        writeln!(
            out,
            "{:14}  {:.6}  {:9.4}  {:11.3}  {}{}{}",
            fit.candidate.name,
            q.r2,
            1e-3 * q.rms,
            1e-3 * q.moduli.shear,
            if several { format!("{error:>20}  ") } else { String::new() },
            ends.join(", "),
            if std::ptr::eq(fit, chosen) { "   <- written" } else { "" }
        )?;
    }
    remarks.iter().try_for_each(|line| Ok(writeln!(out, "{line}")?))
}

fn report(tests: &[Test], fits: &[Fitted], chosen: &Fitted) -> Result<Value> {
    let data = |test: &Test| -> Result<Value> {
        Ok(json!({
            "path": test.path,
            "sha256": program::sha256_file(&test.path)?,
            "mode": test.mode,
            "points": test.points.len(),
        }))
    };
    let one = |fit: &Fitted| {
        json!({
            "name": fit.candidate.name,
            "kind": fit.law().key,
            "parameters": law_table::written(fit.law(), &fit.values),
            "quality": fit.quality,
        })
    };
    Ok(json!({
        "program": scene::PROGRAM,
        "tests": tests.iter().map(data).collect::<Result<Vec<_>>>()?,
        "fits": fits.iter().map(one).collect::<Vec<_>>(),
        "spread": fit::spreads(fits, chosen, tests),
        "written": chosen.candidate.name,
    }))
}

/// What is known of the law, as the file has it above its numbers.
fn remarks(tests: &[Test], fits: &[Fitted], fit: &Fitted) -> Result<Vec<String>> {
    let q = &fit.quality;
    ensure!(
        q.stretch_range[1] > 1.0,
        "{}: its stress falls from the start, so it has no range of use",
        fit.candidate.name
    );
    let fitted = |test: &Test| {
        let (name, count) = (fit.candidate.name, test.points.len());
        let (path, mode) = (test.path.display(), test.mode.name());
        format!("{name}, fitted to {count} points of {path} ({mode})")
    };
    let mut lines: Vec<String> = tests.iter().map(fitted).collect();
    let [low, high] = q.fitted;
    lines.push(format!(
        "R² {:.6}, rms error {:.1} Pa, data at stretch {low:.4} to {high:.4}",
        q.r2, q.rms
    ));
    lines.extend(q.left_out.map(|part| {
        let percent = 100.0 * part;
        format!(
            "Each mode predicted from the others: {percent:.1} % off (root of the mean square)."
        )
    }));
    let ratio = q.moduli.bulk / q.moduli.shear;
    lines.push(format!(
        "The bulk modulus is chosen, not measured ({ratio:.1} times the shear modulus); in this range it"
    ));
    let percent = 100.0 * q.compressibility;
    lines
        .push(format!("changes the uniaxial stress by up to {percent:.2} % of its largest value."));
    if !fit.stable() {
        lines.push("The range ends before the data: beyond it this law is not stable.".to_owned());
    }
    for Spread { mode, stretch, stress, laws } in fit::spreads(fits, fit, tests) {
        let [least, most] = stress.map(|stress| 1e-3 * stress);
        let mut line = format!(
            "Not tested, and the law's guess: {} tension. At stretch {stretch:.3} laws that fit as well say ",
            mode.name()
        );
        line += &match laws[0] == laws[1] {
            true => format!("{least:.4} kPa ({} alone).", laws[0]),
            false => format!("{least:.4} ({}) to {most:.4} kPa ({}).", laws[0], laws[1]),
        };
        lines.push(line);
    }
    Ok(lines)
}

/// Modes of tests as scenes have them: a block that was pulled, and one that was compressed.
fn modes(tests: &[Test]) -> Vec<&'static str> {
    let mut modes = Vec::new();
    for test in tests {
        let is_any = |of: fn(f64) -> bool| test.points.iter().any(|point| of(point.0));
        if test.mode != Mode::Uniaxial {
            modes.push(test.mode.state());
            continue;
        }
        modes.extend(is_any(|stretch| stretch > 1.0).then_some("tension"));
        modes.extend(is_any(|stretch| stretch < 1.0).then_some("compression"));
    }
    modes
}

/// The table [material] of a scene.
fn snippet(tests: &[Test], fit: &Fitted, remarks: &[String]) -> Result<String> {
    let mut text: String = remarks.iter().map(|line| format!("# {line}\n")).collect();
    writeln!(text, "[material]\nkind = \"{}\"", fit.law().key)?;
    for (parameter, values) in fit.law().named(&fit.values) {
        let numbers: Vec<_> = values.iter().map(|v| format!("{v:.7e}")).collect();
        match (parameter.list, numbers.as_slice()) {
            (true, numbers) => {
                writeln!(text, "{} = [{}]", parameter.name, numbers.join(", "))?;
            }
            (false, [number]) => writeln!(text, "{} = {number}", parameter.name)?,
            (false, _) => bail!("{} has {} values", parameter.name, numbers.len()),
        }
    }
    let [low, high] = fit.quality.stretch_range;
    writeln!(text, "stretch_range = [{low:.4}, {high:.4}]")?;
    let modes: Vec<_> = modes(tests).iter().map(|mode| format!("\"{mode}\"")).collect();
    writeln!(text, "modes = [{}]", modes.join(", "))?;
    Ok(text)
}
