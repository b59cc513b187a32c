//! `[[membrane]]`: a thin sheet that is bonded to a tag.

mod build; // sheets of a body

use crate::law_table;
use anyhow::{Context, Result, bail, ensure};
use program::schema::one_of;
use program::table::{Range, direction, nested};
use program::{KeyPath, misfit};
use schemars::{Schema, SchemaGenerator};
use toml::Value;

use mechanics::energy::{Direction, Membrane, MembraneSummary, Term};
use mechanics::material::sheet::{LAWS, Specification, Strain};
use reports::Terms;

use super::direction::{ANGLE, Leads};
use super::line::AroundConfig;
use super::values::Values;
use super::{About, Around, Ground, Room, RoomNumber, Stage, State, each, owned, value};

program::table! {
    /// A sheet bonded to facets, on the boundary or inside.
    #[derive(Clone, Debug)]
    pub struct MembraneConfig {
        /// Tag of the facets, or a body for its whole boundary.
        on: String;
        /// Thickness at rest [m].
        thickness: f64, Range::POSITIVE.unit("m").advice("; expected that of the sheet, such as 1e-4 for paper");
        /// `kind` and the parameters of a law of `solver list --sheets`.
        #[schemars(schema_with = "laws")]
        material: Value;
        /// Whether it wrinkles rather than carry compression.
        tension: bool = false;
        /// Of a law with a warp, the direction of that: a vector of any length, of which the part in the sheet counts; or
        /// `around`.
        direction: Option<[f64; 3]> = None, direction;
        /// An axis, with `angle` or `radial`.
        around: Option<AroundConfig> = None, nested;
        /// Angle between warp and axis [°]: 0 along it, 90 around it; positive for a right-handed screw.
        angle: Option<f64> = None, ANGLE;
        /// Whether the warp leads away from the axis.
        radial: bool = false;
    }
}

fn laws(_: &mut SchemaGenerator) -> Schema {
    one_of(LAWS.iter().map(law_table::schema))
}

impl MembraneConfig {
    /// What messages call it.
    pub fn title(&self) -> KeyPath {
        KeyPath::list("membrane").on(&self.on)
    }

    /// Along the warp, where the law has one.
    pub fn leads(&self) -> Result<Option<Direction>> {
        let Self { direction, around, angle, radial, .. } = self;
        let (direction, around) = (*direction, around.as_ref());
        let leads = Leads { direction, around, angle: *angle, radial: *radial };
        let law = self.specification()?;
        if law.build(false).has_axes() {
            return leads.field(&self.title()).map(Some);
        }
        ensure!(
            !leads.any(),
            misfit!(
                self.title(),
                ": a direction beside kind = \"{}\", which is the same along all; expected kind = \"woven\", or no \
                 direction, around, angle and radial",
                law.law.key
            )
        );
        Ok(None)
    }

    /// The law with its parameters.
    pub fn specification(&self) -> Result<Specification> {
        let Value::Table(table) = &self.material else {
            bail!(misfit!(
                self.title().key("material"),
                " = {}: expected a table with kind and parameters of a sheet, as in material = {{ kind = \
                 \"sheet\", young = 3e9, poisson = 0.3 }}; `solver list --sheets` names the laws",
                self.material
            ));
        };
        law_table::sheet(table).with_context(|| self.title().key("material"))
    }

    fn in_words(&self) -> Option<String> {
        let Self { on, thickness, angle, tension, .. } = self;
        let Specification { law, values } = self.specification().ok()?;
        let numbers = law.named(&values).into_iter();
        let numbers = numbers.map(|(p, v)| match p.unit {
            "1" => format!("{} {}", p.name, v[0]),
            unit => format!("{} {:.3e} {unit}", p.name, v[0]),
        });
        Some(format!(
            "membrane on {on}: {:.3} mm, {} ({}){}{}",
            1e3 * thickness,
            law.key,
            numbers.collect::<Vec<_>>().join(", "),
            angle.map_or_else(String::new, |angle| format!(", warp at {angle}° to an axis")),
            if *tension { ", in tension only" } else { "" }
        ))
    }
}

impl Room for Vec<MembraneConfig> {
    fn about(&self) -> About {
        About {
            list: "membrane",
            stage: Stage::Body,
            paths: "membrane.TAG.thickness, .PARAMETER or .angle",
            meaning: "the thickness of the sheet on a tag, a parameter of its law, or the angle of its warp to an axis",
            example: "[[membrane]]\non = \"top\"\nthickness = 1e-4\nmaterial = { kind = \"sheet\", young = 1e6, poisson = 0.3 }\n",
        }
    }

    fn in_words(&self) -> Vec<String> {
        self.iter().filter_map(MembraneConfig::in_words).collect()
    }

    fn check(&self, around: &Around) -> Result<()> {
        for membrane in self {
            membrane.leads()?;
            ensure!(
                around.cuts.iter().flatten().all(|cut| *cut != membrane.on),
                misfit!(
                    membrane.title(),
                    ": the tag is a cut of [[symmetry]], where the whole body goes on: there is no surface \
                     to bond a sheet to; expected another tag, or the whole body (solver mirror) for a \
                     sheet in the plane of symmetry"
                )
            );
        }
        Ok(())
    }

    /// Force per width of a sheet over the size.
    fn stress(&self, size: f64, _: &Values) -> f64 {
        let stiffness = |sheet: &MembraneConfig| {
            let law = sheet.specification().ok()?.build(false);
            Some(law.tangent(&Strain::zeros()).max() * sheet.thickness / size)
        };
        self.iter().filter_map(stiffness).fold(0.0, f64::max)
    }

    fn build(&self, ground: &Ground, _: usize) -> Result<Vec<Term>> {
        let sheets = self.iter().map(|membrane| build::sheet(membrane, self, ground));
        Ok(owned("membrane", sheets.collect::<Result<Vec<_>>>()?))
    }

    fn numbers(&mut self) -> Vec<RoomNumber<'_>> {
        each(self, |_, MembraneConfig { on, thickness, material, angle, .. }| {
            let thickness = [value("thickness", "m", thickness)];
            let law = law_table::sheet_numbers(material).into_iter();
            let law = law.map(|(own, number)| value(own.name, own.unit, number));
            let angle = angle.iter_mut().map(|angle| value("angle", "°", angle));
            (on.clone(), thickness.into_iter().chain(law).chain(angle).collect())
        })
    }

    fn report(&self, State { energies, at }: State, terms: &mut Terms) {
        let one = |(config, sheet): (&MembraneConfig, &Membrane)| {
            let MembraneSummary { area, energy, stretch, tension, taut, wrinkled, slack } =
                sheet.summary(at);
            let law = config.specification().map(|own| own.law.key.to_owned());
            reports::Membrane {
                on: config.on.clone(),
                kind: law.unwrap_or_default(),
                tension_only: config.tension,
                thickness: config.thickness,
                area,
                energy,
                stretch,
                tension,
                taut,
                wrinkled,
                slack,
            }
        };
        let sheets = self.iter().zip(energies.each());
        terms.membranes = (!self.is_empty()).then(|| sheets.map(one).collect());
    }
}
