//! The molds of a plan before they are written, proved; where cores lean in them, those of the next method.

use anyhow::{Result, ensure};
use geometry::frame::Turn;
use mesh::{SurfaceMesh, Vec3};
use program::Unusable;

use super::{Planned, Task};
use crate::body::collar::{Collar, FittedTube};
use crate::body::course::Ground;
use crate::body::groove::Groove;
use crate::body::layer::{LaidIn, Layer};
use crate::body::orientation::{Orientation, PartingSurface, Portion};
use crate::body::source::CastPart;
use crate::config::Config;
use crate::config::fitting::Tube;
use crate::config::method::Method;
use crate::files::export::printable;
use crate::files::report::{CAST, Cast, MoldReport, OUTSIDE, Role};
use crate::mold::{Mold, Piece};
use crate::plan::report::{ChosenBy, Entry};
use crate::plan::{Casting, Refused};
use crate::verify::{Against, Status, before_writing};

/// How far cores move that do not stay in their places, in words.
#[derive(Debug, thiserror::Error)]
#[error(
    "{0}: a mold would not be right, none is written: widen the inlet, lengthen core.length, give core.pins, or method = \
     \"halves\""
)]
struct Leaning(String);

/// The molds of a plan, or of the next method, proved.
pub fn proved(task: &Task, planned: Planned) -> Result<(Planned, Vec<(Entry, MoldFiles)>)> {
    let (planned, molds) = held(task, planned)?;
    let each = planned.plan.castings.iter().zip(&planned.plan.report.molds).zip(molds);
    let files = each.map(|((casting, entry), (mold, groove))| {
        log::debug!("rounding the {} and checking its surfaces", entry.name);
        let mut files = MoldFiles::new(&mold, task, &planned, entry)?;
        files.report.collars = fitted_tubes(&planned.collars, &mold, &planned.config);
        files.report.layers = task.named(laid_in(&planned.layers, &mold, &casting.name))?;
        files.report.threads = planned.threads.clone();
        files.report.groove = groove.map(|groove| groove.placed(&mold.frame));
        task.named(enclose(&mut files.report.cast, planned.inside))?;
        files.prove(task, &planned, &entry.name)?;
        Ok((entry.clone(), files))
    });
    let files = files.collect::<Result<_>>()?;
    Ok((planned, files))
}

/// A plan whose molds hold the cores, or that of the next method: nothing else is proved of the molds.
pub fn holding(task: &Task, planned: Planned) -> Result<Planned> {
    let stands = planned.plan.report.method.core.stands_on_stub;
    let stand = stands && !planned.boundary.cores.is_empty();
    if stand { Ok(held(task, planned)?.0) } else { Ok(planned) }
}

/// The mold of a casting, and the groove in it for a thread.
type Cut = (Mold, Option<Groove>);

/// The molds of a plan, or of the next method that can be used where the first one was left to `fab` and does not hold
/// the cores.
fn held(task: &Task, planned: Planned) -> Result<(Planned, Vec<Cut>)> {
    let error = match castings(task, &planned) {
        Ok(molds) => return Ok((planned, molds)),
        Err(error) => error,
    };
    let leaning = error.downcast::<Leaning>()?;
    if planned.plan.report.chosen_by == ChosenBy::Configuration {
        return Err(Unusable(leaning.to_string()).into());
    }
    log::warn!("{}: {}: another method is tried", planned.plan.report.method, leaning.0);
    // A core that dissolves stands as one that is pulled out.
    let on_stubs = Method::ALL.into_iter().filter(|method| method.core.stands_on_stub);
    let refuse = |method| Refused { method, reason: leaning.0.clone() };
    let refused: Vec<Refused> = on_stubs.map(refuse).collect();
    let none = |error| Unusable(format!("{leaning}; no other method can be used: {error:#}"));
    let plan = task.choose(&planned.boundary, &planned.config, &refused).map_err(none)?;
    let planned = Planned { plan, ..planned };
    let molds = castings(task, &planned)?;
    Ok((planned, molds))
}

/// The molds of all castings, in which cores stay in their places.
fn castings(task: &Task, planned: &Planned) -> Result<Vec<Cut>> {
    let Planned { config, boundary, plan, .. } = planned;
    let cut = |casting: &Casting| {
        log::debug!("cutting the mold of the {}", casting.name);
        let groove = task.named(groove(planned, casting))?;
        let grooved = task.named(groove.as_ref().map(|groove| groove.cut(boundary)).transpose())?;
        let boundary = grooved.as_ref().unwrap_or(boundary);
        let method = plan.report.method;
        let mold = task.named(Mold::new(boundary, &casting.orientation, method, config))?;
        let leaning = mold.leaning(config.casting.least_wall);
        ensure!(leaning.is_empty(), Leaning(leaning.join("; ")));
        Ok((mold, groove))
    };
    plan.castings.iter().map(cut).collect()
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
    fn new(mold: &Mold, task: &Task, planned: &Planned, entry: &Entry) -> Result<Self> {
        let Planned { config, boundary, .. } = planned;
        let below = task.output.join(&entry.folder);
        let input = task.input(&below, config, CastPart::of(mold.portion), boundary.casts)?;
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

    /// Refuses a mold that `fab verify` would reject.
    fn prove(&self, task: &Task, planned: &Planned, name: &str) -> Result<()> {
        let (design, model, from) = (task.mesh.clone(), task.model.clone(), task.from.clone());
        let against = Against { design: Some(design), model, from, simulation: None };
        let lines = before_writing(&self.report, &self.surfaces, &against, &planned.plan.report);
        let failed = lines.iter().filter(|line| line.status == Status::Fail);
        let words = failed
            .map(|line| format!("{} is {}, expected {}", line.name, line.found, line.needed))
            .collect::<Vec<_>>();
        ensure!(
            words.is_empty(),
            Unusable(format!(
                "{name}: a mold would not be right, none is written: {}",
                words.join("; ")
            ))
        );
        Ok(())
    }
}
