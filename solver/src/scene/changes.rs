//! A scene with numbers changed: stresses, density, sheets, friction, pressures, parameters.

use anyhow::{Result, ensure};

use super::Scene;
use crate::config::{ScenarioConfig, is_pressure};

impl Scene {
    /// Multiplies all parameters that are stresses, of all laws or of those of a body or volume.
    ///
    /// # Errors
    /// When a law does not admit them.
    pub fn scale_stresses(&mut self, on: Option<&str>, factor: f64) -> Result<()> {
        let all = self.laws.iter().map(|law| on.is_none_or(|on| self.is_law_of(law, on)));
        let wanted: Vec<bool> = all.collect();
        for (one, _) in self.laws.iter_mut().zip(wanted).filter(|(_, wanted)| *wanted) {
            let law = one.material.law;
            let mut values = Vec::new();
            for (parameter, own) in law.named(&one.material.values) {
                let factor = if parameter.unit == "Pa" { factor } else { 1.0 };
                values.extend(own.into_iter().map(|v| factor * v));
            }
            law.check(&values)?;
            one.material.values = values;
        }
        Ok(())
    }

    /// Multiplies the density of all bodies.
    ///
    /// # Errors
    /// When the factor is not positive.
    pub fn scale_density(&mut self, factor: f64) -> Result<()> {
        ensure!(factor > 0.0, "a density must be positive");
        for law in &mut self.laws {
            law.material.density = law.material.density.map(|density| density * factor);
        }
        Ok(())
    }

    /// Multiplies the thickness of all sheets, or of those on a tag: they are in proportion to it
    /// as they are to their modulus.
    ///
    /// # Errors
    /// When the factor is not positive.
    pub fn scale_membranes(&mut self, on: Option<&str>, factor: f64) -> Result<()> {
        ensure!(factor > 0.0, "the thickness of a membrane must be positive");
        for membrane in &mut self.membranes {
            if on.is_none_or(|on| on == membrane.config.on) {
                membrane.thickness *= factor;
            }
        }
        Ok(())
    }

    /// Adds to the pressure or fill of all chambers, or of that with a tag [Pa].
    ///
    /// # Errors
    /// When an expression has no value.
    pub fn add_pressure(&mut self, on: Option<&str>, difference: f64) -> Result<()> {
        let known = self.config.parameters.clone();
        for chamber in &mut self.config.chamber {
            let wanted = on.is_none_or(|on| on == chamber.on);
            if wanted && is_pressure(chamber.gas.key()) {
                chamber.gas.schedule_mut().add(difference, &known)?;
            }
        }
        Ok(())
    }

    /// The scene under a scenario, but for its walls, which are moved with the shape of a level.
    ///
    /// # Errors
    /// When the scene does not have what the scenario changes, or does not admit it.
    pub fn under(&self, scenario: &ScenarioConfig) -> Result<Self> {
        let ScenarioConfig { modulus, density, membrane, friction, pressure, parameters, .. } =
            scenario;
        let mut scene = self.clone();
        let own = &mut scene.config.parameters;
        for (name, value) in parameters {
            let known: Vec<&str> = own.keys().map(String::as_str).collect();
            ensure!(
                own.contains_key(name),
                "parameters: {} has no {name} in [parameters]; expected some of: {}",
                self.path.display(),
                known.join(", ")
            );
            own.insert(name.clone(), *value);
        }
        scene.config.check()?;
        if let Some(factor) = modulus {
            scene.scale_stresses(None, *factor)?;
        }
        if let Some(factor) = density {
            let known = self.laws.iter().any(|law| law.material.density.is_some());
            ensure!(known, "density: no material of the scene has one");
            scene.scale_density(*factor)?;
        }
        if let Some(factor) = membrane {
            ensure!(!self.membranes.is_empty(), "membrane: the scene has no [[membrane]]");
            scene.scale_membranes(None, *factor)?;
        }
        if let Some(factor) = friction {
            let contact = scene.config.contact_mut().filter(|c| c.friction > 0.0);
            let Some(contact) = contact else {
                anyhow::bail!("friction: there is none in [contact] of the scene");
            };
            contact.friction *= factor;
        }
        if let Some(difference) = pressure {
            let known = self.config.chamber.iter().any(|c| is_pressure(c.gas.key()));
            ensure!(known, "pressure: no [[chamber]] of the scene has a pressure or fill");
            scene.add_pressure(None, *difference)?;
        }
        Ok(scene)
    }
}
