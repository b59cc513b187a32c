//! `[[shape.level]]`, or `[[level]]` of a design of loads alone: what moves in a level of the
//! cascade, tag by tag, what counts, and how finely the scene is simulated.

use std::collections::BTreeMap;
use std::path::PathBuf;

use anyhow::{Context, Result, bail, ensure};
use program::table::{Numbers, Range, Table, named, nested};
use program::{KeyPath, Names, misfit};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{DEGREE, STEPS};

program::table! {
    /// A level of the cascade, or several where its handles grow.
    #[derive(Clone, Debug)]
    pub struct LevelConfig {
        /// Number of handles.
        handles: Option<HandlesConfig> = None, Range::POSITIVE.advice("; expected one handle or more");
        /// What vertices off the rims move freely.
        vertices: VerticesConfig = VerticesConfig::default();
        /// Each tag as a whole moves along its normals: one variable a tag, in place of handles and vertices.
        offset: bool = false;
        /// How a handle moves.
        motion: HandleMotion = HandleMotion::Rigid;
        /// Accepted optimiser iterations.
        iterations: usize;
        /// Factors on the weights of objectives, by their names; 1 for the others.
        weights: BTreeMap<String, f64> = BTreeMap::new(), named::<f64>(Range::NOT_NEGATIVE);
        /// Another mesh in place of the scene's, as modelled and with the same tags: the design moves to it and back.
        mesh: Option<PathBuf> = None;
        /// The body that `mesh` is of, in a scene with several.
        body: Option<String> = None;
        /// Degree of the displacement: 1, 2 or 3.
        degree: Option<usize> = None => "the scene's", DEGREE;
        /// Time steps.
        time: Option<LevelTime> = None => "the scene's", nested;
        /// First step, in mean edges [1].
        first_step: Option<f64> = None => "the design's", Range::NOT_NEGATIVE;
        /// Largest step, in mean edges [1].
        largest_step: Option<f64> = None => "the design's", Range::POSITIVE;
        /// Fall of the objective in an iteration at which the level ends, as a part [1].
        stagnation: Option<f64> = None => "the design's", Range::NOT_NEGATIVE;
        /// Norm of the gradient at which the level ends, as a part of that at its start [1].
        gradient_tolerance: Option<f64> = None => "the design's", Range::NOT_NEGATIVE;
        /// Computing time after which no iteration begins [s].
        time_limit: Option<f64> = None => "the design's", Range::NOT_NEGATIVE.unit("s");
    }
}

impl Default for LevelConfig {
    fn default() -> Self {
        toml::from_str("iterations = 0").expect("all else has a default")
    }
}

program::table! {
    /// Time steps of equal length in a level.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct LevelTime {
        /// Their number.
        steps: usize, STEPS;
        /// End of the last [s].
        end: Option<f64> = None => "the scene's", Range::POSITIVE.unit("s");
    }
}

/// `handles` of a level.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "expected a number of handles, a table with one for each tag, or one with first, factor and levels"
)]
pub enum HandlesConfig {
    /// As many on each tag that moves.
    Each(usize),
    /// Of several levels, one after the other.
    Growing(Growing),
    /// On some of the tags.
    Tags(BTreeMap<String, usize>),
}

program::table! {
    /// Numbers of handles n_i = n_0 a^i, rounded (Gjoka et al. 2024, section 4.5).
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Growing {
        /// n_0.
        first: usize;
        /// a, greater than 1.
        factor: f64, Range::above(1.0);
        /// Number of levels.
        levels: usize, Range::POSITIVE;
    }
}

impl Numbers for HandlesConfig {
    fn numbers(&self) -> Vec<f64> {
        match self {
            Self::Each(count) => count.numbers(),
            Self::Growing(growing) => growing.first.numbers(),
            Self::Tags(tags) => tags.values().flat_map(Numbers::numbers).collect(),
        }
    }
}

/// `vertices` of a level.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected true, false, the name of a tag, or a list of names")]
pub enum VerticesConfig {
    /// All or none.
    All(bool),
    /// Those of some tags.
    Tags(Names),
}

impl Default for VerticesConfig {
    fn default() -> Self {
        Self::All(false)
    }
}

/// How a handle moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum HandleMotion {
    /// Translation and rotation: six variables.
    #[default]
    Rigid,
    /// Translation alone: three variables.
    Translation,
    /// Translation, rotation and how far the surface moves along its normals, so that a chamber grows: seven variables.
    RigidAndOffset,
}

/// What moves on a tag.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moves {
    /// So many handles.
    Handles(usize, HandleMotion),
    /// Every vertex off the rim.
    Vertices,
    /// All along the normals, by one distance.
    Offset,
}

impl LevelConfig {
    /// What moves on a tag in this level, if anything does.
    pub fn moves(&self, tag: &str) -> Option<Moves> {
        if self.offset {
            return Some(Moves::Offset);
        }
        if self.frees(tag) {
            return Some(Moves::Vertices);
        }
        let count = match self.handles.as_ref()? {
            HandlesConfig::Each(count) => *count,
            HandlesConfig::Growing(growing) => growing.first,
            HandlesConfig::Tags(tags) => *tags.get(tag)?,
        };
        Some(Moves::Handles(count, self.motion))
    }

    fn frees(&self, tag: &str) -> bool {
        match &self.vertices {
            VerticesConfig::All(all) => *all,
            VerticesConfig::Tags(tags) => tags.all().iter().any(|name| name == tag),
        }
    }

    /// Whether it simulates another problem than the scene's.
    pub fn has_own_fidelity(&self) -> bool {
        self.degree.is_some() || self.time.is_some() || self.mesh.is_some()
    }

    /// The scene itself on this level's body, without an iteration.
    pub fn at_full_fidelity(&self) -> Self {
        let clone = self.clone();
        Self { degree: None, time: None, mesh: None, body: None, iterations: 0, ..clone }
    }

    /// The levels that it stands for.
    pub fn expand(&self) -> Vec<Self> {
        let Some(HandlesConfig::Growing(growing)) = &self.handles else {
            return vec![self.clone()];
        };
        let level = |count| Self { handles: Some(HandlesConfig::Each(count)), ..self.clone() };
        growing.counts().map(level).collect()
    }

    /// Checks what needs no mesh, for the tags `on` of the shape and the names of the objectives.
    pub fn check(&self, on: &[String], objectives: &[&str]) -> Result<()> {
        let title = KeyPath::list("shape.level");
        let freed: &[String] = match &self.vertices {
            VerticesConfig::All(_) => &[],
            VerticesConfig::Tags(tags) => tags.all(),
        };
        match (&self.handles, &self.vertices) {
            (None, VerticesConfig::All(false)) if self.offset => {}
            _ if self.offset => bail!(misfit!(
                title,
                ": offset = true beside handles or vertices; expected it alone, or motion = \"rigid-and-offset\" \
                 for an offset of each handle"
            )),
            (None, VerticesConfig::All(true)) => {}
            (None, VerticesConfig::Tags(_)) if !freed.is_empty() => {}
            (Some(handles), VerticesConfig::All(false) | VerticesConfig::Tags(_)) => {
                handles.check(on, freed)?;
            }
            (Some(_), VerticesConfig::All(true)) => bail!(misfit!(
                title,
                ": handles beside vertices = true; expected one of them, or vertices = [\"TAG\"] for the \
                 tags without handles"
            )),
            (None, _) => bail!(misfit!(
                title,
                ": expected one handle or more, vertices = true, or offset = true"
            )),
        }
        for tag in freed {
            let known = on.contains(tag);
            ensure!(known, misfit!(title, ": vertices of \"{tag}\": {}", expected(on)));
        }
        self.check_problem(objectives).context(title)
    }

    /// Checks a level of a design of loads alone, for the names of the objectives.
    pub fn check_loads(&self, objectives: &[&str]) -> Result<()> {
        ensure!(
            self.handles.is_none()
                && self.vertices == VerticesConfig::All(false)
                && !self.offset
                && self.motion == HandleMotion::Rigid,
            misfit!(
                KeyPath::list("level"),
                ": handles, vertices, offset or motion without [shape] on: no shape may change"
            )
        );
        self.check_problem(objectives).context(KeyPath::list("level"))
    }

    fn check_problem(&self, objectives: &[&str]) -> Result<()> {
        if let (Some(body), None) = (&self.body, &self.mesh) {
            bail!(misfit!(
                KeyPath::of("body"),
                " = \"{body}\" without mesh; expected mesh = \"FILE.msh\", another mesh of it"
            ));
        }
        check_weights(&self.weights, objectives)
    }

    /// What moves, for the log: "20 handles on left, vertices of skin".
    pub fn describe(&self) -> String {
        let handles = |count: usize| match count {
            1 => "1 handle".to_owned(),
            count => format!("{count} handles"),
        };
        let mut said = Vec::new();
        if self.offset {
            said.push("an offset".to_owned());
        }
        match &self.handles {
            Some(HandlesConfig::Each(count)) => said.push(handles(*count)),
            Some(HandlesConfig::Growing(growing)) => said.push(handles(growing.first)),
            Some(HandlesConfig::Tags(tags)) => {
                said.extend(tags.iter().map(|(tag, n)| format!("{} on {tag}", handles(*n))));
            }
            None => {}
        }
        match &self.vertices {
            VerticesConfig::All(true) => said.push("free vertices".to_owned()),
            VerticesConfig::All(false) => {}
            VerticesConfig::Tags(tags) => {
                said.push(format!("free vertices of {}", tags.all().join(", ")));
            }
        }
        said.join(", ")
    }
}

impl HandlesConfig {
    fn check(&self, on: &[String], freed: &[String]) -> Result<()> {
        let key = KeyPath::list("shape.level").key("handles");
        let tags = match self {
            Self::Each(_) => return Ok(()),
            Self::Growing(growing) => return growing.check(&key),
            Self::Tags(tags) => tags,
        };
        ensure!(!tags.is_empty(), misfit!(key, " = {{}}: expected a number, or one for each tag"));
        for tag in tags.keys() {
            ensure!(
                on.contains(tag),
                misfit!(key, ": \"{tag}\": {}; or first, factor and levels together", expected(on))
            );
            ensure!(
                !freed.contains(tag),
                misfit!(key, " and vertices of \"{tag}\": expected one of them")
            );
        }
        Ok(())
    }
}

impl Growing {
    fn counts(self) -> impl Iterator<Item = usize> {
        let count = move |level: usize| {
            (self.first as f64 * self.factor.powf(level as f64)).round() as usize
        };
        (0..self.levels).map(count)
    }

    fn check(self, key: &KeyPath) -> Result<()> {
        self.check_ranges(key)?;
        let last = self.first as f64 * self.factor.powf((self.levels - 1) as f64);
        ensure!(
            last < 1e6,
            misfit!(key.clone(), ": the last level has {last:.0} handles, more than a million")
        );
        Ok(())
    }
}

/// Checks that factors on weights are of objectives with these names.
pub(super) fn check_weights(weights: &BTreeMap<String, f64>, objectives: &[&str]) -> Result<()> {
    for name in weights.keys() {
        ensure!(
            objectives.contains(&name.as_str()),
            KeyPath::of("weights").key(name).told(format!(
                "weights: there is no objective \"{name}\"; there are {}",
                objectives.join(", ")
            ))
        );
    }
    Ok(())
}

fn expected(on: &[String]) -> String {
    format!("no tag of [shape] on; expected some of {}", on.join(", "))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn level(text: &str) -> LevelConfig {
        toml::from_str(&format!("iterations = 3\n{text}")).unwrap()
    }

    fn problem(text: &str) -> String {
        let on = ["left", "skin"].map(str::to_owned);
        let level = level(text);
        let ranges = level.check_ranges(&KeyPath::list("shape.level")).map_err(Into::into);
        let checked = ranges.and_then(|()| level.check(&on, &["grip", "smooth"]));
        format!("{:#}", checked.unwrap_err())
    }

    #[test]
    fn each_tag_moves_as_its_level_says() {
        let both = level("handles = { left = 20 }\nvertices = \"skin\"");
        assert_eq!(both.moves("left"), Some(Moves::Handles(20, HandleMotion::Rigid)));
        assert_eq!(both.moves("skin"), Some(Moves::Vertices));
        assert_eq!(both.moves("other"), None);
        assert_eq!(both.describe(), "20 handles on left, free vertices of skin");
        let each = level("handles = 5\nmotion = \"translation\"");
        assert_eq!(each.moves("other"), Some(Moves::Handles(5, HandleMotion::Translation)));
        assert_eq!(level("vertices = true").moves("left"), Some(Moves::Vertices));
    }

    /// The published finger: 5, 10, 20, … handles.
    #[test]
    fn handles_grow_from_level_to_level() {
        let levels = level("handles = { first = 5, factor = 2, levels = 4 }").expand();
        let counts: Vec<_> = levels.iter().map(|l| l.moves("skin").unwrap()).collect();
        assert_eq!(counts, [5, 10, 20, 40].map(|n| Moves::Handles(n, HandleMotion::Rigid)));
        let levels = level("handles = { first = 3, factor = 1.5, levels = 3 }").expand();
        let counts: Vec<_> = levels.iter().map(LevelConfig::describe).collect();
        assert_eq!(counts, ["3 handles", "5 handles", "7 handles"]);
        assert_eq!(level("vertices = true").expand().len(), 1);
    }

    #[test]
    fn contradictions_are_refused() {
        for (text, expected) in [
            ("", "expected one handle or more"),
            ("handles = 2\noffset = true", "offset = true beside handles"),
            ("handles = 0", "handles = 0"),
            ("handles = 2\nvertices = true", "handles beside vertices"),
            ("handles = { right = 2 }", "expected some of left, skin"),
            ("handles = { left = 2 }\nvertices = \"left\"", "vertices of \"left\""),
            ("vertices = [\"right\"]", "expected some of left, skin"),
            ("handles = { first = 2, factor = 1, levels = 3 }", "factor = 1: must be above 1"),
            ("handles = { first = 2, factor = 10, levels = 9 }", "more than a million"),
            ("handles = 2\ntime = { steps = 0 }", "steps = 0"),
            ("handles = 2\ntime = { steps = 2, end = -1 }", "end = -1"),
            ("handles = 2\nweights = { grap = 2 }", "there are grip, smooth"),
            ("handles = 2\nweights = { grip = -1 }", "grip = -1"),
        ] {
            let found = problem(text);
            assert!(found.contains(expected), "{text}: {found}");
        }
    }
}
