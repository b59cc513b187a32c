//! Numbers of scenes that measurements may determine.

use anyhow::{Context, Result, bail, ensure};
use serde::Deserialize;

use crate::adjoint::Gradient;
use crate::config::{ChamberConfig, is_pressure};
use crate::energy::ParameterId;
use crate::forward::Problem;
use crate::scene::Scene;
use crate::sensitivity::{Walls, by_density, by_modulus, by_pressures};

/// `[[number]]`: what is sought.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Number {
    /// `modulus`, `density`, `pressure`, `wall`, or the name of a parameter of the law.
    pub of: String,
    /// The chamber or the tag of the wall; all without it.
    pub on: Option<String>,
    /// The body with that law; may be left out where there is one.
    pub body: Option<String>,
}

impl Number {
    /// What tables call it.
    #[must_use]
    pub fn title(&self) -> String {
        let on = self.on.as_ref().or(self.body.as_ref());
        on.map_or_else(|| self.of.clone(), |on| format!("{} of {on}", self.of))
    }

    /// Whether it is a factor, an offset, or a parameter of a law.
    #[must_use]
    pub fn meaning(&self) -> &'static str {
        match self.of.as_str() {
            "modulus" => "factor on all stresses",
            "density" => "factor",
            "pressure" => "offset",
            "wall" => "outward offset",
            _ => "parameter of the law",
        }
    }

    /// Whether it changes a material.
    #[must_use]
    pub fn is_of_material(&self) -> bool {
        !["density", "pressure", "wall"].contains(&self.of.as_str())
    }

    /// Its unit and its value in a scene, as it is read; none where the scene does not have it.
    ///
    /// # Errors
    /// When no scene can have it.
    pub fn start(&self, scene: &Scene) -> Result<Option<(&'static str, f64)>> {
        let applies = |wanted: &str| -> Result<()> {
            ensure!(self.body.is_none(), "{}: body is for parameters of a law", self.title());
            let chosen = ["pressure", "wall"].contains(&wanted);
            ensure!(chosen || self.on.is_none(), "{}: on is for pressure and wall", self.title());
            Ok(())
        };
        Ok(match self.of.as_str() {
            of @ "modulus" => {
                applies(of)?;
                Some(("1", 1.0))
            }
            of @ "density" => {
                applies(of)?;
                scene.parts.iter().any(|part| part.material.density.is_some()).then_some(("1", 1.0))
            }
            of @ "pressure" => {
                applies(of)?;
                let known = |c: &ChamberConfig| is_pressure(c.gas.key()) && self.is_on(&c.on);
                scene.config.chamber.iter().any(known).then_some(("Pa", 0.0))
            }
            of @ "wall" => {
                applies(of)?;
                let is_tag = |on: &String| scene.body.used_tags().any(|tag| tag == on);
                let known = self.on.as_ref().is_none_or(is_tag);
                known.then_some(("m", 0.0))
            }
            _ => {
                let (part, place, unit) = self.place(scene)?;
                Some((unit, scene.parts[part].material.values[place]))
            }
        })
    }

    fn is_on(&self, name: &str) -> bool {
        self.on.as_ref().is_none_or(|on| on == name)
    }

    /// Of a parameter: its body, its place among the values of the law, and its unit.
    fn place(&self, scene: &Scene) -> Result<(usize, usize, &'static str)> {
        ensure!(self.on.is_none(), "{}: on is for pressure and wall", self.title());
        let named = |name: &String| {
            let found = scene.parts.iter().position(|part| part.config.name == *name);
            found.with_context(|| format!("{}: no body has this name", self.title()))
        };
        let part = match &self.body {
            Some(name) => named(name)?,
            None if scene.parts.len() == 1 => 0,
            None => bail!("{}: there are several bodies; name one by body = \"…\"", self.title()),
        };
        let material = &scene.parts[part].material;
        let mut place = 0;
        for (parameter, values) in material.law.named(&material.values) {
            if parameter.name == self.of {
                ensure!(
                    !parameter.list,
                    "{}: a list of numbers cannot be calibrated; expected of = \"modulus\", or \
                     another law",
                    self.title()
                );
                return Ok((part, place, parameter.unit));
            }
            place += values.len();
        }
        let known: Vec<&str> = material.law.parameters.iter().map(|p| p.name).collect();
        bail!(
            "of = \"{}\": expected modulus, density, pressure, wall, or a parameter of the law \
             {}: {}",
            self.of,
            material.law.key,
            known.join(", ")
        )
    }

    /// Gives it a value in a scene that has it.
    ///
    /// # Errors
    /// When the scene does not admit the value.
    pub fn apply(&self, scene: &mut Scene, walls: Option<&Walls>, value: f64) -> Result<()> {
        match self.of.as_str() {
            "modulus" => scene.scale_stresses(value)?,
            "density" => scene.scale_density(value)?,
            "pressure" => scene.add_pressure(self.on.as_deref(), value)?,
            "wall" => {
                let moves = walls.and_then(|walls| walls.moves(self.on.as_deref()));
                let vertices = scene.body.mesh.vertices.iter_mut();
                vertices.zip(moves.unwrap_or_default()).for_each(|(x, d)| *x += value * d);
                let findings = mesh::check::check_tets(&scene.body.mesh);
                ensure!(findings.is_empty(), "walls moved by {value:e} m turn an element over");
            }
            _ => {
                let (part, place, _) = self.place(scene)?;
                let material = &mut scene.parts[part].material;
                material.values[place] = value;
                material.law.check(&material.values)?;
            }
        }
        Ok(())
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
        Ok(match self.of.as_str() {
            "modulus" => by_modulus(scene, by) / value,
            "density" => by_density(scene, by) / value,
            "pressure" => {
                let of_chambers = by_pressures(problem, by).into_iter();
                of_chambers.filter(|(name, _)| self.is_on(name)).map(|(_, by)| by).sum()
            }
            "wall" => {
                let all = walls.map(|walls| walls.derivatives(&by.rest)).unwrap_or_default();
                all.into_iter().filter(|(tag, _)| *tag == self.on).map(|(_, by)| by).sum()
            }
            _ => {
                let (part, place, _) = self.place(scene)?;
                by.parameters.total(ParameterId::Material(part))[place]
            }
        })
    }
}
