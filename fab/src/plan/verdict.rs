//! Which methods can make a body's chamber, judged by what is measured.

use anyhow::{Error, Result, bail, ensure};
use geometry::girth::{self, Passage};
use geometry::{MM, place};
use mesh::Vec3;

use super::gluing::{self, CAUGHT, Cut, Flat};
use super::report::{Measure, Verdict};
use super::{Casting, Locked, chamber_and_sheet, halves, pull};
use crate::body::boundary::{Boundary, CoreBoundary, Inlet};
use crate::body::layout;
use crate::body::orientation::Portion;
use crate::body::walls::{self, Wall};
use crate::config::Config;
use crate::config::method::{Bodies, Castings, JudgedBy, Method};

/// Why a core could not be demolded.
fn blocked(cut: &Cut) -> String {
    format!("the mold around the body stands in the way of {:.1} % of the core", 100.0 * cut.caught)
}

/// Why a plane does not open all chambers.
fn missed(cut: &Cut, boundary: &Boundary) -> String {
    format!(
        "it does not open {} of {} chambers, whose cores the plate could not carry",
        cut.missed,
        boundary.cores.len()
    )
}

/// Measures a body only as far as the judged methods need it.
pub struct Judge<'a> {
    boundary: &'a Boundary,
    config: &'a Config,
    /// What was measured.
    pub measures: Vec<Measure>,
    /// What was decided.
    pub verdicts: Vec<Verdict>,
    /// Methods that were tried, and why their molds are not right.
    refused: &'a [Refused],
    halves: Option<Cut>,
    flat: Option<Flat>,
    /// The thinnest wall of the body, once it is measured.
    pub wall: Option<Option<Wall>>,
}

/// A method whose mold was made and found not to be right.
#[derive(Clone, Debug)]
pub struct Refused {
    /// The method.
    pub method: Method,
    /// Why, with numbers.
    pub reason: String,
}

impl<'a> Judge<'a> {
    /// Nothing is measured yet.
    pub fn new(boundary: &'a Boundary, config: &'a Config, refused: &'a [Refused]) -> Self {
        let (measures, verdicts) = (Vec::new(), Vec::new());
        let (halves, flat, wall) = (None, None, None);
        Self { boundary, config, measures, verdicts, refused, halves, flat, wall }
    }

    /// The method that is preferred of those that can be used without being asked for, and its castings.
    pub fn first_possible(&mut self) -> Result<(Method, Vec<Casting>)> {
        for method in self.candidates() {
            if !self.judge(method).possible {
                continue;
            }
            match self.castings(method) {
                Err(error) if error.is::<Locked>() && self.config.parting.is_open() => {
                    self.reject(method, &error);
                }
                Err(error) => return Err(error),
                Ok(castings) => return Ok((method, castings)),
            }
        }
        let reason = |v: &Verdict| format!("{}: {}", v.method, v.reason);
        let reasons: Vec<String> = self.verdicts.iter().map(reason).collect();
        bail!("no method makes this body: {}", reasons.join("; "));
    }

    /// The methods that concern a body with chambers, or one without.
    fn candidates(&self) -> Vec<Method> {
        let solid = self.boundary.cores.is_empty();
        let concerns = |method: &Method| match method.bodies {
            Bodies::Solid => solid,
            Bodies::All => true,
            Bodies::WithChambers => !solid,
        };
        let mut all = Method::ALL.to_vec();
        // What is simplest comes first.
        all.sort_by_key(|method| method.bodies != Bodies::Solid);
        all.into_iter().filter(concerns).collect()
    }

    /// Takes back that a method can be used.
    fn reject(&mut self, method: Method, error: &Error) {
        let verdict = self.verdicts.iter_mut().rfind(|verdict| verdict.method == method);
        let verdict = verdict.expect("it was judged");
        verdict.possible = false;
        verdict.reason += &format!("; {error}");
    }

    /// The method asked for.
    pub fn require(&mut self, method: Method) -> Result<Method> {
        let verdict = self.judge(method);
        if verdict.possible {
            return Ok(method);
        }
        let others = self.candidates().into_iter().filter(|&other| other != method);
        let can: Vec<String> = others
            .filter(|&other| self.judge(other).possible)
            .map(|other| format!("\"{other}\""))
            .collect();
        let possible = match can.len() {
            0 => "no other method can be used".into(),
            _ => format!("possible are {}", can.join(", ")),
        };
        bail!("method = \"{method}\" cannot be used: {}; {possible}", verdict.reason);
    }

    /// Walls of the body are nowhere too thin in the mold, which is larger by what shrinks. What halves
    /// and open-top molds cut in two has sharp edges there, which are no walls: the body is measured.
    fn require_walls(&mut self) -> Result<()> {
        let (boundary, least) = (self.boundary, self.config.casting.least_wall);
        let cast = (&boundary.cast, boundary.casts);
        let wall = self.wall.get_or_insert_with(|| walls::thinnest(cast, boundary.beside.as_ref()));
        let Some(wall) = *wall else { return Ok(()) };
        let Wall { thickness, at, on } = wall;
        let at = place(&at, 2);
        ensure!(
            !wall.is_thinner(least * (1.0 - self.config.shrinkage())),
            "the silicone is {:.3} mm thick at {at} of the {on}, casting.least_wall is {:.3} mm: thicken \
             the wall there, blunt the edge if it is one of less than 60°, or lower casting.least_wall",
            thickness * MM,
            least * MM
        );
        Ok(())
    }

    /// Cores, which are larger by what shrinks, are nowhere too thin.
    fn require_cores(&self) -> Result<()> {
        let Some(least) = self.config.casting.least_core else { return Ok(()) };
        let in_design = least * (1.0 - self.config.shrinkage());
        for core in &self.boundary.cores {
            let surface = (&core.surface, self.boundary.casts);
            if let Some(Wall { thickness, at, .. }) = walls::too_thin(surface, None, in_design) {
                let named = !core.chamber.is_empty();
                let of = if named { format!(" of {:?}", core.chamber) } else { String::new() };
                let at = place(&at, 2);
                bail!(
                    "the core{of} is {:.3} mm thick at {at}, casting.least_core is {:.3} mm: widen the chamber \
                     there, or lower casting.least_core",
                    thickness * MM,
                    least * MM
                );
            }
        }
        Ok(())
    }

    /// What a method that was judged possible casts.
    pub fn castings(&mut self, method: Method) -> Result<Vec<Casting>> {
        let (boundary, config) = (self.boundary, self.config);
        self.require_walls()?;
        self.require_cores()?;
        match method.castings {
            Castings::Body => {
                let up = layout::up(boundary, config);
                let up = layout::require_inlets_down(boundary, up)?;
                Ok(vec![Casting::new("body", &boundary.filled, up, Portion::Whole, config)?])
            }
            Castings::Halves => {
                let cut = self.halves();
                halves(boundary, &cut.normal, cut.offset, config)
            }
            Castings::ChamberAndSheet => {
                let flat = self.flat.as_ref().expect("it was judged possible");
                chamber_and_sheet(boundary, flat, config)
            }
        }
    }

    /// Why a method that was judged is taken, and why those are not that come before it.
    pub fn reason(&self, method: Method) -> String {
        let (own, others): (Vec<&Verdict>, _) =
            self.verdicts.iter().partition(|v| v.method == method);
        let own = own.iter().map(|v| v.reason.clone());
        let refused = others.into_iter().filter(|v| !v.possible);
        let refused = refused.map(|v| format!("not {}: {}", v.method, v.reason));
        own.chain(refused).collect::<Vec<_>>().join("; ")
    }

    fn judge(&mut self, method: Method) -> Verdict {
        let solid = self.boundary.cores.is_empty();
        let (possible, reason) = match method.judged_by {
            _ if solid && method.bodies == Bodies::WithChambers => {
                (false, "the body has no chamber".into())
            }
            JudgedBy::NoChamber => match self.boundary.cores.len() {
                0 => (true, "the body has no chamber".into()),
                n => (false, format!("the body has {n} chambers to be filled while it is cast")),
            },
            JudgedBy::Girth => self.pull_out(),
            JudgedBy::Inlets => self.inlets(),
            JudgedBy::HalfCores => self.in_halves(),
            JudgedBy::FlatWall => self.open_top(),
        };
        let refused = self.refused.iter().find(|refused| refused.method == method);
        let verdict = match refused.filter(|_| possible) {
            Some(Refused { reason, .. }) => {
                Verdict { method, possible: false, reason: reason.clone() }
            }
            None => Verdict { method, possible, reason },
        };
        self.verdicts.push(verdict.clone());
        verdict
    }

    /// Whether every core has an inlet, and all of them face down.
    fn inlets(&mut self) -> (bool, String) {
        if let Some(core) = self.boundary.cores.iter().find(|core| core.inlets.is_empty()) {
            let volume = mesh::measure::enclosed_volume(&core.surface).abs() * 1e9;
            let reason =
                format!("a chamber of {volume:.1} mm³ is closed, and no core can be held in it");
            return (false, reason);
        }
        let inlets = self.boundary.cores.iter().flat_map(|core| &core.inlets);
        let scale = 1.0 / (1.0 - self.config.shrinkage());
        let narrowest = inlets.map(|inlet| inlet.radius * scale).fold(f64::INFINITY, f64::min);
        let least = self.config.least_inlet();
        if narrowest < least {
            let reason = format!(
                "an inlet has an inscribed radius of {:.3} mm, at least {:.3} mm are needed for a stub that is \
                 held in its socket: widen it, or reduce core.clearance or core.shoulder",
                narrowest * 1e3,
                least * 1e3
            );
            return (false, reason);
        }
        let up = layout::up(self.boundary, self.config);
        if let Err(error) = layout::require_inlets_down(self.boundary, up) {
            return (false, error.to_string());
        }
        let count: usize = self.boundary.cores.iter().map(|core| core.inlets.len()).sum();
        let cores = match self.boundary.cores.len() {
            1 => "the core".into(),
            n => format!("{n} cores"),
        };
        (true, format!("{cores} can be held, and leave, through {count} inlets that face down"))
    }

    fn pull_out(&mut self) -> (bool, String) {
        let (held, reason) = self.inlets();
        if !held {
            return (false, reason);
        }
        let limit = self.config.limits.girth;
        let mut worst: f64 = 0.0;
        let mut words = String::new();
        for core in &self.boundary.cores {
            let inlet = core.inlets.iter().max_by(|a, b| a.girth.total_cmp(&b.girth));
            let inlet = inlet.expect("every core has an inlet");
            let (ratio, bottleneck) = required_stretch(core, inlet);
            if ratio > worst {
                worst = ratio;
                words = format!(
                    "{bottleneck} must stretch to {ratio:.2} times its girth, limits.girth is {limit:.2}"
                );
            }
        }
        self.note(
            "girth of the core over girth of its inlet",
            [worst, limit],
            "longest outline of a section of the core across the inlet's axis, over that of the inlet's rim or of a section \
             nearer to it through which it has to pass; the limit is a judgement",
        );
        (worst <= limit, words)
    }

    /// Keeps a ratio that was measured, with its limit.
    fn note(&mut self, name: &str, [value, limit]: [f64; 2], meaning: &str) {
        let (name, meaning) = (name.into(), meaning.into());
        let measure = Measure { name, value, unit: String::new(), limit: Some(limit), meaning };
        self.measures.push(measure);
    }

    fn open_top(&mut self) -> (bool, String) {
        let limit = self.config.limits.flat;
        self.flat = gluing::flattest(self.boundary);
        let Some(Flat { cut, share, .. }) = self.flat.clone() else {
            return (false, "the chamber has no wall besides its inlets".into());
        };
        let percent = 100.0 * share;
        let (across, cutting) = (pull::direction(&cut.normal), cut.describe());
        let words = format!(
            "the largest flat wall of the chamber, across {across}, covers {percent:.1} % of its outline"
        );
        self.note(
            "flat wall over outline of the chamber",
            [share, limit],
            "area of the chamber's wall within 5 µm of a plane with all of the chamber on one side, over the area of the chamber \
             as seen across it; the limit is a judgement",
        );
        let (ratio, peel) = (cut.core_ratio, self.config.limits.peel);
        // The reason that decides comes first, without limits that hold.
        let against = if cut.missed > 0 {
            missed(&cut, self.boundary)
        } else if share < limit {
            return (false, format!("{words}, limits.flat is {:.1} %; {cutting}", 100.0 * limit));
        } else if cut.caught > CAUGHT {
            blocked(&cut)
        } else if ratio > peel {
            format!(
                "silicone below the core must give way by {ratio:.2} of its width, limits.peel is {peel:.2}"
            )
        } else {
            return (true, format!("{words}, limits.flat is {:.1} %; {cutting}", 100.0 * limit));
        };
        (false, format!("{against}; {words}; {cutting}"))
    }

    fn in_halves(&mut self) -> (bool, String) {
        let limit = self.config.limits.peel;
        let cut = self.halves();
        let ratio = cut.core_ratio;
        let words = format!(
            "{}; below the core silicone must give way by {ratio:.2} of its width, limits.peel is {limit:.2}",
            cut.describe()
        );
        self.note(
            "undercut of the half cores",
            [ratio, limit],
            "depth of what is caught below a half core over its width; the limit is a judgement",
        );
        let against = match () {
            () if cut.missed > 0 => missed(&cut, self.boundary),
            () if cut.caught > CAUGHT => blocked(&cut),
            () => return (ratio <= limit, words),
        };
        (false, format!("{words}; {against}"))
    }

    /// The plane in which halves are glued.
    fn halves(&mut self) -> Cut {
        let (boundary, config) = (self.boundary, self.config);
        let cut = self.halves.get_or_insert_with(|| {
            let mut normals = vec![Vec3::x(), Vec3::y(), Vec3::z()];
            normals.extend(gluing::walls(boundary));
            let inlets = boundary.cores.iter().flat_map(|core| &core.inlets);
            normals.extend(inlets.flat_map(|inlet| pull::usable(&inlet.normal)));
            normals.extend(pull::hemisphere());
            gluing::best(boundary, &config.gluing, &normals, config.limits.peel)
        });
        cut.clone()
    }
}

/// How far silicone must stretch to let a core pass through an inlet, and where.
fn required_stretch(core: &CoreBoundary, inlet: &Inlet) -> (f64, String) {
    let around = girth::largest(&core.surface, &inlet.normal).length;
    let passage = girth::tightest(&core.surface, &inlet.normal, inlet.deviation);
    let ratio = around / inlet.girth;
    if passage.ratio() <= ratio {
        let (around, inlet) = (around * 1e3, inlet.girth * 1e3);
        return (
            ratio,
            format!("the core is {around:.1} mm around, its inlet {inlet:.1} mm: the inlet"),
        );
    }
    let Passage { neck, through } = passage;
    let depth = inlet.centre.dot(&inlet.normal) - neck.position;
    let bottleneck = format!(
        "the core is {:.1} mm around where it passes through a neck of {:.1} mm, {:.1} mm behind its inlet: the neck",
        through.length * 1e3,
        neck.length * 1e3,
        depth * 1e3
    );
    (passage.ratio(), bottleneck)
}
