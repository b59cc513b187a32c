//! `[[objective]]`: what a design is wanted to do.

use std::path::PathBuf;

use anyhow::{Result, ensure};
use serde::{Deserialize, Serialize};

use crate::objective::{Density, DistanceKind, KINDS, Kind, Measure, SmoothnessForm, TimeIntegral};
use crate::schedule::Field;

/// A name, or several.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged, expecting = "needed is a name in quotes, or a list of names")]
pub enum Names {
    /// One name.
    One(String),
    /// A list of names.
    Several(Vec<String>),
}

impl Names {
    /// All names.
    #[must_use]
    pub fn all(&self) -> &[String] {
        match self {
            Self::One(name) => std::slice::from_ref(name),
            Self::Several(names) => names,
        }
    }
}

/// What of the forces of contact counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ForceForm {
    /// The component of their sum along a direction.
    Along,
    /// The square of their sum.
    #[default]
    Squared,
    /// The sum of their squares over nodes.
    SumOfSquares,
}

/// A weighted term of the objective. Each has a `name`, a `weight` in the inverse of
/// the unit of its value, and what it is summed `over` in time. With the measure
/// "rest", areas and volumes are of the rest shape.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
#[allow(missing_docs)] // name, weight and over, of every kind, are documented above
pub enum ObjectiveConfig {
    /// Squared distance of deformed tags to a target surface [m⁴].
    Target {
        name: String,
        weight: f64,
        #[serde(default)]
        over: TimeIntegral,
        /// Tags that should reach the target.
        on: Names,
        /// Target surface, a file in metres.
        target: PathBuf,
        /// What of the distance is interpolated.
        #[serde(default)]
        distance: DistanceKind,
        /// Lattice spacing of the interpolated distance [m].
        #[serde(default = "super::a_millimetre")]
        spacing: f64,
        /// Which areas.
        #[serde(default)]
        measure: Measure,
    },
    /// Squared difference to a wanted displacement [m⁴].
    Displacement {
        name: String,
        weight: f64,
        #[serde(default)]
        over: TimeIntegral,
        /// Tags that should be displaced.
        on: Names,
        /// What is wanted, also in time [m].
        displacement: Field,
        /// The axes that count, such as "xz".
        #[serde(default = "super::all_axes")]
        components: String,
        /// Which areas.
        #[serde(default)]
        measure: Measure,
    },
    /// Squared difference to a wanted position [m⁴].
    Position {
        name: String,
        weight: f64,
        #[serde(default)]
        over: TimeIntegral,
        /// Tags that should be there.
        on: Names,
        /// What is wanted, also in time [m].
        position: Field,
        /// The axes that count, such as "xz".
        #[serde(default = "super::all_axes")]
        components: String,
        /// Which areas.
        #[serde(default)]
        measure: Measure,
    },
    /// Force of contact and friction on tags or bodies [N; N²]; needs [contact].
    ContactForce {
        name: String,
        weight: f64,
        #[serde(default)]
        over: TimeIntegral,
        /// Tags or bodies on which the force acts.
        on: Names,
        /// What of it.
        #[serde(default)]
        form: ForceForm,
        /// Of the form "along"; of any length [1].
        direction: Option<[f64; 3]>,
    },
    /// Squared forces of a barrier wider than that of contact [m⁴]; needs
    /// [contact].
    ContactProxy {
        name: String,
        weight: f64,
        #[serde(default)]
        over: TimeIntegral,
        /// Two or more tags or bodies, apart from each other.
        on: Names,
        /// The barrier.
        #[serde(default)]
        density: Density,
        /// Distance from which on they feel each other [m].
        activation: f64,
    },
    /// Penalty on walls thinner than `minimum` + `activation` [m⁴].
    WallThickness {
        name: String,
        weight: f64,
        #[serde(default)]
        over: TimeIntegral,
        /// Tags on one side of the wall.
        on: Names,
        /// Tags on the other side; without them, each two tags of `on` are the
        /// sides of a wall.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        against: Vec<String>,
        /// The barrier; the log one is infinite at `minimum`.
        #[serde(default)]
        density: Density,
        /// Thinnest admissible wall, of the log barrier [m].
        minimum: Option<f64>,
        /// The penalty starts this far above the minimum [m].
        activation: f64,
        /// Walls of which shape.
        #[serde(default)]
        measure: Measure,
    },
    /// Laplacian of the rest surface of tags [1; m²].
    Smoothness {
        name: String,
        weight: f64,
        #[serde(default)]
        over: TimeIntegral,
        /// Tags to smooth.
        on: Names,
        /// How it is normalised.
        #[serde(default)]
        form: SmoothnessForm,
    },
    /// Barrier between parts of the rest surface that are not adjacent [m⁴].
    Clearance {
        name: String,
        weight: f64,
        #[serde(default)]
        over: TimeIntegral,
        /// Distance below which the barrier acts [m].
        activation: f64,
    },
    /// Volume of bodies or of a chamber [m³], or the squared difference to a wanted
    /// one [m⁶].
    Volume {
        name: String,
        weight: f64,
        #[serde(default)]
        over: TimeIntegral,
        /// A tag, for the chamber behind it; a body; nothing for all bodies.
        on: Option<String>,
        /// The wanted volume [m³].
        volume: Option<f64>,
        /// Of which shape.
        #[serde(default)]
        measure: Measure,
    },
    /// ∫ |P|^q over bodies [Pa^q m³].
    Stress {
        name: String,
        weight: f64,
        #[serde(default)]
        over: TimeIntegral,
        /// A body; nothing for all.
        on: Option<String>,
        /// q, 2 or more [1].
        #[serde(default = "two")]
        power: f64,
    },
    /// Penalty on principal stretches beyond limits [m³].
    StrainLimit {
        name: String,
        weight: f64,
        #[serde(default)]
        over: TimeIntegral,
        /// A body; nothing for all.
        on: Option<String>,
        /// Largest stretch that costs nothing [1].
        largest: f64,
        /// Smallest stretch that costs nothing [1].
        #[serde(default)]
        smallest: f64,
    },
}

fn two() -> f64 {
    2.0
}

/// Name, weight, time integral and row of the table of a term.
macro_rules! common {
    ($self:ident, $($kind:ident),*) => {
        match $self {
            $(Self::$kind { name, weight, over, .. } => (name, *weight, over),)*
        }
    };
}

impl ObjectiveConfig {
    fn common(&self) -> (&str, f64, &TimeIntegral) {
        common!(
            self,
            Target,
            Displacement,
            Position,
            ContactForce,
            ContactProxy,
            WallThickness,
            Smoothness,
            Clearance,
            Volume,
            Stress,
            StrainLimit
        )
    }

    /// The user's name for the term.
    #[must_use]
    pub fn name(&self) -> &str {
        self.common().0
    }

    /// Factor of the term, in the inverse of its unit.
    #[must_use]
    pub fn weight(&self) -> f64 {
        self.common().1
    }

    /// What it is summed over.
    #[must_use]
    pub fn over(&self) -> &TimeIntegral {
        self.common().2
    }

    /// Its row of the table.
    #[must_use]
    pub fn kind(&self) -> &'static Kind {
        &KINDS[match self {
            Self::Target { .. } => 0,
            Self::Displacement { .. } => 1,
            Self::Position { .. } => 2,
            Self::ContactForce { .. } => 3,
            Self::ContactProxy { .. } => 4,
            Self::WallThickness { .. } => 5,
            Self::Smoothness { .. } => 6,
            Self::Clearance { .. } => 7,
            Self::Volume { .. } => 8,
            Self::Stress { .. } => 9,
            Self::StrainLimit { .. } => 10,
        }]
    }

    /// Whether a negative weight has a sense: the term is then maximised.
    fn may_be_maximised(&self) -> bool {
        self.kind().may_be_maximised && !matches!(self, Self::Volume { volume: Some(_), .. })
    }

    /// Checks what can be checked without a body.
    ///
    /// # Errors
    /// With what was found and what is needed.
    pub fn check(&self) -> Result<()> {
        let (name, weight, _) = self.common();
        let own = format!("objective \"{name}\"");
        ensure!(weight.is_finite(), "{own}: weight = {weight}: must be a finite number");
        ensure!(
            weight >= 0.0 || self.may_be_maximised(),
            "{own}: weight = {weight}: a negative weight maximises a term, which makes sense for \
             {} only",
            maximised()
        );
        for (key, value) in self.lengths() {
            ensure!(value.is_finite() && value > 0.0, "{own}: {key} = {value} m must be positive");
        }
        match self {
            Self::Displacement { components, .. } | Self::Position { components, .. } => {
                let axes = axes(components);
                ensure!(
                    components.len() == axes.iter().filter(|a| **a).count()
                        && !components.is_empty(),
                    "{own}: components = \"{components}\": must be some of x, y, z, each once"
                );
            }
            Self::ContactForce { form, direction, .. } => match (form, direction) {
                (ForceForm::Along, None) => {
                    anyhow::bail!("{own}: form = \"along\" needs direction = [x, y, z]")
                }
                (ForceForm::Along, Some(d)) => ensure!(
                    d.iter().all(|x| x.is_finite()) && d.iter().any(|x| *x != 0.0),
                    "{own}: direction = {d:?}: must be finite, and not zero"
                ),
                (_, direction) => ensure!(
                    direction.is_none(),
                    "{own}: direction is for form = \"along\" only; remove one of them"
                ),
            },
            Self::ContactProxy { on, .. } => ensure!(
                on.all().len() > 1,
                "{own}: on = {:?}: needed are two tags or more that should press on each other",
                on.all()
            ),
            Self::WallThickness { on, against, density, minimum, .. } => {
                ensure!(
                    !against.is_empty() || on.all().len() > 1,
                    "{own}: on = {:?}: one side of a wall; name the other by against = [...], or \
                     two tags or more in on",
                    on.all()
                );
                ensure!(
                    minimum.is_some() == (*density == Density::Log),
                    "{own}: density = \"log\" needs a minimum [m], \"quadratic\" has none"
                );
            }
            Self::Stress { power, .. } => ensure!(
                power.is_finite() && *power >= 2.0,
                "{own}: power = {power}: must be 2 or more"
            ),
            Self::StrainLimit { largest, smallest, .. } => ensure!(
                (0.0..1.0).contains(smallest) && largest.is_finite() && *largest > 1.0,
                "{own}: largest = {largest}, smallest = {smallest}: stretches, the largest must be \
                 above 1 and the smallest from 0 to 1"
            ),
            _ => {}
        }
        Ok(())
    }

    /// Lengths that must be positive, and a volume.
    fn lengths(&self) -> Vec<(&'static str, f64)> {
        match self {
            Self::Target { spacing, .. } => vec![("spacing", *spacing)],
            Self::ContactProxy { activation, .. } | Self::Clearance { activation, .. } => {
                vec![("activation", *activation)]
            }
            Self::WallThickness { minimum, activation, .. } => {
                let minimum = minimum.map(|minimum| ("minimum", minimum));
                minimum.into_iter().chain([("activation", *activation)]).collect()
            }
            _ => Vec::new(),
        }
    }
}

/// Which of x, y, z are named.
#[must_use]
pub fn axes(components: &str) -> [bool; 3] {
    ['x', 'y', 'z'].map(|axis| components.contains(axis))
}

/// Kinds whose weight may be negative, for messages.
fn maximised() -> String {
    let kinds = KINDS.iter().filter(|kind| kind.may_be_maximised).map(|kind| kind.key);
    kinds.collect::<Vec<_>>().join(", ") + " (without a wanted one)"
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// A term of each kind with all that it needs.
    const SOUND: [&str; 11] = [
        "kind = 'target'\non = 'a'\ntarget = 'a.stl'\ndistance = 'signed'",
        "kind = 'displacement'\non = ['a', 'b']\ndisplacement = [0.03, '0.1*t', 0]\nover = 'simpson'",
        "kind = 'position'\non = 'a'\nposition = [0, 0, 1]\ncomponents = 'zx'\nmeasure = 'deformed'",
        "kind = 'contact-force'\non = 'a'\nform = 'along'\ndirection = [0, 0, 1]",
        "kind = 'contact-proxy'\non = ['a', 'b']\nactivation = 1e-3\nover = { steps = [53, 54] }",
        "kind = 'wall-thickness'\non = 'a'\nagainst = ['b']\nminimum = 1e-3\nactivation = 1e-3",
        "kind = 'smoothness'\non = 'a'\nform = 'plain'",
        "kind = 'clearance'\nactivation = 1e-4",
        "kind = 'volume'\non = 'a'\nvolume = 1e-6",
        "kind = 'stress'\npower = 8",
        "kind = 'strain-limit'\nlargest = 3",
    ];

    fn read(text: &str, weight: &str) -> Result<ObjectiveConfig> {
        let config: ObjectiveConfig =
            toml::from_str(&format!("name = 'n'\nweight = {weight}\n{text}"))?;
        config.check().map(|()| config)
    }

    #[test]
    fn every_kind_is_read_and_has_its_row() {
        assert_eq!(SOUND.len(), KINDS.len());
        for (text, kind) in SOUND.iter().zip(KINDS) {
            let config = read(text, "2").unwrap();
            assert_eq!((config.kind().key, config.name(), config.weight()), (kind.key, "n", 2.0));
            let written = toml::Table::try_from(&config).unwrap();
            assert_eq!(written["kind"].as_str(), Some(kind.key));
            // what may be written is what is listed
            let mut keys: Vec<&str> = kind.keys.iter().map(|k| k.0).collect();
            keys.extend(["kind", "name", "weight", "over"]);
            let unknown = written.keys().find(|key| !keys.contains(&key.as_str()));
            assert_eq!(unknown, None, "{}", kind.key);
            let error = read(&format!("{text}\nodd = 1"), "1").unwrap_err().to_string();
            let all = keys.iter().filter(|key| **key != "kind");
            all.for_each(|key| assert!(error.contains(&format!("`{key}`")), "{key}: {error}"));
        }
        assert_eq!(*read(SOUND[1], "1").unwrap().over(), TimeIntegral::Simpson);
        assert_eq!(*read(SOUND[4], "1").unwrap().over(), TimeIntegral::Steps(vec![53, 54]));
        assert_eq!(*read(SOUND[0], "1").unwrap().over(), TimeIntegral::Final);
    }

    #[test]
    fn only_what_can_be_maximised_may_weigh_less_than_nothing() {
        let open = "kind = 'volume'\non = 'a'";
        for text in SOUND.iter().chain([&open]) {
            let may = text.contains("contact") || *text == open;
            assert_eq!(read(text, "-1").is_ok(), may, "{text}");
            assert!(read(text, "nan").unwrap_err().to_string().contains("NaN"));
        }
    }

    #[test]
    fn what_makes_no_sense_is_refused_with_what_is_needed() {
        for (row, from, to, words) in [
            (0, "distance = 'signed'", "spacing = 0", "spacing = 0 m must be positive"),
            (2, "'zx'", "'zz'", "some of x, y, z"),
            (2, "'zx'", "''", "some of x, y, z"),
            (3, "direction = [0, 0, 1]", "", "needs direction"),
            (3, "[0, 0, 1]", "[0, 0, 0]", "not zero"),
            (3, "'along'", "'squared'", "for form = \"along\" only"),
            (4, "['a', 'b']", "'a'", "two tags or more"),
            (4, "1e-3", "inf", "activation = inf m"),
            (5, "against = ['b']", "", "one side of a wall"),
            (5, "minimum = 1e-3", "", "needs a minimum"),
            (5, "minimum = 1e-3", "minimum = -1.0", "minimum = -1 m"),
            (5, "minimum = 1e-3", "minimum = 1e-3\ndensity = 'quadratic'", "has none"),
            (9, "8", "1.5", "2 or more"),
            (10, "3", "0.9", "above 1"),
            (10, "3", "3\nsmallest = 1.5", "from 0 to 1"),
        ] {
            let text = SOUND[row].replace(from, to);
            assert_ne!(text, SOUND[row]);
            let error = read(&text, "1").unwrap_err().to_string();
            assert!(error.contains(words), "{text}: {error}");
        }
    }
}
