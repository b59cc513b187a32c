//! `[[shape.symmetric]]`: tags of a whole body that move alike.

use anyhow::{Result, ensure};
use program::table::{Range, direction, nested};
use program::{KeyPath, Misfit, Names};

use super::{Axis, HandlesConfig, LevelConfig, Moves, ShapeConfig};

/// How near the number of images of a whole turn must be to a whole number [1].
const WHOLE: f64 = 1e-9;

program::table! {
    /// Tags of which the first has the handles and the others are its images; or one tag, which is its own image.
    #[derive(Clone, Debug)]
    pub struct SymmetricConfig {
        /// The tags that move alike.
        of: Names;
        /// The second, or the other half of the one, is the mirror image.
        mirror: Option<MirrorConfig> = None, nested;
        /// Each next one is the one before, shifted by this [m].
        shift: Option<[f64; 3]> = None, direction;
        /// Each next one is the one before, turned; or the one tag is all of its images.
        turn: Option<TurnConfig> = None, nested;
    }
}

program::table! {
    /// A plane across an axis.
    #[derive(Clone, Debug)]
    pub struct MirrorConfig {
        /// The axis across which it lies.
        axis: Axis;
        /// The coordinate on that axis [m].
        at: f64, Range::FINITE.unit("m");
    }
}

program::table! {
    /// A turn about an axis.
    #[derive(Clone, Debug)]
    pub struct TurnConfig {
        /// The direction of the axis.
        axis: Axis;
        /// A point on it [m].
        through: [f64; 3] = [0.0; 3], Range::FINITE.unit("m");
        /// From one to the next, about the axis as a right-handed screw turns [deg].
        angle: f64, Range::above(-360.0).below(360.0).unit("°");
    }
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
        let what = format!(", mirror: {tags} tags; expected two, or one that is its own image");
        ensure!(self.mirror.is_none() || tags <= 2, self.refused("of", &what));
        let what = ", shift: one tag; expected two or more, each the one before, shifted";
        ensure!(self.shift.is_none() || tags > 1, self.refused("of", what));
        if let Some(TurnConfig { angle, .. }) = self.turn {
            let parts = 360.0 / angle.abs();
            let what = ", turn: angle = 0°; expected more than 0°, less than 360°";
            ensure!(parts.is_finite(), self.refused("turn", what));
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
