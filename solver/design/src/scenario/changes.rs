//! The scene of a scenario: that of the design with other numbers.

use anyhow::{Context, Result, ensure};
use scene::config::{ByName, ScenarioConfig};
use scene::{Scene, SceneLaw};

use mechanics::body::Body;
use scene::number::{self, Group, Number, Walls};

/// The scene of a scenario, walls included.
pub fn scene_of(scene: &Scene, scenario: &ScenarioConfig) -> Result<Scene> {
    scenario.check_alone()?;
    let mut changed = under(scene, scenario)?;
    if let Some(walls) = walls(scenario, scene, &scene.body)? {
        let mesh = &mut changed.body.mesh;
        mesh.vertices = walls.moved(&mesh.vertices, &scenario.walls());
        let findings = mesh::check::check_tets(mesh);
        ensure!(findings.is_empty(), "wall: walls that are moved so far turn an element over");
    }
    Ok(changed)
}

/// The walls of a body on the mesh of a level, where some are off.
pub fn walls(scenario: &ScenarioConfig, scene: &Scene, body: &Body) -> Result<Option<Walls>> {
    if scenario.walls().is_empty() {
        return Ok(None);
    }
    for (tag, _) in scenario.walls() {
        tag.map_or(Ok(()), |tag| body.facets(tag).map(drop))?;
    }
    Walls::on(scene, body).map(Some)
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
    let all = |by: &Option<f64>| by.map(ByName::All);
    let changes: [(&str, Option<ByName>, Of); 5] = [
        ("modulus", modulus.clone(), Group::modulus),
        ("density", density.clone(), Group::density),
        ("membrane", membrane.clone(), Group::membrane),
        ("friction", all(friction), |scene, _| Group::friction(scene)),
        ("pressure", all(pressure), Group::pressure),
    ];
    for (key, by, group) in &changes {
        for (on, by) in by.iter().flat_map(ByName::each) {
            let about = on.map_or_else(|| (*key).to_owned(), |on| format!("{key} of \"{on}\""));
            let group = group(scene, on);
            ensure!(!group.numbers.is_empty(), "{about}: {}", lacking(scene, key, on));
            group.apply(&mut changed, None, by).context(about)?;
        }
    }
    for path in scenario.numbers.keys() {
        let is_wall = Number::find(scene, path).context("numbers")?.word() == "wall";
        ensure!(!is_wall, "numbers: {path}: expected wall = … of the scenario");
    }
    number::set(&mut changed, &scenario.numbers).context("numbers")?;
    Ok(changed)
}

/// Why nothing in the scene is changed.
fn lacking(scene: &Scene, key: &str, on: Option<&str>) -> String {
    let tags: Vec<&str> = scene.config.membrane.iter().map(|m| m.on.as_str()).collect();
    match key {
        "friction" => return "there is none in [contact] of the scene".to_owned(),
        "pressure" => return "no [[chamber]] of the scene has a pressure or fill".to_owned(),
        "membrane" if tags.is_empty() => return "the scene has no [[membrane]]".to_owned(),
        "membrane" => {
            return format!("no [[membrane]] is on it; expected some of: {}", tags.join(", "));
        }
        _ => (),
    }
    let known = |law: &SceneLaw| law.is_of(on);
    if scene.laws.iter().any(known) {
        return format!("no material of {} has one", on.unwrap_or("the scene"));
    }
    let names: Vec<String> = scene.laws.iter().map(|law| law.name.clone()).collect();
    format!(
        "no volume or body with a [material] of its own is called so; expected some of: {}",
        names.join(", ")
    )
}
