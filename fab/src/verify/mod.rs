//! Proofs that a written mold is right, each with its number.
//!
//! Everything is read back from the files, in the millimetres they are in. What
//! cannot be exact is compared with a bound on the rounding of the files: a
//! coordinate below c [mm] is off by at most c·2⁻²⁴, so that a vertex moves by at
//! most δ = √3·c·2⁻²⁴ and a volume with the boundary area A changes by at most δ·A.
//!
//! # What these proofs share with what they check
//!
//! A check that uses the same code as what it checks repeats its errors.
//!
//! - Independent, but for the crate `mesh` (files, Booleans, distances): `surfaces`, `fit` without
//!   collars, `demolding`. They use the written surfaces. `fit` takes the outlines of channels and gaps from the report.
//! - `filling`: the written surfaces are cut into columns by `geometry::columns`, as height fields of partings are. The
//!   outlines of channels come from the report.
//! - `walls`, `castings`: the silicone is measured by `mesh::walls`, by which the plan refuses thin
//!   bodies.
//! - `channels`: places and sizes of features come from the report. That there are enough features is not checked.
//! - `fit` of designed bodies: `body::files` joins model and design as for the mold; `cad` compares the mold with the mesh.
//! - `fit` with collars and `collars`: the reference is made by `body::boundary` and `body::collar`,
//!   as the mold was.
//! - `groove` and `fit` with it: where the thread runs comes from the report; widths, depths and what a moved ridge presses
//!   into are measured on the written casting.
//! - `layers`: height and outline come from the report; the silicone is that of the written surface.
//! - `release`: girths are measured by `geometry::girth`, which chose the method, too.
//! - `printing`: overhangs are measured by `geometry::overhang`, which wrote the report, too.

mod cad;
mod castings;
mod channels;
mod closed_mold;
mod collars;
mod demolding;
mod deviation;
mod filling;
mod fit;
mod groove;
mod layers;
mod origins;
mod printing;
mod release;
mod surfaces;
mod walls;

use std::path::{Path, PathBuf};

use mesh::io::IoError;
use mesh::{SurfaceMesh, Vec3};

pub use closed_mold::ClosedMold;
use origins::Origins;

use crate::files::report::MoldReport;
use crate::plan::report as plan;

/// How a check came out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Status {
    /// It holds.
    Ok,
    /// It holds, but a person should know.
    Warn,
    /// It does not hold.
    Fail,
}

/// One check of one thing.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// How it came out.
    pub status: Status,
    /// What was checked.
    pub name: String,
    /// What was found, with its unit.
    pub found: String,
    /// What was needed.
    pub needed: String,
}

impl Line {
    /// A check that holds if `holds`.
    pub fn new(name: impl Into<String>, holds: bool, found: String, needed: &str) -> Self {
        let status = if holds { Status::Ok } else { Status::Fail };
        Self { status, name: name.into(), found, needed: needed.into() }
    }

    /// A measure that must not exceed a limit.
    pub fn at_most(name: impl Into<String>, value: f64, limit: f64, unit: &str) -> Self {
        let found = format!("{} {unit}", number(value));
        Self::new(name, value <= limit, found, &format!("at most {} {unit}", number(limit)))
    }

    /// This check, with a warning in place of a failure.
    pub fn or_warning(mut self) -> Self {
        if self.status == Status::Fail {
            self.status = Status::Warn;
        }
        self
    }

    /// Adds the place in the mold [mm] to a check that does not hold.
    pub fn placed(mut self, at: &Vec3) -> Self {
        if self.status != Status::Ok {
            self.found += &format!(" at ({:.2}, {:.2}, {:.2})", at.x, at.y, at.z);
        }
        self
    }

    /// A measure that must reach a limit.
    pub fn at_least(name: impl Into<String>, value: f64, limit: f64, unit: &str) -> Self {
        let found = format!("{} {unit}", number(value));
        Self::new(name, value >= limit, found, &format!("at least {} {unit}", number(limit)))
    }
}

impl std::fmt::Display for Line {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let status = match self.status {
            Status::Ok => "ok  ",
            Status::Warn => "warn",
            Status::Fail => "FAIL",
        };
        write!(f, "{status}  {:<31}  {:<34}  {}", self.name, self.found, self.needed)
    }
}

/// Four significant digits, never in scientific notation above 10⁻⁴.
fn number(x: f64) -> String {
    match x.abs() {
        0.0 => "0".into(),
        a if a < 1e-4 => format!("{x:.1e}"),
        a if a < 1.0 => format!("{x:.4}"),
        a if a < 1e3 => format!("{x:.3}"),
        _ => format!("{x:.1}"),
    }
}

/// Where to find what a mold is compared with.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct Against {
    /// The design, if it is no longer where mold.json says
    #[arg(long)]
    pub design: Option<PathBuf>,
    /// The surface that the design was meshed from, if it is no longer where mold.json says
    #[arg(long, value_name = "FILE")]
    pub model: Option<PathBuf>,
    /// The mesh as modelled, if it is no longer where mold.json says
    #[arg(long, value_name = "MODELLED")]
    pub from: Option<PathBuf>,
    /// Folder that `solver simulate` wrote for the design: checks its walls under load
    #[arg(long)]
    pub simulation: Option<PathBuf>,
}

/// All checks of the molds in `folder`: of that of its mold.json, or of all that its
/// plan.json lists.
pub fn verify(folder: &Path, against: &Against) -> Result<Vec<Line>, IoError> {
    if let Some(simulation) = against.simulation.as_deref().filter(|folder| !folder.is_dir()) {
        let message = "there is no such folder; --simulation takes that of `solver simulate`";
        return Err(IoError::content(simulation, message));
    }
    if folder.join(plan::FILE).exists() {
        return verify_plan(folder, against);
    }
    let mut lines = verify_mold(folder, against, None)?;
    lines.extend(inflated(folder, against.simulation.as_deref())?);
    Ok(lines)
}

/// All checks of the molds that the plan in `folder` lists.
fn verify_plan(folder: &Path, against: &Against) -> Result<Vec<Line>, IoError> {
    let plan = plan::PlanReport::read(folder)?;
    let mut lines = Vec::new();
    for entry in &plan.molds {
        let found = verify_mold(&folder.join(&entry.folder), against, Some(&plan))?;
        let named = |line: Line| match plan.molds.len() {
            1 => line,
            _ => Line { name: format!("{}: {}", entry.name, line.name), ..line },
        };
        lines.extend(found.into_iter().map(named));
    }
    lines.extend(castings::checks(folder, &plan, against));
    // What is inflated is the whole body, whichever castings it is made of.
    if let Some(entry) = plan.molds.first() {
        lines.extend(inflated(&folder.join(&entry.folder), against.simulation.as_deref())?);
    }
    lines.push(Line::new(
        "plan: molds",
        !plan.molds.is_empty(),
        format!("{} verified, method {}", plan.molds.len(), plan.method.name()),
        "at least 1 mold",
    ));
    Ok(lines)
}

/// The checks of the body of a mold under the load of its simulation, if there is one.
fn inflated(folder: &Path, simulation: Option<&Path>) -> Result<Vec<Line>, IoError> {
    let Some(simulation) = simulation else { return Ok(Vec::new()) };
    let MoldReport { input, casting, .. } = MoldReport::read(folder)?;
    Ok(walls::inflated(&input, &casting, simulation))
}

/// All checks of one mold. Checks that need sound parts are left out if a part is not.
fn verify_mold(
    folder: &Path,
    against: &Against,
    plan: Option<&plan::PlanReport>,
) -> Result<Vec<Line>, IoError> {
    let report = MoldReport::read(folder)?;
    let (mut lines, files) = closed_mold::read(folder, report);
    let Some(files) = files else { return Ok(lines) };
    lines.extend(surfaces::checks(&files));
    if lines.iter().any(|line| line.status == Status::Fail) {
        let needed = "files and surfaces without failures";
        lines.push(Line::new("remaining checks", false, "not run".into(), needed));
        return Ok(lines);
    }
    let origins = Origins::new(folder, &files.report.input, against);
    lines.extend(shapes(&ClosedMold::new(files, origins), plan));
    Ok(lines)
}

/// The checks of sound parts, whether they have been written or not.
fn shapes(mold: &ClosedMold, plan: Option<&plan::PlanReport>) -> Vec<Line> {
    log::debug!("comparing with the design");
    let mut lines = fit::checks(mold);
    lines.extend(channels::checks(mold));
    lines.extend(layers::checks(mold));
    log::debug!("filling");
    lines.extend(filling::checks(mold));
    lines.extend(collars::checks(mold));
    lines.extend(groove::checks(mold));
    lines.extend(walls::checks(mold));
    log::debug!("pulling apart");
    lines.extend(demolding::checks(mold));
    lines.extend(release::checks(mold, plan));
    lines.extend(printing::checks(mold));
    lines
}

/// The checks of a mold that is not yet written. `surfaces` are those of the files in the
/// order of the report, valid and in millimetres; `against` names what is molded.
pub fn before_writing(
    report: &MoldReport,
    surfaces: &[SurfaceMesh],
    against: &Against,
    plan: &plan::PlanReport,
) -> Vec<Line> {
    let files = closed_mold::Files::of(report.clone(), surfaces.to_vec());
    let origins = Origins::new(Path::new("."), &report.input, against);
    shapes(&ClosedMold::new(files, origins), Some(plan))
}
