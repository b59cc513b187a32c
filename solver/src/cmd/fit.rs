//! `solver fit`: a tensile test to a material.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Result, bail, ensure};
use mechanics::material::BULK_RATIO;
use mechanics::material::response::Mode;
use program::{FolderLock, Unusable};
use scene::law_table;
use serde_json::{Value, json};

use crate::fit::{self, CANDIDATES, Fitted, Test, Units};

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
        None => fit::choose(&fits),
    };
    let Some(chosen) = chosen else {
        return Err(Unusable(format!(
            "{}: no admissible parameters describe the data",
            arguments.data.display()
        ))
        .into());
    };
    print(&fits, chosen)?;
    let folder = &arguments.output;
    let _lock = FolderLock::new(folder)?;
    fit::draw(&folder.join("fit.svg"), &tests, &fits, chosen)?;
    program::write_json(&folder.join("fit.json"), &report(&tests, &fits, chosen)?)?;
    let material = folder.join("material.toml");
    if chosen.quality.r2 < USABLE {
        remove(&material)?;
        return Err(Unusable(format!(
            "{}: the best law has R² {:.4}, expected at least {USABLE}; look at {}",
            arguments.data.display(),
            chosen.quality.r2,
            folder.join("fit.svg").display()
        ))
        .into());
    }
    let text = snippet(&tests, chosen)?;
    mesh::io::write_atomic(&material, |out| out.write_all(text.as_bytes()))?;
    Ok(())
}

/// A material of an earlier run must not remain beside a fit that failed.
fn remove(path: &Path) -> Result<()> {
    Ok(mesh::io::remove_output(path)?)
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

fn print(fits: &[Fitted], chosen: &Fitted) -> Result<()> {
    let mut out = program::stdout();
    let [low, high] = chosen.quality.fitted;
    writeln!(out, "data: stretch {low:.3} to {high:.3}")?;
    writeln!(
        out,
        "law             R²        rms [kPa]  shear [kPa]  stable up to stretch (uni, bi, planar)"
    )?;
    for fit in fits {
        let q = &fit.quality;
        let ends: Vec<_> = q.stable_up_to.iter().map(|(_, e)| end(*e)).collect();
        writeln!(
            out,
            "{:14}  {:.6}  {:9.4}  {:11.3}  {}{}",
            fit.candidate.name,
            q.r2,
            1e-3 * q.rms,
            1e-3 * q.moduli.shear,
            ends.join(", "),
            if std::ptr::eq(fit, chosen) { "   <- written" } else { "" }
        )?;
    }
    Ok(())
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
        "written": chosen.candidate.name,
    }))
}

/// The table [material] of a scene.
fn snippet(tests: &[Test], fit: &Fitted) -> Result<String> {
    let q = &fit.quality;
    let [low, high] = q.stretch_range;
    ensure!(
        high > 1.0,
        "{}: its stress falls from the start, so it has no range of use",
        fit.candidate.name
    );
    let mut text = String::new();
    for test in tests {
        let name = test.path.display();
        writeln!(
            text,
            "# {}, fitted to {} points of {name} ({})",
            fit.candidate.name,
            test.points.len(),
            test.mode.name()
        )?;
    }
    writeln!(
        text,
        "# R² {:.6}, rms error {:.1} Pa, data at stretch {:.4} to {:.4}",
        q.r2, q.rms, q.fitted[0], q.fitted[1]
    )?;
    writeln!(
        text,
        "# The bulk modulus is chosen, not measured ({:.1} times the shear modulus); in this range it\n\
         # changes the uniaxial stress by up to {:.2} % of its largest value.",
        q.moduli.bulk / q.moduli.shear,
        100.0 * q.compressibility
    )?;
    if q.stretch_range[1] < q.fitted[1] {
        writeln!(text, "# The range ends before the data: beyond it this law is not stable.")?;
    }
    if tests.len() == 1 {
        writeln!(text, "# Only one mode was tested: other strains are the law's guess.")?;
    }
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
    writeln!(text, "stretch_range = [{low:.4}, {high:.4}]")?;
    Ok(text)
}
