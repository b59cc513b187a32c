//! The molds of a plan before they are written, proved; where they do not hold the cores, those of the
//! next method.

use anyhow::Result;
use mesh::{SurfaceMesh, Vec3};
use program::{Progress, Unusable};

use super::{Planned, Task};
use crate::body::collar::{Collar, FittedTube};
use crate::body::course::Ground;
use crate::body::groove::Groove;
use crate::body::layer::{LaidIn, Layer};
use crate::body::orientation::{Orientation, PartingSurface, Portion};
use crate::body::source::{CastPart, Input};
use crate::config::Config;
use crate::config::fitting::Tube;
use crate::config::method::Method;
use crate::files::export::printable;
use crate::files::report::{CAST, Cast, MoldReport, OUTSIDE, Role};
use crate::geometry::MM;
use crate::geometry::frame::Turn;
use crate::mold::{Mold, Piece};
use crate::plan::report::{ChosenBy, Entry, PlanReport};
use crate::plan::{Casting, Refused};
use crate::verify::{Against, LEFT, Line, Status, before_writing, held};

/// Cores that do not stay in their places, with numbers; nothing else is wrong with the mold.
#[derive(Debug, thiserror::Error)]
#[error("{refusal}")]
struct Leaning {
    /// How far they move, in words.
    moves: String,
    /// Why the mold is refused, and what to do.
    refusal: String,
}

/// The molds of a plan, or of the next method that can be used where the first one was left to `fab` and
/// does not hold the cores.
pub fn proved(task: &Task, planned: Planned) -> Result<(Planned, Vec<(Entry, MoldFiles)>)> {
    or_next(task, planned, molds)
}

/// A plan whose molds hold the cores, or that of the next method: nothing else is proved of the molds.
pub fn holding(task: &Task, planned: Planned) -> Result<Planned> {
    or_next(task, planned, require_held).map(|(planned, ())| planned)
}

/// What `attempt` makes of a plan, or of that of the next method if cores lean.
fn or_next<T>(
    task: &Task,
    planned: Planned,
    attempt: impl Fn(&Task, &Planned) -> Result<T>,
) -> Result<(Planned, T)> {
    let error = match attempt(task, &planned) {
        Ok(made) => return Ok((planned, made)),
        Err(error) => error,
    };
    let leaning = error.downcast::<Leaning>()?;
    if planned.plan.chosen_by == ChosenBy::Configuration {
        return Err(Unusable(leaning.refusal).into());
    }
    log::warn!("{}: {}: another method is tried", planned.plan.method, leaning.moves);
    // A core that dissolves stands as one that is pulled out.
    let on_stubs = Method::all().into_iter().filter(|method| method.core.stands_on_stub);
    let refuse = |method| Refused { method, reason: leaning.moves.clone() };
    let refused: Vec<Refused> = on_stubs.map(refuse).collect();
    let none =
        |error| Unusable(format!("{}; no other method can be used: {error:#}", leaning.refusal));
    let planned = task.plan_without(&refused, planned).map_err(none)?;
    let made = attempt(task, &planned)?;
    Ok((planned, made))
}

/// The molds of a plan, proved.
fn molds(task: &Task, planned: &Planned) -> Result<Vec<(Entry, MoldFiles)>> {
    let (model, from) = (task.model.as_deref(), task.from.as_deref());
    let against = Against { design: Some(&task.mesh), model, from, simulation: None };
    let mut molds = Vec::new();
    for casting in &planned.plan.castings {
        let entry = entry(planned, casting);
        let (mold, groove) = cut(task, planned, casting)?;
        planned.progress.step("rounding and checking its surfaces");
        let mut files = MoldFiles::of_casting(&mold, task, planned, entry)?;
        files.report.collars = fitted_tubes(&planned.collars, &mold, &planned.config);
        files.report.layers = task.named(laid_in(&planned.layers, &mold, &casting.name))?;
        files.report.threads = planned.threads.clone();
        files.report.groove = groove.map(|groove| groove.placed(&mold.frame));
        task.named(enclose(&mut files.report.cast, planned.inside))?;
        files.prove(&entry.name, against, &planned.report, planned.progress)?;
        molds.push((entry.clone(), files));
    }
    Ok(molds)
}

/// Whether cores that stand on stubs stay in their places. Molds in which none moves by more than
/// `limits.sag` are not put together.
fn require_held(task: &Task, planned: &Planned) -> Result<()> {
    if !planned.plan.method.core.stands_on_stub || planned.boundary.cores.is_empty() {
        return Ok(());
    }
    for casting in &planned.plan.castings {
        let (mold, _) = cut(task, planned, casting)?;
        if mold.holds.iter().any(|hold| hold.held > hold.limit) {
            let entry = entry(planned, casting);
            let files = MoldFiles::of_casting(&mold, task, planned, entry)?;
            files.judge(&entry.name, &held(&files.report, &files.surfaces))?;
        }
    }
    Ok(())
}

fn entry<'a>(planned: &'a Planned, casting: &Casting) -> &'a Entry {
    let mut molds = planned.report.molds.iter();
    molds.find(|entry| entry.name == casting.name).expect("it is planned")
}

/// The mold of a casting, and the groove in it for a thread.
fn cut(task: &Task, planned: &Planned, casting: &Casting) -> Result<(Mold, Option<Groove>)> {
    let Planned { config, boundary, plan, progress, .. } = planned;
    progress.step(&format!("cutting the mold of the {}", casting.name));
    let groove = task.named(groove(planned, casting))?;
    let grooved = task.named(groove.as_ref().map(|groove| groove.cut(boundary)).transpose())?;
    let boundary = grooved.as_ref().unwrap_or(boundary);
    let mold = task.named(Mold::new(boundary, &casting.orientation, plan.method, config))?;
    Ok((mold, groove))
}

/// The groove that is asked for.
fn groove(planned: &Planned, casting: &Casting) -> Result<Option<Groove>> {
    let Planned { config, boundary, lines, file, .. } = planned;
    let Some(asked) = &config.groove else { return Ok(None) };
    let Orientation { pull, parting, portion, .. } = &casting.orientation;
    let (PartingSurface::Plane(parting), Portion::Whole) = (parting, portion) else {
        let message = "[groove]: the mold is of halves, open, or parts on a height field; a groove is made in a body that is \
                       cast whole in shells which part on a plane: set parting.kind = \"plane\", and a method that \
                       casts it whole";
        return Err(Unusable(message.into()).into());
    };
    let ground = Ground {
        filled: &boundary.filled,
        pull: *pull,
        parting: *parting,
        file,
        pins: &config.core.pins,
        even: config.even_around_pins() + 2.0 * (asked.thread + asked.clearance),
    };
    Groove::new(lines, &ground, asked).map(Some)
}

/// The collars for mold.json.
fn fitted_tubes(collars: &[Collar], mold: &Mold, config: &Config) -> Vec<FittedTube> {
    let tube = config.fitting.as_ref().and_then(|fitting| fitting.tube().ok());
    let fitted = |tube: &Tube| collars.iter().map(|c| c.fitted_tube(tube, &mold.frame)).collect();
    tube.as_ref().map_or(Vec::new(), fitted)
}

/// Leaves room for what lies in the mold already [mm³].
fn enclose(cast: &mut Cast, inside: f64) -> Result<()> {
    if inside >= cast.volume {
        let [inside, volume] = [inside, cast.volume].map(|v| v / 1e3);
        let message = format!(
            "around: {inside:.2} mL lie in a mold of {volume:.2} mL already; expected the mesh of a body within the \
             one that is cast"
        );
        return Err(Unusable(message).into());
    }
    cast.inside_ml = inside / 1e3;
    cast.silicone_ml -= cast.inside_ml;
    Ok(())
}

/// The sheets that lie in what a mold casts, for mold.json.
fn laid_in(layers: &[Layer], mold: &Mold, name: &str) -> Result<Vec<LaidIn>> {
    let (low, high) = mold.cast.bounds();
    let within = |layer: &&Layer| {
        let [bottom, top] = layer.heights(&mold.frame);
        low.z < top && bottom < high.z
    };
    let place = |layer: &Layer| {
        if !mold.open {
            let message = format!(
                "layers: {:?} lies in the {name}, which is cast in a closed mold: nothing can be laid \
                 in there; method = \"open-top\" casts what is below a flat wall of the chamber as a \
                 sheet in an open tray",
                layer.tag
            );
            return Err(Unusable(message).into());
        }
        let [bottom, top] = layer.heights(&mold.frame);
        let below = mold.cast.trim_by_plane(&-Vec3::z(), -(bottom + top) / 2.0).volume();
        let laid = layer.laid_in(&mold.frame, low.z, below);
        laid.map_err(|message| Unusable(message).into())
    };
    layers.iter().filter(within).map(place).collect()
}

/// A mold as it is written.
pub struct MoldFiles {
    /// The surfaces of the parts, in the order of the files of the report [mm].
    pub surfaces: Vec<SurfaceMesh>,
    /// What mold.json has.
    pub report: MoldReport,
}

impl MoldFiles {
    /// Rounds a mold to what its files hold.
    pub fn new(mold: &Mold, input: Input, config: &Config) -> Result<Self> {
        let upright = Turn::lowering(-Vec3::z());
        let cast = printable(CAST, &mold.cast, upright)?;
        let mut report = MoldReport::new(mold, input, config, &cast);
        let mut surfaces = Vec::new();
        let mut add = |piece: &Piece, role: Role| -> Result<()> {
            // Printed with the demolding direction down: its outside lies on the printer's bed.
            let turn = Turn::lowering(piece.demolding);
            let surface = printable(&piece.name, &piece.solid, turn)?;
            report.add_part(piece, role, turn, &surface);
            surfaces.push(surface);
            Ok(())
        };
        mold.shells.iter().try_for_each(|piece| add(piece, Role::Shell))?;
        mold.cores.iter().try_for_each(|piece| add(piece, Role::Core))?;
        surfaces.push(cast);
        surfaces.push(printable(OUTSIDE, &mold.outside, upright)?);
        Ok(Self { surfaces, report })
    }

    fn of_casting(mold: &Mold, task: &Task, planned: &Planned, entry: &Entry) -> Result<Self> {
        let Planned { config, boundary, .. } = planned;
        let below = task.output.join(&entry.folder);
        let input = task.input(&below, config, CastPart::of(mold.portion), boundary.casts)?;
        Self::new(mold, input, config)
    }

    /// Refuses a mold that `fab verify` would reject.
    pub fn prove(
        &self,
        name: &str,
        against: Against,
        plan: &PlanReport,
        progress: Progress,
    ) -> Result<()> {
        let lines = before_writing(&self.report, &self.surfaces, against, plan, progress);
        self.judge(name, &lines)
    }

    /// Refuses a mold of which a check fails.
    fn judge(&self, name: &str, lines: &[Line]) -> Result<()> {
        let failed: Vec<_> = lines.iter().filter(|line| line.status == Status::Fail).collect();
        if failed.is_empty() {
            return Ok(());
        }
        let words =
            |line: &&Line| format!("{} is {}, expected {}", line.name, line.found, line.needed);
        let refusal = failed.iter().map(words).collect::<Vec<_>>().join("; ");
        let refusal = format!("{name}: a mold would not be right, none is written: {refusal}");
        let moves = |line: &&Line| {
            let core = line.leaning()?;
            let left = LEFT * self.report.casting.least_wall * MM;
            Some(format!("{core} would move by {}, where {left:.2} mm must be left", line.found))
        };
        match failed.iter().map(moves).collect::<Option<Vec<_>>>() {
            Some(moves) => Err(Leaning { moves: moves.join("; "), refusal }.into()),
            None => Err(Unusable(refusal).into()),
        }
    }
}
