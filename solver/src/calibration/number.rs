//! Numbers of scenes that measurements may determine.

use anyhow::{Context, Error, Result, bail, ensure};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::adjoint::Gradient;
use crate::config::{ChamberConfig, is_pressure};
use crate::energy::ParameterId;
use crate::forward::Problem;
use crate::scene::{Scene, SceneLaw};
use crate::sensitivity::{Walls, by_density, by_membranes, by_moduli, by_pressures};

/// `[[number]]`: what is sought.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(try_from = "Written")]
pub enum Number {
    /// One factor on all stresses of all materials, or of those of a body or volume [1].
    Modulus(Option<String>),
    /// One factor on the density of all bodies [1].
    Density,
    /// Factor on the thickness of the sheets on a tag, or of all [1].
    Membrane(Option<String>),
    /// Offset of the pressure or fill of the chamber with a tag, or of all [Pa].
    Pressure(Option<String>),
    /// Outward offset of the wall with a tag, or of all [m].
    Wall(Option<String>),
    /// A number of a `[[relaxation]]` of the scene.
    Relaxation {
        /// Whether it is its time and not its overstress.
        time: bool,
        /// Which one, counted from 1; may be left out where there is one.
        branch: Option<usize>,
    },
    /// A parameter of the law of a body or volume.
    Law {
        /// Its name.
        parameter: String,
        /// The body or volume; may be left out where there is one law.
        body: Option<String>,
    },
}

/// A number as people write it.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Written {
    /// `modulus`, `density`, `membrane`, `pressure`, `wall`, `overstress`, `relaxation-time`, or the
    /// name of a parameter of the law.
    of: String,
    /// The chamber, the tag of the wall or the sheet, or the body or volume of the modulus.
    on: Option<String>,
    /// The body or volume with that law.
    body: Option<String>,
    /// Which `[[relaxation]]` of the scene, counted from 1; may be left out where there is one.
    branch: Option<usize>,
}

impl TryFrom<Written> for Number {
    type Error = Error;

    fn try_from(Written { of, on, body, branch }: Written) -> Result<Self> {
        let number = match of.as_str() {
            "modulus" => Self::Modulus(on.clone()),
            "density" => Self::Density,
            "membrane" => Self::Membrane(on.clone()),
            "pressure" => Self::Pressure(on.clone()),
            "wall" => Self::Wall(on.clone()),
            "overstress" => Self::Relaxation { time: false, branch },
            "relaxation-time" => Self::Relaxation { time: true, branch },
            _ => Self::Law { parameter: of, body: body.clone() },
        };
        let chosen = !matches!(number, Self::Density | Self::Relaxation { .. } | Self::Law { .. });
        let of_law = matches!(number, Self::Law { .. });
        ensure!(
            chosen || on.is_none(),
            "{}: on is for modulus, membrane, pressure and wall",
            number.title()
        );
        ensure!(of_law || body.is_none(), "{}: body is for parameters of a law", number.title());
        ensure!(
            branch.is_none() || matches!(number, Self::Relaxation { .. }),
            "{}: branch is for overstress and relaxation-time",
            number.title()
        );
        ensure!(
            branch != Some(0),
            "{}: branch = 0: the first [[relaxation]] of the scene is 1",
            number.title()
        );
        Ok(number)
    }
}

impl Number {
    /// What tables call it.
    #[must_use]
    pub fn title(&self) -> String {
        let branch;
        let (of, on) = match self {
            Self::Relaxation { time, branch: which } => {
                branch = which.map(|which| format!("branch {which}"));
                (if *time { "relaxation-time" } else { "overstress" }, &branch)
            }
            Self::Modulus(on) => ("modulus", on),
            Self::Density => ("density", &None),
            Self::Membrane(on) => ("membrane", on),
            Self::Pressure(on) => ("pressure", on),
            Self::Wall(on) => ("wall", on),
            Self::Law { parameter, body } => (parameter.as_str(), body),
        };
        on.as_ref().map_or_else(|| of.to_owned(), |on| format!("{of} of {on}"))
    }

    /// Whether it is a factor, an offset, or a parameter of a law.
    #[must_use]
    pub fn meaning(&self) -> &'static str {
        match self {
            Self::Modulus(_) => "factor on all stresses",
            Self::Density => "factor",
            Self::Membrane(_) => "factor on the thickness",
            Self::Pressure(_) => "offset",
            Self::Wall(_) => "outward offset",
            Self::Relaxation { .. } => "of the scene",
            Self::Law { .. } => "parameter of the law",
        }
    }

    /// Its unit and its value in a scene, as it is read; none where the scene does not have it.
    ///
    /// # Errors
    /// When no scene can have it.
    pub fn start(&self, scene: &Scene) -> Result<Option<(&'static str, f64)>> {
        Ok(match self {
            Self::Modulus(on) => {
                let known = |law: &SceneLaw| is_law_on(scene, on, law);
                scene.laws.iter().any(known).then_some(("1", 1.0))
            }
            Self::Density => {
                scene.laws.iter().any(|law| law.material.density.is_some()).then_some(("1", 1.0))
            }
            Self::Membrane(on) => {
                scene.membranes.iter().any(|m| is_on(on, &m.config.on)).then_some(("1", 1.0))
            }
            Self::Pressure(on) => {
                let known = |c: &ChamberConfig| is_pressure(c.gas.key()) && is_on(on, &c.on);
                scene.config.chamber.iter().any(known).then_some(("Pa", 0.0))
            }
            Self::Wall(on) => {
                let is_tag = |on: &String| scene.body.used_tags().any(|tag| tag == on);
                on.as_ref().is_none_or(is_tag).then_some(("m", 0.0))
            }
            Self::Relaxation { time, branch } => {
                let Some(table) = self.table(*branch, scene)? else { return Ok(None) };
                let found = &scene.config.relaxation[table];
                Some(if *time { ("s", found.time) } else { ("1", found.overstress) })
            }
            Self::Law { parameter, body } => {
                let (law, place, unit) = self.place(parameter, body.as_ref(), scene)?;
                Some((unit, scene.laws[law].material.values[place]))
            }
        })
    }

    /// The place of a `[[relaxation]]` in a scene; none where the scene has none at all.
    fn table(&self, branch: Option<usize>, scene: &Scene) -> Result<Option<usize>> {
        let count = scene.config.relaxation.len();
        if count == 0 {
            return Ok(None);
        }
        ensure!(
            branch.is_some() || count == 1,
            "{}: {} has {count} tables [[relaxation]]; expected branch = 1 to {count}",
            self.title(),
            scene.path.display()
        );
        let table = branch.unwrap_or(1) - 1;
        ensure!(
            table < count,
            "{}: {} has {count} tables [[relaxation]]",
            self.title(),
            scene.path.display()
        );
        Ok(Some(table))
    }

    /// Of a parameter: its law, its place among the values of that, and its unit.
    fn place(
        &self,
        wanted: &str,
        body: Option<&String>,
        scene: &Scene,
    ) -> Result<(usize, usize, &'static str)> {
        let named = |name: &String| {
            let found = scene.laws.iter().position(|law| scene.law_name(law) == *name);
            let all = || scene.laws.iter().map(|law| scene.law_name(law)).collect::<Vec<_>>();
            found.with_context(|| {
                format!(
                    "{}: no body or volume has this name; there are: {}",
                    self.title(),
                    all().join(", ")
                )
            })
        };
        let law = match body {
            Some(name) => named(name)?,
            None if scene.laws.len() == 1 => 0,
            None => {
                bail!("{wanted}: there are several laws; name a body or volume by body = \"…\"")
            }
        };
        let material = &scene.laws[law].material;
        let mut place = 0;
        for (parameter, values) in material.law.named(&material.values) {
            if parameter.name == wanted {
                ensure!(
                    !parameter.list,
                    "{}: a list of numbers cannot be calibrated; expected of = \"modulus\", or \
                     another law",
                    self.title()
                );
                return Ok((law, place, parameter.unit));
            }
            place += values.len();
        }
        let known: Vec<&str> = material.law.parameters.iter().map(|p| p.name).collect();
        bail!(
            "of = \"{wanted}\": expected modulus, density, membrane, pressure, wall, overstress, \
             relaxation-time, or a parameter of the law {}: {}",
            material.law.key,
            known.join(", ")
        )
    }

    /// Gives it a value in a scene that has it.
    ///
    /// # Errors
    /// When the scene does not admit the value.
    pub fn apply(&self, scene: &mut Scene, walls: Option<&Walls>, value: f64) -> Result<()> {
        match self {
            Self::Modulus(on) => scene.scale_stresses(on.as_deref(), value),
            Self::Density => scene.scale_density(None, value),
            Self::Membrane(on) => scene.scale_membranes(on.as_deref(), value),
            Self::Pressure(on) => scene.add_pressure(on.as_deref(), value),
            Self::Wall(on) => {
                let moves = walls.and_then(|walls| walls.moves(on.as_deref()));
                let vertices = scene.body.mesh.vertices.iter_mut();
                vertices.zip(moves.unwrap_or_default()).for_each(|(x, d)| *x += value * d);
                let findings = mesh::check::check_tets(&scene.body.mesh);
                ensure!(findings.is_empty(), "walls moved by {value:e} m turn an element over");
                Ok(())
            }
            Self::Relaxation { time, branch } => {
                let Some(table) = self.table(*branch, scene)? else { return Ok(()) };
                let found = &mut scene.config.relaxation[table];
                *(if *time { &mut found.time } else { &mut found.overstress }) = value;
                scene.config.check_relaxation()?;
                scene.set_branches()
            }
            Self::Law { parameter, body } => {
                let (law, place, _) = self.place(parameter, body.as_ref(), scene)?;
                let material = &mut scene.laws[law].material;
                material.values[place] = value;
                Ok(material.law.check(&material.values)?)
            }
        }
    }

    /// The derivative by it, in a scene in which it has a value, from that by everything.
    ///
    /// # Errors
    /// As [`Self::start`].
    pub fn derivative(
        &self,
        (scene, problem): (&Scene, &Problem),
        walls: Option<&Walls>,
        by: &Gradient,
        value: f64,
    ) -> Result<f64> {
        Ok(match self {
            Self::Modulus(on) => {
                let laws = scene.laws.iter().zip(by_moduli(scene, by));
                let own = laws.filter(|(law, _)| is_law_on(scene, on, law));
                own.map(|(_, (_, by))| by).sum::<f64>() / value
            }
            Self::Density => by_density(scene, by) / value,
            Self::Membrane(on) => {
                let sheets = by_membranes(scene, by).into_iter();
                let own = sheets.filter(|(tag, _)| is_on(on, tag));
                own.map(|(_, by)| by).sum::<f64>() / value
            }
            Self::Pressure(on) => {
                let of_chambers = by_pressures(problem, by).into_iter();
                of_chambers.filter(|(name, _)| is_on(on, name)).map(|(_, by)| by).sum()
            }
            Self::Wall(on) => {
                let all = walls.map(|walls| walls.derivatives(&by.rest)).unwrap_or_default();
                all.into_iter().filter(|(tag, _)| tag == on).map(|(_, by)| by).sum()
            }
            Self::Relaxation { time, branch } => {
                let Some(table) = self.table(*branch, scene)? else { return Ok(0.0) };
                let of = |(i, law): (usize, &SceneLaw)| -> Option<f64> {
                    let place = 2 * scene.branch_of(law, table)? + usize::from(*time);
                    by.parameters.total(ParameterId::Relaxation(i)).get(place).copied()
                };
                scene.laws.iter().enumerate().filter_map(of).sum()
            }
            Self::Law { parameter, body } => {
                let (law, place, _) = self.place(parameter, body.as_ref(), scene)?;
                by.parameters.total(ParameterId::Material(law))[place]
            }
        })
    }
}

/// Whether a law is of the body or volume that is named, or none is.
fn is_law_on(scene: &Scene, named: &Option<String>, law: &SceneLaw) -> bool {
    named.as_ref().is_none_or(|on| scene.is_law_of(law, on))
}

/// Whether a tag is the one that is named, or none is.
fn is_on(named: &Option<String>, tag: &str) -> bool {
    named.as_ref().is_none_or(|on| on == tag)
}
