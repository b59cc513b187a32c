//! `[[winding]]`: a thread that is wound on a tag.

mod lay; // threads of a body
mod measures; // what a report says of them

use anyhow::{Result, bail, ensure};
use mechanics::body::Body;
use mechanics::energy::{Axis, Profile, Term, Winding};
use mechanics::material::slack::DEFAULT_SLACK;
use program::table::{Range, nested};
use program::{KeyPath, Names, misfit};
use reports::Terms;

use super::line::AroundConfig;
use super::profile::Along;
use super::values::Values;
use super::{
    About, Around, Ground, Room, RoomNumber, Stage, State, along, check_names, each, owned, value,
};

/// Most turns of a helix.
const MOST_TURNS: f64 = 10_000.0;

program::table! {
    /// A thread that is bonded to a tag: a helix about an axis, or a line through points. It carries tension only,
    /// and has no stiffness against bending and no mass.
    #[derive(Clone, Debug)]
    pub struct WindingConfig {
        /// What numbers and reports call it.
        name: String;
        /// Tag of the facets, on the boundary or inside, in one layer around the axis; or a list, such as that of a
        /// wall and of the sheet below the thread.
        on: Names;
        /// Stiffness EA [N]: Young's modulus times the area of the section, E π d²/4 of a solid thread. It may change along the
        /// axis, as `pitch` and `angle` may.
        stiffness: Along, Range::POSITIVE.unit("N").advice("; expected E π d²/4, as 212 N of E = 3e9 Pa and d = 0.3e-3 m");
        /// The axis of a helix; or `points`.
        around: Option<AroundConfig> = None, nested;
        /// Height that a turn climbs along the axis [m]; negative for a left-handed screw.
        pitch: Option<Along> = None, Range::FINITE.unit("m");
        /// Angle between the thread and the axis [°], in place of `pitch`, at the mean distance of the tag from the
        /// axis; negative for a left-handed screw.
        angle: Option<Along> = None, Range::above(-90.0).below(90.0).unit("°")
            .advice(": a helix is between 0 (along the axis) and 90 (around it), or their negatives");
        /// Height of the start along the axis, from its point [m].
        start: Option<f64> = None => "the lowest vertex of the tag", Range::FINITE.unit("m");
        /// Height of the end [m].
        end: Option<f64> = None => "the highest vertex of the tag", Range::FINITE.unit("m");
        /// Angle of the start around the axis [°], from the x axis; from the y axis where the axis is along x.
        phase: f64 = 0.0, Range::FINITE.unit("°");
        /// Whether a second thread of the other hand crosses it, from the same start.
        double: bool = false;
        /// Points of a line [m], which are moved to the nearest ones of the tag.
        points: Vec<[f64; 3]> = Vec::new(), Range::FINITE.unit("m");
        /// Force of the thread while the body has its shape at rest [N].
        pretension: f64 = 0.0, Range::NOT_NEGATIVE.unit("N").advice(": a thread only pulls");
        /// Force at which the thread breaks [N]: the report has the margin, and a run warns where the thread would break.
        strength: Option<f64> = None, Range::POSITIVE.unit("N").advice("; the force at which the thread breaks");
        /// Elongation over which the thread becomes taut [1].
        slack: f64 = DEFAULT_SLACK,
            Range::above(0.0).at_most(1.0).advice("; the elongation over which the thread becomes taut, such as 1e-3");
    }
}

/// How a helix climbs.
struct Climb<'a> {
    /// `pitch` or `angle`.
    key: &'static str,
    /// Its value, in the unit of the file.
    along: &'a Along,
    /// That unit, as it follows a number.
    unit: &'static str,
    axis: Axis,
}

impl WindingConfig {
    /// What messages call it.
    pub fn title(&self) -> KeyPath {
        KeyPath::list("winding").named(&self.name)
    }

    /// How a helix climbs; none of a line through points.
    fn climb(&self) -> Result<Option<Climb<'_>>> {
        if !self.points.is_empty() {
            return Ok(None);
        }
        let (key, along, unit) = match (&self.pitch, &self.angle) {
            (Some(pitch), None) => ("pitch", pitch, " m"),
            (None, Some(angle)) => ("angle", angle, "°"),
            (Some(_), Some(_)) => {
                let key = self.title().key("angle");
                bail!(misfit!(key, " beside pitch: expected one of both"));
            }
            (None, None) => {
                bail!(misfit!(
                    self.title(),
                    " has no course: expected around with pitch or angle, or points = [[x, y, z], …]"
                ));
            }
        };
        check_hand(&self.title().key(key), along, unit)?;
        let around = self.around.as_ref().ok_or_else(|| {
            misfit!(
                self.title(),
                ": a helix without an axis: add around = {{ point = [0, 0, 0], axis = [0, 0, 1] }}"
            )
        })?;
        Ok(Some(Climb { key, along, unit, axis: around.line() }))
    }

    /// Heights of the ends of a helix, on a tag between two heights [m].
    fn heights(&self, [low, high]: [f64; 2]) -> Result<[f64; 2]> {
        let (start, end) = (self.start.unwrap_or(low), self.end.unwrap_or(high));
        ensure!(
            end > start && (end - start).is_finite(),
            misfit!(self.title().key("end"), " = {end} m: must be above start = {start} m")
        );
        Ok([start, end])
    }

    /// Refuses a helix of too many turns.
    fn check_turns(&self, turns: f64) -> Result<()> {
        let course = self.climb()?.map_or(String::new(), |Climb { key, along, unit, .. }| {
            format!(": {key} = {}{unit}", along.in_words(|value| value.to_string()))
        });
        ensure!(
            turns <= MOST_TURNS,
            misfit!(self.title(), "{course} makes {turns:.0} turns; expected at most {MOST_TURNS}")
        );
        Ok(())
    }

    /// Whether it is one course.
    fn check_course(&self) -> Result<()> {
        let key = |key: &str| self.title().key(key);
        ensure!(
            !self.on.all().is_empty(),
            misfit!(
                key("on"),
                " = []: no tag; expected one that the thread is wound on, or several"
            )
        );
        let Some(Climb { key: name, along, axis, .. }) = self.climb()? else {
            return self.check_points();
        };
        if let Some(profile) = along.profile() {
            profile.build(&key(name), Some(axis))?;
        }
        self.stiffness_profile().map(drop)
    }

    /// The stiffness by the height, if it changes: along the axis of a helix, or the line of its table.
    pub fn stiffness_profile(&self) -> Result<Option<Profile>> {
        let Some(profile) = self.stiffness.profile() else { return Ok(None) };
        let axis = self.around.as_ref().map(AroundConfig::line);
        profile.build(&self.title().key("stiffness"), axis).map(Some)
    }

    fn check_points(&self) -> Result<()> {
        self.stiffness_profile()?;
        let key = |key: &str| self.title().key(key);
        let keys = [
            ("around", self.around.is_some()),
            ("pitch", self.pitch.is_some()),
            ("angle", self.angle.is_some()),
            ("start", self.start.is_some()),
            ("end", self.end.is_some()),
            ("phase", self.phase != 0.0),
            ("double", self.double),
        ];
        if let Some((found, _)) = keys.into_iter().find(|(_, has)| *has) {
            bail!(misfit!(key(found), " beside points: it is for a helix; expected one of both"));
        }
        let mut legs = self.points.windows(2);
        ensure!(
            self.points.len() > 1 && legs.all(|leg| leg[0] != leg[1]),
            misfit!(
                key("points"),
                ": {} points; expected two or more, each other than the one before",
                self.points.len()
            )
        );
        Ok(())
    }

    fn in_words(&self) -> String {
        let Self { name, on, stiffness, pitch, angle, double, points, .. } = self;
        let course = match (pitch, angle) {
            (Some(pitch), _) => {
                format!(
                    "helix of pitch {} mm",
                    pitch.in_words(|pitch| format!("{:.3}", 1e3 * pitch))
                )
            }
            (None, Some(angle)) => {
                format!("helix at {}°", angle.in_words(|angle| angle.to_string()))
            }
            (None, None) => format!("line through {} points", points.len()),
        };
        let double = if *double { ", double" } else { "" };
        let on = on.all().join(" and ");
        format!(
            "winding {name} on {on}: {course}{double}, EA {} N",
            stiffness.in_words(|stiffness| format!("{stiffness:.3e}"))
        )
    }

    /// That a point of a line is not on its tag.
    fn warning(&self, body: &Body) -> Option<String> {
        let (i, distance) = lay::farthest_point(self, body)?;
        let [x, y, z] = self.points[i].map(|x| 1e3 * x);
        Some(format!(
            "winding {}: point {} of the line, ({x:.3}, {y:.3}, {z:.3}) mm, is {:.3} mm from \"{}\"; the thread goes \
             through the nearest point of that instead\n  give points on it, or another tag",
            self.name,
            i + 1,
            1e3 * distance,
            self.on.all().join("\" and \"")
        ))
    }
}

/// Refuses 0, and values of both hands: somewhere between them a thread would not climb.
fn check_hand(key: &KeyPath, along: &Along, unit: &str) -> Result<()> {
    let values = along.values();
    ensure!(
        values.iter().all(|value| *value != 0.0),
        misfit!(
            key.clone(),
            " = 0{unit}: must not be 0, such as 3e-3 m or 80°; negative for a left-handed screw"
        )
    );
    ensure!(
        values.iter().all(|value| value.signum() == values[0].signum()),
        misfit!(
            key.clone(),
            ".values = {values:?}{unit}: positive and negative; a thread cannot change its hand, expected two windings \
             that meet, with the end of one as the start of the other"
        )
    );
    Ok(())
}

impl Room for Vec<WindingConfig> {
    fn about(&self) -> About {
        About {
            list: "winding",
            stage: Stage::Body,
            paths: "winding.NAME.stiffness, .pretension, .pitch, .angle or .phase",
            meaning: "the stiffness EA or the pretension of a [[winding]], or the pitch or the angle, as the scene has it, and \
         the phase of one around an axis; of a table along the axis, with its place, as in winding.NAME.stiffness.2",
            example: "[[winding]]\nname = \"thread\"\non = \"top\"\npoints = [[0.01, 0.01, 0.04], [0.04, 0.03, 0.04]]\n\
         stiffness = 10\npretension = 0.1\n",
        }
    }

    fn in_words(&self) -> Vec<String> {
        self.iter().map(WindingConfig::in_words).collect()
    }

    fn check(&self, around: &Around) -> Result<()> {
        check_names("winding", self.iter().map(|winding| &winding.name))?;
        self.iter().try_for_each(WindingConfig::check_course)?;
        if let (Some(winding), false) = (self.first(), around.cuts.is_empty()) {
            bail!(misfit!(
                winding.title(),
                " beside [[symmetry]]: a helix is not its own mirror image, and would leave the part at the cut; \
                 expected the whole body (solver mirror)"
            ));
        }
        Ok(())
    }

    fn stress(&self, size: f64, _: &Values) -> f64 {
        let stiffness = self.iter().flat_map(|thread| thread.stiffness.values());
        stiffness.map(|stiffness| stiffness / size.powi(2)).fold(0.0, f64::max)
    }

    fn build(&self, ground: &Ground, _: usize) -> Result<Vec<Term>> {
        let threads = self.iter().map(|winding| lay::thread(winding, ground));
        Ok(owned("winding", threads.collect::<Result<Vec<_>>>()?))
    }

    fn numbers(&mut self) -> Vec<RoomNumber<'_>> {
        each(self, |_, thread| {
            let is_helix = thread.points.is_empty();
            let WindingConfig { name, stiffness, pretension, pitch, angle, phase, .. } = thread;
            let mut all: Vec<_> = along("stiffness", "N", stiffness).collect();
            all.push(value("pretension", "N", pretension));
            if is_helix {
                all.extend(pitch.iter_mut().flat_map(|pitch| along("pitch", "m", pitch)));
                all.extend(angle.iter_mut().flat_map(|angle| along("angle", "°", angle)));
                all.push(value("phase", "°", phase));
            }
            (name.clone(), all)
        })
    }

    fn warnings(&self, body: &Body) -> Vec<String> {
        self.iter().filter_map(|own| own.warning(body)).collect()
    }

    fn report(&self, state: State, terms: &mut Terms) {
        let one =
            |(config, thread): (&WindingConfig, &Winding)| measures::of(config, thread, state);
        let threads = self.iter().zip(state.energies.each());
        terms.windings = (!self.is_empty()).then(|| threads.map(one).collect());
    }
}
