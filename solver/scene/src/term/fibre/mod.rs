//! `[[fibre]]`: a family of fibres in a body or volume, beside its law.
//!
//! | name of a cell field | is | unit |
//! |-|-|-|
//! | `fibre_NAME_direction` | mean of a₀ at rest, zero where the family is not | 1 |
//! | `fibre_NAME_stretch` | mean of √I₄, 1 where the family is not | 1 |
//! | `fibre_NAME_stress` | mean of the force of the fibres per rest area across them | Pa |

mod build; // families of a body
mod directions; // vectors from a file

use std::path::PathBuf;

use anyhow::{Result, bail, ensure};
use mechanics::energy::{
    Axis, Directions, FibreMean, FibreSummary, Fibres, Iterate, Profile, Term,
};
use mechanics::material::fibre::{Fibre, LARGEST_DISPERSION};
use mechanics::material::slack::DEFAULT_SLACK;
use mesh::Vec3;
use mesh::io::vtu::Field;
use program::table::{Range, direction, nested};
use program::{KeyPath, Misfit, misfit};
use reports::Terms;

use super::direction::{ANGLE, AXIS, Leads};
use super::line::AroundConfig;
use super::profile::Along;
use super::values::Values;
use super::{
    About, Around, Ground, Room, RoomNumber, Stage, State, along, check_names, each, owned, value,
};

program::table! {
    /// A family of fibres: energy per rest volume k1/(2 k2) (exp(k2 E²) − 1) of the strain E = κ I1 + (1 − 3κ) I4 − 1,
    /// beside that of the law. Several tables make several families. Stresses of result files are those of the law.
    #[derive(Clone, Debug)]
    pub struct FibreConfig {
        /// What numbers, reports and result files call it.
        name: String;
        /// The body or volume, which has a law of its own.
        on: Option<String> = None => "all";
        /// The same direction everywhere, a vector of any length; or `around` or `file`.
        direction: Option<[f64; 3]> = None, direction;
        /// An axis, with `angle` or `radial`.
        around: Option<AroundConfig> = None, nested;
        /// Angle between fibres and the axis [°]: 0 along it, 90 around it; positive for a right-handed screw. A table makes it
        /// change along the axis.
        angle: Option<Along> = None, ANGLE;
        /// Whether fibres lead away from the axis.
        radial: bool = false;
        /// A file of vectors of any length: a `.npy` with three columns and a row for each tetrahedron or each vertex, in the
        /// order of the mesh, or a `.vtu` with `field`.
        file: Option<PathBuf> = None;
        /// Name of the vectors of the cells or points in a `.vtu`.
        field: Option<String> = None;
        /// Stiffness k1 [Pa]. At small strain, fibres add 4 k1 to Young's modulus along them. A table makes it change along
        /// the axis of `around`, or along its own `line`.
        k1: Along, Range::POSITIVE.unit("Pa");
        /// By how much the stiffness grows with strain [1]; 0 is the standard reinforcing model, ½ k1 E².
        k2: f64 = 0.0, Range::NOT_NEGATIVE.advice("; 0 is a stiffness that does not grow");
        /// Dispersion κ [1], from 0 (all along the direction) to 1/3 (none preferred).
        dispersion: f64 = 0.0, dispersion;
        /// Whether fibres carry compression, too.
        compression: bool = false;
        /// Strain E over which fibres become taut, where they carry tension only [1].
        slack: Option<f64> = None => "1e-3, an elongation of 0.05 %",
            Range::above(0.0).at_most(1.0).advice("; the strain over which fibres become taut, such as 1e-3");
    }
}

fn dispersion(at: &KeyPath, dispersion: &f64) -> Result<(), Misfit> {
    match (0.0..=LARGEST_DISPERSION + 1e-12).contains(dispersion) {
        true => Ok(()),
        false => Err(misfit!(
            at.clone(),
            " = {dispersion}: must be from 0 (all fibres along the direction) to 1/3 (none preferred)"
        )),
    }
}

impl FibreConfig {
    /// What messages call it.
    pub fn title(&self) -> KeyPath {
        KeyPath::list("fibre").named(&self.name)
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
        profile.build(&self.title().key("k1"), self.axis()).map(Some)
    }

    /// The axis of `around`.
    fn axis(&self) -> Option<Axis> {
        self.around.as_ref().map(AroundConfig::line)
    }

    /// The angle along the axis [rad], where it is no number.
    fn twist(&self) -> Result<Option<Profile>> {
        let Some(profile) = self.angle.as_ref().and_then(Along::profile) else { return Ok(None) };
        let key = |key: &str| self.title().key(key);
        ensure!(!self.radial, misfit!(key("radial"), " beside angle: expected one of both"));
        let built = profile.build(&key("angle"), self.axis())?;
        Ok(Some(built.times(1.0_f64.to_radians())))
    }

    /// Where the fibres lead by a formula of the place; none where a file says it.
    fn leads(&self) -> Result<Option<Directions>> {
        let key = |key: &str| self.title().key(key);
        let ways = [
            ("direction", self.direction.is_some()),
            ("around", self.around.is_some()),
            ("file", self.file.is_some()),
        ];
        let mut given = ways.into_iter().filter(|(_, has)| *has).map(|(name, _)| name);
        let way = given.next();
        if let (Some(way), Some(other)) = (way, given.next()) {
            bail!(misfit!(key(way), " beside {other}: expected one of both"));
        }
        self.check_companions()?;
        if let Some(angle) = self.twist()? {
            return Ok(Some(Directions::Twisting(angle)));
        }
        if self.direction.is_some() || self.around.is_some() {
            let Self { direction, around, angle, radial, .. } = self;
            let (direction, around) = (*direction, around.as_ref());
            let angle = angle.as_ref().map(|angle| angle.values()[0]);
            let leads = Leads { direction, around, angle, radial: *radial };
            return Ok(Some(leads.field(&self.title())?.into()));
        }
        ensure!(
            self.file.is_some(),
            misfit!(
                self.title(),
                " has no direction: expected direction = [x, y, z], around = {{ point = …, axis = … }} with angle, \
                 or file = \"directions.npy\""
            )
        );
        Ok(None)
    }

    /// Refuses keys that belong to another way to give the direction.
    fn check_companions(&self) -> Result<()> {
        const FILE: &str = "a file: add file = \"directions.vtu\"";
        let axis = format!("an axis: {AXIS}");
        let companions = [
            ("angle", self.angle.is_some() && self.around.is_none(), &*axis),
            ("radial", self.radial && self.around.is_none(), &*axis),
            ("field", self.field.is_some() && self.file.is_none(), FILE),
        ];
        match companions.into_iter().find(|(_, is_alone, _)| *is_alone) {
            Some((key, _, what)) => bail!(misfit!(self.title().key(key), " without {what}")),
            None => Ok(()),
        }
    }

    fn in_words(&self) -> String {
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
}

impl Room for Vec<FibreConfig> {
    fn about(&self) -> About {
        About {
            list: "fibre",
            stage: Stage::Body,
            paths: "fibre.NAME.k1, .k2, .dispersion or .angle",
            meaning: "a number of the law of a [[fibre]], or its angle to an axis; of values along an axis, with the place in \
              their list, as in fibre.weave.k1.2",
            example: "[[fibre]]\nname = \"weave\"\naround = { point = [-0.02, -0.03, 0], axis = [0, 0, 1] }\nangle = 30\nk1 = 2e4\nk2 = 1\n\
         dispersion = 0.1\ncompression = true\n",
        }
    }

    fn in_words(&self) -> Vec<String> {
        self.iter().map(FibreConfig::in_words).collect()
    }

    fn check(&self, _: &Around) -> Result<()> {
        check_names("fibre", self.iter().map(|fibre| &fibre.name))?;
        for fibre in self {
            ensure!(
                fibre.slack.is_none() || !fibre.compression,
                misfit!(
                    fibre.title().key("slack"),
                    " beside compression = true: such fibres are never slack"
                )
            );
            fibre.leads()?;
            fibre.stiffness()?;
        }
        Ok(())
    }

    fn stress(&self, _: f64, _: &Values) -> f64 {
        self.iter().flat_map(|fibre| fibre.k1.values()).copied().fold(0.0, f64::max)
    }

    fn build(&self, ground: &Ground, _: usize) -> Result<Vec<Term>> {
        Ok(owned("fibre", build::families(self, ground)?))
    }

    fn numbers(&mut self) -> Vec<RoomNumber<'_>> {
        each(self, |_, FibreConfig { name, k1, k2, dispersion, angle, .. }| {
            let law = [value("k2", "1", k2), value("dispersion", "1", dispersion)];
            let angles = angle.iter_mut().flat_map(|angle| along("angle", "°", angle));
            (name.clone(), along("k1", "Pa", k1).chain(law).chain(angles).collect())
        })
    }

    fn report(&self, State { energies, at }: State, terms: &mut Terms) {
        let one = |family: &Fibres| {
            let FibreSummary { volume, energy, stretch, stress, taut } = family.summary(at);
            reports::Fibre { name: family.name.clone(), volume, energy, stretch, stress, taut }
        };
        terms.fibres = (!self.is_empty()).then(|| energies.each().map(one).collect());
    }

    fn fields(&self, State { energies, at }: State) -> Vec<Field> {
        energies.each().flat_map(|family| fields_of(family, at)).collect()
    }
}

/// The fields of the cells of a family, of all elements.
fn fields_of(family: &Fibres, at: &Iterate) -> [Field; 3] {
    let elsewhere = FibreMean { direction: Vec3::zeros(), stretch: 1.0, stress: 0.0 };
    let mut means = vec![elsewhere; at.space.tets().len()];
    means[family.elements()].copy_from_slice(&family.means(at));
    let field = |name: &str, unit: &str, components: usize, values: Vec<f64>| Field {
        name: format!("fibre_{}_{name}", family.name),
        unit: unit.to_owned(),
        components,
        values,
    };
    let directions = means.iter().flat_map(|mean| <[f64; 3]>::from(mean.direction)).collect();
    [
        field("direction", "1", 3, directions),
        field("stretch", "1", 1, means.iter().map(|mean| mean.stretch).collect()),
        field("stress", "Pa", 1, means.iter().map(|mean| mean.stress).collect()),
    ]
}
