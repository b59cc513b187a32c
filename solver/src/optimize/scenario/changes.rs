//! The scene of a scenario: that of the design with other numbers.

use anyhow::{Context, Result, ensure};
use scene::config::{ByName, ScenarioConfig};
use scene::{Scene, SceneLaw};

use crate::optimize::offset::Offset;
use scene::number::{self, Group, Number};

/// The scene of a scenario, walls included.
pub fn scene_of(scene: &Scene, scenario: &ScenarioConfig) -> Result<Scene> {
    scenario.check_alone()?;
    let mut changed = under(scene, scenario)?;
    if let Some(offset) = Offset::new(scenario, &scene.body)? {
        let mesh = &mut changed.body.mesh;
        mesh.vertices = offset.apply(&mesh.vertices);
        let findings = mesh::check::check_tets(mesh);
        ensure!(findings.is_empty(), "wall: walls that are moved so far turn an element over");
    }
    Ok(changed)
}

/// The scene under a scenario, without what it says of walls: they are moved with the shape of a
/// level.
pub fn under(scene: &Scene, scenario: &ScenarioConfig) -> Result<Scene> {
    let ScenarioConfig { modulus, density, membrane, friction, pressure, parameters, .. } =
        scenario;
    let mut changed = scene.clone();
    let known: Vec<&str> = scene.config.parameters.keys().map(String::as_str).collect();
    for name in parameters.keys() {
        ensure!(
            scene.config.parameters.contains_key(name),
            "parameters: {} has no {name} in [parameters]; expected some of: {}",
            scene.path.display(),
            known.join(", ")
        );
    }
    changed.config = scene.config.with(|config| config.parameters.extend(parameters.clone()))?;
    type Of = fn(&Scene, Option<&str>) -> Group;
    let factors: [(&str, &Option<ByName>, Of); 3] = [
        ("modulus", modulus, Group::modulus),
        ("density", density, Group::density),
        ("membrane", membrane, Group::membrane),
    ];
    for (key, factors, group) in factors {
        for (on, factor) in factors.iter().flat_map(ByName::each) {
            let about = on.map_or_else(|| key.to_owned(), |on| format!("{key} of \"{on}\""));
            let group = group(scene, on);
            ensure!(!group.numbers.is_empty(), "{about}: {}", lacking(scene, key, on));
            group.apply(&mut changed, None, factor).context(about)?;
        }
    }
    if let Some(factor) = friction {
        let group = Group::friction(scene);
        ensure!(!group.numbers.is_empty(), "friction: there is none in [contact] of the scene");
        group.apply(&mut changed, None, *factor)?;
    }
    if let Some(difference) = pressure {
        let group = Group::pressure(scene, None);
        let known = !group.numbers.is_empty();
        ensure!(known, "pressure: no [[chamber]] of the scene has a pressure or fill");
        group.apply(&mut changed, None, *difference)?;
    }
    for path in scenario.numbers.keys() {
        let is_wall = Number::find(scene, path).context("numbers")?.word() == "wall";
        ensure!(!is_wall, "numbers: {path}: expected wall = … of the scenario");
    }
    number::set(&mut changed, &scenario.numbers).context("numbers")?;
    Ok(changed)
}

/// Why nothing in the scene is changed by a factor.
fn lacking(scene: &Scene, key: &str, on: Option<&str>) -> String {
    if key == "membrane" {
        let tags: Vec<&str> = scene.config.membrane.iter().map(|m| m.on.as_str()).collect();
        return match tags[..] {
            [] => "the scene has no [[membrane]]".to_owned(),
            _ => format!("no [[membrane]] is on it; expected some of: {}", tags.join(", ")),
        };
    }
    let known = |law: &SceneLaw| on.is_none_or(|on| scene.is_law_of(law, on));
    if scene.laws.iter().any(known) {
        return format!("no material of {} has one", on.unwrap_or("the scene"));
    }
    let names: Vec<String> = scene.laws.iter().map(|law| scene.law_name(law)).collect();
    format!(
        "no volume or body with a [material] of its own is called so; expected some of: {}",
        names.join(", ")
    )
}
