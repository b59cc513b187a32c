//! `[[shape.symmetric]]`: tags of a whole body that move alike.

use anyhow::{Result, ensure};
use measure::written::Names;
use program::{KeyPath, Misfit};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Axis, HandlesConfig, LevelConfig, Moves, ShapeConfig};

/// How near the number of images of a whole turn must be to a whole number [1].
const WHOLE: f64 = 1e-9;

/// Tags of which the first has the handles and the others are its images; or one tag, which is its own image.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SymmetricConfig {
    /// The tags that move alike.
    pub of: Names,
    /// The second, or the other half of the one, is the mirror image.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mirror: Option<MirrorConfig>,
    /// Each next one is the one before, shifted by this [m].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shift: Option<[f64; 3]>,
    /// Each next one is the one before, turned; or the one tag is all of its images.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub turn: Option<TurnConfig>,
}

/// A plane across an axis.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MirrorConfig {
    /// The axis across which it lies.
    pub axis: Axis,
    /// The coordinate on that axis [m].
    pub at: f64,
}

/// A turn about an axis.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TurnConfig {
    /// The direction of the axis.
    pub axis: Axis,
    /// A point on it [m].
    #[serde(default)]
    pub through: [f64; 3],
    /// From one to the next, about the axis as a right-handed screw turns [deg].
    pub angle: f64,
}

impl SymmetricConfig {
    /// How many images a tag has that is its own: 1 of a mirror, n − 1 of a turn by 360°/n.
    pub fn own_images(&self) -> usize {
        match &self.turn {
            _ if self.of.all().len() != 1 => 0,
            Some(turn) => (360.0 / turn.angle.abs()).round() as usize - 1,
            None => 1,
        }
    }

    /// What messages call it.
    pub fn title(&self) -> String {
        format!("[[shape.symmetric]] of = {:?}", self.of.all())
    }

    /// An error in one of its keys, whose message goes on with `what`.
    pub fn refused(&self, key: &str, what: &str) -> Misfit {
        let path = KeyPath::list("shape.symmetric").key(key);
        path.told(format!("{}{what}", self.title()))
    }

    fn check(&self, shape: &ShapeConfig) -> Result<()> {
        let tags = self.of.all();
        ensure!(!tags.is_empty(), self.refused("of", ": name a tag or more"));
        for (i, tag) in tags.iter().enumerate() {
            let uses = shape.symmetric.iter().flat_map(|one| one.of.all());
            let what = format!(
                ": \"{tag}\" is named twice; a tag can be in one [[shape.symmetric]], once"
            );
            ensure!(uses.filter(|other| *other == tag).count() == 1, self.refused("of", &what));
            let what = format!(": \"{tag}\" is not in [shape] on = {:?}", shape.on.all());
            ensure!(shape.on.all().contains(tag), self.refused("of", &what));
            shape.level.iter().try_for_each(|level| self.check_level(level, tag, i > 0))?;
        }
        let given = [self.mirror.is_some(), self.shift.is_some(), self.turn.is_some()];
        let given = given.into_iter().filter(|given| *given).count();
        let what = format!(": {given} of mirror, shift and turn; expected one of them");
        ensure!(given == 1, self.refused("of", &what));
        self.check_numbers(tags.len())
    }

    fn check_numbers(&self, tags: usize) -> Result<()> {
        if let Some(MirrorConfig { at, .. }) = self.mirror {
            let what = format!(", mirror: {tags} tags; expected two, or one that is its own image");
            ensure!(tags <= 2, self.refused("of", &what));
            let what = format!(", mirror: at = {at} m; expected a number");
            ensure!(at.is_finite(), self.refused("mirror", &what));
        }
        if let Some(shift) = self.shift {
            let what = ", shift: one tag; expected two or more, each the one before, shifted";
            ensure!(tags > 1, self.refused("of", what));
            let length = shift.iter().map(|s| s * s).sum::<f64>();
            let what = format!(", shift = {shift:?} m: must have a direction");
            ensure!(length.is_finite() && length > 0.0, self.refused("shift", &what));
        }
        if let Some(TurnConfig { angle, through, .. }) = self.turn {
            let what = format!(", turn: through = {through:?} m; expected numbers");
            ensure!(through.iter().all(|x| x.is_finite()), self.refused("turn", &what));
            let parts = 360.0 / angle.abs();
            let what = format!(", turn: angle = {angle}°; expected more than 0°, less than 360°");
            ensure!(parts.is_finite() && parts > 1.0, self.refused("turn", &what));
            let what = format!(
                ", turn: angle = {angle}° goes {parts:.4} times into 360°; expected a whole number"
            );
            let whole = (parts - parts.round()).abs() < WHOLE * parts;
            ensure!(tags > 1 || whole, self.refused("turn", &what));
        }
        Ok(())
    }

    fn check_level(&self, level: &LevelConfig, tag: &str, is_image: bool) -> Result<()> {
        let what = format!(
            ": vertices of \"{tag}\" move freely in a [[shape.level]], but no vertex is the image of another; expected \
             handles or offset = true"
        );
        ensure!(level.moves(tag) != Some(Moves::Vertices), self.refused("of", &what));
        if let (true, Some(HandlesConfig::Tags(tags))) = (is_image, &level.handles) {
            let what = format!(
                ": \"{tag}\" has handles of its own in a [[shape.level]]; expected none, it has those of \"{}\"",
                self.of.all()[0]
            );
            ensure!(!tags.contains_key(tag), self.refused("of", &what));
        }
        Ok(())
    }
}

impl ShapeConfig {
    /// The symmetry that a tag belongs to, with its place in it: 0 is the tag that has the handles.
    pub fn symmetry_of(&self, tag: &str) -> Option<(&SymmetricConfig, usize)> {
        let place = |one: &SymmetricConfig| one.of.all().iter().position(|other| other == tag);
        self.symmetric.iter().find_map(|one| Some((one, place(one)?)))
    }

    /// What moves on a tag in a level, if anything does: on an image, what moves on the first.
    pub fn moves(&self, level: &LevelConfig, tag: &str) -> Option<Moves> {
        let first = self.symmetry_of(tag).and_then(|(one, _)| one.of.all().first());
        level.moves(first.map_or(tag, String::as_str))
    }

    pub(super) fn check_symmetric(&self) -> Result<()> {
        self.symmetric.iter().try_for_each(|one| one.check(self))
    }
}
