//! Threads that are wound on the casting, as `solver simulate` found them.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use mesh::Vec3;
use reports::{Segment, Simulation, WINDINGS, Winding};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use geometry::MM;

/// Ends of segments that are nearer than this are one point [m].
const SAME: f64 = 1e-9;

/// A thread, or two that cross, on the casting.
#[derive(Clone, Debug, Deserialize, JsonSchema, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Thread {
    /// The name in the scene.
    pub name: String,
    /// Tag that it is wound on.
    pub on: String,
    /// How far below the tag it is in the finished body [mm].
    pub depth: Option<f64>,
    /// Length, of both if there are two [mm].
    pub length: f64,
    /// Turns of a helix, those of both if there are two.
    pub turns: Option<f64>,
    /// Height that a turn climbs [mm]; negative for a left-handed screw. Two numbers where it changes along the axis:
    /// the smallest and the largest.
    pub pitch: Option<Range>,
    /// Angle to the axis, where the scene has that in place of the pitch [°].
    pub angle: Option<Range>,
    /// Where it starts along the axis, from the point of the scene [mm].
    pub start: Option<f64>,
    /// Where it ends [mm].
    pub end: Option<f64>,
    /// Whether a second thread of the other hand crosses it.
    pub double: bool,
    /// Largest force in the simulation [N].
    pub force: f64,
    /// The break force over that, if it is known [1].
    pub margin: Option<f64>,
}

/// A number, or the smallest and the largest of a number that changes along an axis.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Range {
    /// The number has one value everywhere.
    Same(f64),
    /// From the smallest to the largest.
    Between([f64; 2]),
}

impl Range {
    /// What a scene has, a number or a table of values along an axis, times a factor.
    fn read(written: &Value, factor: f64) -> Option<Self> {
        if let Some(number) = written.as_f64() {
            return Some(Self::Same(number * factor));
        }
        let values = written["values"].as_array()?.iter().filter_map(Value::as_f64);
        let range = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], value| {
            [least.min(value * factor), most.max(value * factor)]
        });
        Some(Self::Between(range))
    }

    /// Whether it is negative: of a left-handed screw.
    fn is_negative(self) -> bool {
        match self {
            Self::Same(number) | Self::Between([number, _]) => number < 0.0,
        }
    }

    /// Writes its absolute values with a number of decimals.
    fn in_words(self, decimals: usize) -> String {
        match self {
            Self::Same(number) => format!("{:.decimals$}", number.abs()),
            Self::Between([a, b]) => {
                let (low, high) = (a.abs().min(b.abs()), a.abs().max(b.abs()));
                format!("{low:.decimals$} to {high:.decimals$}")
            }
        }
    }
}

impl Thread {
    /// The threads of a report of `solver simulate`.
    pub fn read(report: &Path) -> Result<Vec<Self>> {
        let context = || format!("wound: {}", report.display());
        let text = mesh::io::read_text(report).with_context(context)?;
        let simulation: Simulation = serde_json::from_str(&text)
            .with_context(|| format!("{}: not a report of `solver simulate`", context()))?;
        let written = simulation.config["winding"].as_array().cloned().unwrap_or_default();
        let found = simulation.end.and_then(|end| end.terms.windings).unwrap_or_default();
        ensure!(
            !found.is_empty(),
            "{}: no threads in it; expected the report of a scene with [[winding]]",
            context()
        );
        let of = |thread: &Winding| written.iter().find(|w| w["name"] == thread.name.as_str());
        Ok(found
            .iter()
            .map(|thread| Self::new(thread, of(thread).unwrap_or(&Value::Null)))
            .collect())
    }

    /// The lines of the threads beside a report, at rest [m]: those of [`WINDINGS`].
    pub fn lines(report: &Path) -> Result<Vec<Vec<Vec3>>> {
        let path = report.with_file_name(WINDINGS);
        let context = || format!("wound: {}", path.display());
        let text = mesh::io::read_text(&path).with_context(context)?;
        let segments = Segment::all(&text).map_err(anyhow::Error::msg).with_context(context)?;
        let mut lines: Vec<Vec<Vec3>> = Vec::new();
        for [start, end] in
            segments.iter().map(|segment| segment.ends.map(|end| Vec3::from(end.rest)))
        {
            let goes_on =
                |line: &&mut Vec<Vec3>| line.last().is_some_and(|p| (p - start).norm() < SAME);
            match lines.last_mut().filter(goes_on) {
                Some(line) => line.push(end),
                None => lines.push(vec![start, end]),
            }
        }
        Ok(lines)
    }

    /// A thread, with what the scene says of it.
    fn new(thread: &Winding, written: &Value) -> Self {
        let number = |key: &str| written[key].as_f64();
        Self {
            name: thread.name.clone(),
            on: thread.on.clone(),
            depth: number("depth").map(|depth| depth * MM),
            length: thread.length * MM,
            turns: thread.turns,
            pitch: Range::read(&written["pitch"], MM),
            angle: Range::read(&written["angle"], 1.0),
            start: number("start").map(|start| start * MM),
            end: number("end").map(|end| end * MM),
            double: written["double"] == true,
            force: thread.force[1],
            margin: thread.margin,
        }
    }

    /// What to have.
    pub fn item(&self) -> String {
        let strength =
            self.margin.map(|margin| format!(" that bears {:.1} N", margin * self.force));
        // to hold and to tie
        let length = self.length / 1e3 + if self.double { 0.4 } else { 0.2 };
        format!("{length:.1} m of thread{} (`{}`)", strength.unwrap_or_default(), self.name)
    }

    /// What to do.
    pub fn in_words(&self) -> String {
        let Self { name, length, .. } = self;
        let place = |word: &str| match self.depth {
            None => format!("{word} `{}`", self.on),
            Some(depth) => format!("{depth:.2} mm below `{}` of the finished body", self.on),
        };
        let Some(turns) = self.turns else {
            return format!(
                "Lay the thread `{name}` {} along the line of the scene, {length:.0} mm, without slack. {}",
                place("on"),
                self.bonded()
            );
        };
        let each = turns / if self.double { 2.0 } else { 1.0 };
        let climb = match (self.pitch, self.angle) {
            (Some(pitch), _) => format!(", {} mm apart", pitch.in_words(2)),
            (None, Some(angle)) => format!(", {}° to the axis", angle.in_words(0)),
            (None, None) => String::new(),
        };
        let way = match (self.start, self.end) {
            (Some(start), Some(end)) => format!(" from {start:.1} to {end:.1} mm along the axis"),
            _ => String::new(),
        };
        let left = self.pitch.or(self.angle).is_some_and(Range::is_negative);
        let hand = |left: bool| if left { "left-handed" } else { "right-handed" };
        let second = match self.double {
            true => format!(
                " Then wind the second, {}, over it from the same start to the same end: they cross twice in each turn.",
                hand(!left)
            ),
            false => String::new(),
        };
        format!(
            "Tie the thread `{name}` {} at its start with two half hitches. Wind it as a {} screw, {each:.1} turns{climb}{way}, \
             taut but without cutting into the silicone, and tie it at its end.{second} That is {:.2} m in all. {}",
            place("around"),
            hand(left),
            length / 1e3,
            self.bonded()
        )
    }

    fn bonded(&self) -> String {
        format!(
            "Bond it all along, by a thin coat of the same silicone or by the skin that is cast over it: simulated is a \
             thread that does not slide, with up to {:.1} N in it.",
            self.force
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn helix(pitch: Option<f64>, angle: Option<f64>, double: bool) -> Thread {
        Thread {
            name: "thread".into(),
            on: "skin".into(),
            depth: None,
            length: 2994.0,
            turns: Some(39.0),
            pitch: pitch.map(Range::Same),
            angle: angle.map(Range::Same),
            start: Some(2.0),
            end: Some(80.0),
            double,
            force: 2.2,
            margin: Some(5.0),
        }
    }

    #[test]
    fn a_helix_is_wound_by_hand_turns_and_pitch() {
        let words = helix(Some(4.0), None, true).in_words();
        for part in [
            "a right-handed screw, 19.5 turns, 4.00 mm apart from 2.0 to 80.0 mm along the axis",
            "wind the second, left-handed, over it",
            "That is 2.99 m in all",
            "up to 2.2 N",
        ] {
            assert!(words.contains(part), "{part}: {words}");
        }
        let written =
            serde_json::json!({ "values": [-2.5e-3, -4e-3, -3e-3], "start": 0, "end": 0.08 });
        let pitch = Range::read(&written, MM);
        let words = Thread { pitch, ..helix(None, None, false) }.in_words();
        assert!(
            words.contains("a left-handed screw, 39.0 turns, 2.50 to 4.00 mm apart"),
            "{words}"
        );
        let below = Thread { depth: Some(1.5), ..helix(None, Some(-75.0), false) }.in_words();
        let start = "Tie the thread `thread` 1.50 mm below `skin` of the finished body";
        assert!(below.starts_with(start) && !below.contains("second"), "{below}");
        assert!(below.contains("a left-handed screw, 39.0 turns, 75° to the axis"), "{below}");
        // There is more thread than is wound.
        assert_eq!(helix(None, None, true).item(), "3.4 m of thread that bears 11.0 N (`thread`)");
    }
}
