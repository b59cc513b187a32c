//! A scene with numbers changed: stresses, density, sheets, friction, pressures, parameters.

use anyhow::{Context, Result, ensure};

use super::{Scene, SceneLaw};
use crate::config::{FactorConfig, ScenarioConfig, is_pressure};

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

    /// Multiplies the density of all bodies, or of a body or volume.
    ///
    /// # Errors
    /// When the factor is not positive.
    pub fn scale_density(&mut self, on: Option<&str>, factor: f64) -> Result<()> {
        ensure!(factor > 0.0, "a density must be positive");
        let all = self.laws.iter().map(|law| on.is_none_or(|on| self.is_law_of(law, on)));
        let wanted: Vec<bool> = all.collect();
        for (law, _) in self.laws.iter_mut().zip(wanted).filter(|(_, wanted)| *wanted) {
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
        for (on, factor) in modulus.iter().flat_map(FactorConfig::each) {
            self.laws_called("modulus", on)?;
            scene.scale_stresses(on, factor).with_context(|| about("modulus", on))?;
        }
        for (on, factor) in density.iter().flat_map(FactorConfig::each) {
            let known = self.laws_called("density", on)?;
            let known = known.iter().any(|law| law.material.density.is_some());
            ensure!(
                known,
                "{}: no material of {} has one",
                about("density", on),
                on.unwrap_or("the scene")
            );
            scene.scale_density(on, factor)?;
        }
        for (on, factor) in membrane.iter().flat_map(FactorConfig::each) {
            let tags: Vec<&str> = self.membranes.iter().map(|m| m.config.on.as_str()).collect();
            ensure!(!tags.is_empty(), "membrane: the scene has no [[membrane]]");
            ensure!(
                on.is_none_or(|on| tags.contains(&on)),
                "{}: no [[membrane]] is on it; expected some of: {}",
                about("membrane", on),
                tags.join(", ")
            );
            scene.scale_membranes(on, factor)?;
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

    /// The laws of a body or volume, or all.
    ///
    /// # Errors
    /// With the names that there are when nothing is called so.
    fn laws_called(&self, key: &str, on: Option<&str>) -> Result<Vec<&SceneLaw>> {
        let wanted = |law: &&SceneLaw| on.is_none_or(|on| self.is_law_of(law, on));
        let laws: Vec<&SceneLaw> = self.laws.iter().filter(wanted).collect();
        ensure!(
            !laws.is_empty(),
            "{}: no volume or body with a [material] of its own is called so; expected some of: {}",
            about(key, on),
            self.laws.iter().map(|law| self.law_name(law)).collect::<Vec<_>>().join(", ")
        );
        Ok(laws)
    }
}

/// What messages call a factor.
fn about(key: &str, on: Option<&str>) -> String {
    on.map_or_else(|| key.to_owned(), |on| format!("{key} of \"{on}\""))
}
