//! `[[fibre]]`: a family of fibres in a body or volume, beside its law.

use std::path::PathBuf;

use anyhow::{Result, ensure};
use mechanics::energy::{Axis, Direction, Profile};
use mechanics::material::fibre::{Fibre, LARGEST_DISPERSION};
use mechanics::material::slack::DEFAULT_SLACK;
use program::{KeyPath, misfit};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::SimConfig;
use super::line::{AroundConfig, unit};
use super::profile::Along;

/// Most that an angle to an axis may be [°].
const MOST_DEGREES: f64 = 360.0;

/// A family of fibres: energy per rest volume k1/(2 k2) (exp(k2 E²) − 1) of the strain E = κ I1 + (1 − 3κ) I4 − 1,
/// beside that of the law. Several tables make several families. Stresses of result files are those of the law.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FibreConfig {
    /// What numbers, reports and result files call it.
    pub name: String,
    /// The body or volume, which has a law of its own; all of them if not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub on: Option<String>,
    /// The same direction everywhere, a vector of any length; or `around` or `file`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub direction: Option<[f64; 3]>,
    /// An axis, with `angle` or `radial`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub around: Option<AroundConfig>,
    /// Angle between fibres and the axis [°]: 0 along it, 90 around it; positive for a right-handed screw. A table makes it
    /// change along the axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle: Option<Along>,
    /// Whether fibres lead away from the axis.
    #[serde(default)]
    pub radial: bool,
    /// A file of vectors of any length: a `.npy` with three columns and a row for each tetrahedron or each vertex, in the
    /// order of the mesh, or a `.vtu` with `field`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<PathBuf>,
    /// Name of the vectors of the cells or points in a `.vtu`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub field: Option<String>,
    /// Stiffness k1 [Pa]. At small strain, fibres add 4 k1 to Young's modulus along them. A table makes it change along
    /// the axis of `around`, or along its own `line`.
    pub k1: Along,
    /// By how much the stiffness grows with strain [1]; 0 is the standard reinforcing model, ½ k1 E².
    #[serde(default)]
    pub k2: f64,
    /// Dispersion κ [1], from 0 (all along the direction) to 1/3 (none preferred).
    #[serde(default)]
    pub dispersion: f64,
    /// Whether fibres carry compression, too.
    #[serde(default)]
    pub compression: bool,
    /// Strain E over which fibres become taut, where they carry tension only [1]: 1e-3 if not given, an
    /// elongation of 0.05 %.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slack: Option<f64>,
}

/// Where the directions of fibres come from.
#[derive(Clone, Debug)]
pub enum Source {
    /// By a formula of the place.
    Formula(Direction),
    /// Around an axis, at an angle [rad] that changes along it.
    Twisting(Profile),
    /// As a file says.
    File(PathBuf),
}

impl FibreConfig {
    /// What messages call it.
    pub fn title(&self) -> KeyPath {
        KeyPath::list("fibre").named(&self.name)
    }

    /// What reports and messages call it.
    pub fn in_words(&self) -> String {
        let Self { name, on, angle, k1, k2, dispersion, .. } = self;
        let on = on.as_ref().map_or_else(String::new, |on| format!(" in {on}"));
        let leads = match (self.direction, angle, &self.file) {
            (Some([x, y, z]), ..) => format!("along ({x}, {y}, {z})"),
            (None, Some(angle), _) => {
                format!("at {}° to an axis", angle.in_words(|angle| angle.to_string()))
            }
            (None, None, Some(file)) => format!("as {} says", file.display()),
            (None, None, None) => "away from an axis".to_owned(),
        };
        let k1 = k1.in_words(|k1| format!("{k1:.3e}"));
        let senses = if self.compression { ", in both senses" } else { ", in tension only" };
        format!("fibre {name}{on}: {leads}, k1 {k1} Pa, k2 {k2}, dispersion {dispersion}{senses}")
    }

    /// The law; of a k1 that changes along an axis with the first value, in place of which a family has
    /// [`Self::stiffness`].
    pub fn law(&self) -> Fibre {
        let Self { k2, dispersion, compression, slack, .. } = *self;
        let slack = (!compression).then(|| slack.unwrap_or(DEFAULT_SLACK));
        let k1 = self.k1.values().first().copied().unwrap_or_default();
        Fibre { k1, k2, dispersion, slack }
    }

    /// k1 along an axis [Pa], where it is no number: that of `around`, or its own.
    pub fn stiffness(&self) -> Result<Option<Profile>> {
        let Some(profile) = self.k1.profile() else { return Ok(None) };
        profile.build(&self.title().key("k1"), self.axis()?).map(Some)
    }

    /// The axis of `around`.
    fn axis(&self) -> Result<Option<Axis>> {
        self.around.as_ref().map(|around| around.line(&self.title())).transpose()
    }

    /// The angle along the axis [rad], where it is no number.
    fn twist(&self) -> Result<Option<Profile>> {
        let Some(profile) = self.angle.as_ref().and_then(Along::profile) else { return Ok(None) };
        let key = |key: &str| self.title().key(key);
        ensure!(!self.radial, misfit!(key("radial"), " beside angle: expected one of both"));
        let built = profile.build(&key("angle"), self.axis()?)?;
        for (place, angle) in profile.values.iter().enumerate() {
            ensure!(
                angle.abs() <= MOST_DEGREES,
                misfit!(
                    key("angle").key("values"),
                    ": value {} is {angle}°; all must be from -{MOST_DEGREES} to {MOST_DEGREES}",
                    place + 1
                )
            );
        }
        Ok(Some(built.times(1.0_f64.to_radians())))
    }

    /// Where the fibres lead.
    pub fn leads(&self) -> Result<Source> {
        let key = |key: &str| self.title().key(key);
        let ways = [
            ("direction", self.direction.is_some()),
            ("around", self.around.is_some()),
            ("file", self.file.is_some()),
        ];
        let mut given = ways.into_iter().filter(|(_, has)| *has).map(|(name, _)| name);
        let way = given.next();
        if let (Some(way), Some(other)) = (way, given.next()) {
            return Err(misfit!(key(way), " beside {other}: expected one of both").into());
        }
        self.check_companions()?;
        if let Some(angle) = self.twist()? {
            return Ok(Source::Twisting(angle));
        }
        if self.direction.is_some() || self.around.is_some() {
            let Self { direction, around, angle, radial, .. } = self;
            let (direction, around) = (*direction, around.as_ref());
            let angle = angle.as_ref().map(|angle| angle.values()[0]);
            let leads = Leads { direction, around, angle, radial: *radial };
            return Ok(Source::Formula(leads.field(&self.title())?));
        }
        match &self.file {
            Some(file) => Ok(Source::File(file.clone())),
            None => Err(misfit!(
                self.title(),
                " has no direction: expected direction = [x, y, z], around = {{ point = …, axis = … }} with angle, \
                 or file = \"directions.npy\""
            )
            .into()),
        }
    }

    /// Refuses keys that belong to another way to give the direction.
    fn check_companions(&self) -> Result<()> {
        let key = |key: &str| self.title().key(key);
        let axis = "add around = { point = [0, 0, 0], axis = [0, 0, 1] }";
        ensure!(
            self.angle.is_none() || self.around.is_some(),
            misfit!(key("angle"), " without an axis: {axis}")
        );
        ensure!(
            !self.radial || self.around.is_some(),
            misfit!(key("radial"), " without an axis: {axis}")
        );
        ensure!(
            self.field.is_none() || self.file.is_some(),
            misfit!(key("field"), " without a file: add file = \"directions.vtu\"")
        );
        Ok(())
    }

    /// Whether the numbers of the law are admissible.
    fn check_law(&self) -> Result<()> {
        let key = |key: &str| self.title().key(key);
        let Self { k2, dispersion, .. } = *self;
        let positive = |k1: f64| k1 > 0.0 && k1.is_finite();
        match &self.k1 {
            Along::Number(k1) => ensure!(
                positive(*k1),
                misfit!(key("k1"), " = {k1} Pa: must be positive and finite")
            ),
            Along::Profile(profile) => {
                for (place, k1) in profile.values.iter().enumerate() {
                    ensure!(
                        positive(*k1),
                        misfit!(
                            key("k1").key("values"),
                            ": value {} is {k1} Pa; all must be positive and finite",
                            place + 1
                        )
                    );
                }
            }
        }
        ensure!(
            k2 >= 0.0 && k2.is_finite(),
            misfit!(
                key("k2"),
                " = {k2}: must not be negative; 0 is a stiffness that does not grow"
            )
        );
        ensure!(
            (0.0..=LARGEST_DISPERSION + 1e-12).contains(&dispersion),
            misfit!(
                key("dispersion"),
                " = {dispersion}: must be from 0 (all fibres along the direction) to 1/3 (none preferred)"
            )
        );
        ensure!(
            self.slack.is_none_or(|slack| slack > 0.0 && slack <= 1.0),
            misfit!(
                key("slack"),
                " = {}: must be above 0 and at most 1; the strain over which fibres become taut, such as 1e-3",
                self.slack.unwrap_or_default()
            )
        );
        ensure!(
            self.slack.is_none() || !self.compression,
            misfit!(key("slack"), " beside compression = true: such fibres are never slack")
        );
        Ok(())
    }
}

/// Keys of a direction field.
pub(super) struct Leads<'a> {
    /// The same direction everywhere.
    pub direction: Option<[f64; 3]>,
    /// An axis.
    pub around: Option<&'a AroundConfig>,
    /// Angle to it [°].
    pub angle: Option<f64>,
    /// Whether it leads away from it.
    pub radial: bool,
}

impl Leads<'_> {
    /// Whether any of them is given.
    pub fn any(&self) -> bool {
        let Self { direction, around, angle, radial } = self;
        direction.is_some() || around.is_some() || angle.is_some() || *radial
    }

    /// The field.
    pub fn field(&self, title: &KeyPath) -> Result<Direction> {
        let key = |key: &str| title.clone().key(key);
        match (self.direction, self.around) {
            (Some(direction), None) => {
                ensure!(
                    self.angle.is_none(),
                    misfit!(key("angle"), " without an axis: add around = {{ point = [0, 0, 0], axis = [0, 0, 1] }}")
                );
                ensure!(!self.radial, misfit!(key("radial"), " without an axis: expected around, not direction"));
                Ok(Direction::Constant(unit(direction, &key("direction"))?))
            }
            (None, Some(around)) => {
                let axis = around.line(title)?;
                match (self.angle, self.radial) {
                    (Some(angle), false) => {
                        ensure!(
                            angle.is_finite() && angle.abs() <= MOST_DEGREES,
                            misfit!(
                                key("angle"),
                                " = {angle}°: must be from -{MOST_DEGREES} to {MOST_DEGREES}"
                            )
                        );
                        Ok(Direction::Helical(axis, angle.to_radians()))
                    }
                    (None, true) => Ok(Direction::Radial(axis)),
                    (Some(_), true) => Err(misfit!(key("radial"), " beside angle: expected one of both").into()),
                    (None, false) => Err(misfit!(
                        key("around"),
                        " without angle: expected angle = 0 (along the axis) to 90 (around it), or radial = true"
                    )
                    .into()),
                }
            }
            (Some(_), Some(_)) => Err(misfit!(key("direction"), " beside around: expected one of both").into()),
            (None, None) if self.angle.is_some() => Err(misfit!(
                key("angle"),
                " without an axis: add around = {{ point = [0, 0, 0], axis = [0, 0, 1] }}"
            )
            .into()),
            (None, None) => Err(misfit!(
                title.clone(),
                " has no direction: expected direction = [x, y, z], or around = {{ point = …, axis = … }} with angle"
            )
            .into()),
        }
    }
}

/// Refuses names that are empty, given twice, or would split the path of a number.
pub(super) fn check_names<'a>(list: &str, names: impl Iterator<Item = &'a String>) -> Result<()> {
    let mut known: Vec<&String> = Vec::new();
    for name in names {
        let key = KeyPath::list(list).named(name).key("name");
        ensure!(
            !name.is_empty() && !name.contains('.'),
            misfit!(key, " = \"{name}\": a name has one letter or more, and no dot")
        );
        ensure!(!known.contains(&name), misfit!(key, ": two [[{list}]] are called \"{name}\""));
        known.push(name);
    }
    Ok(())
}

impl SimConfig {
    /// Checks what can be checked of fibres without a body.
    pub fn check_fibres(&self) -> Result<()> {
        check_names("fibre", self.fibre.iter().map(|fibre| &fibre.name))?;
        for fibre in &self.fibre {
            fibre.check_law()?;
            fibre.leads()?;
            fibre.stiffness()?;
        }
        Ok(())
    }
}
