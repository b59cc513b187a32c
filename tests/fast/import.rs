//! `solver import` of the designs that were published with Gjoka et al. 2024. That their scenes are what they were is seen
//! by what they do, in `polyfem.rs`.

use std::path::{Path, PathBuf};

use measure::objective::TimeIntegral;
use polyfem::{self, Options};
use scene::Scene;
use scene::config::{ContactForm, DesignConfig, ObjectiveConfig, Weight};
use tests::published::FOLDER;
use tests::workdir::Workdir;

/// Imports a published file into a folder and reads what was written.
fn imported(file: &str, options: &Options) -> Option<(Workdir, Scene)> {
    let path = tests::shared(&format!("{FOLDER}/{file}"))?;
    let dir = Workdir::new();
    let imported = polyfem::read(&path, options).unwrap();
    let unknown = |why: &&String| why.contains("unknown key");
    assert_eq!(imported.left().keys().find(unknown), None, "all keys of {file} are known");
    imported.write(&dir.path("")).unwrap();
    let scene = Scene::read(&dir.path("sim.toml")).unwrap();
    Some((dir, scene))
}

fn design(dir: &Workdir) -> DesignConfig {
    toml::from_str(&dir.text("design.toml")).unwrap()
}

#[test]
fn the_optimisation_of_the_gripper() {
    let run = "gripper_bellows/run_gripper_bellows_log_inside.json";
    let Some((dir, scene)) = imported(run, &Options::default()) else { return };
    let contact = scene.config.contact().unwrap();
    assert_eq!((contact.form, contact.activation), (ContactForm::Convergent, Some(3e-5)));
    assert_eq!((contact.stiffness, contact.friction), (Some(1e5), 0.7));
    let design = design(&dir);
    let shape = design.shape.expect("a shape");
    assert_eq!(shape.on.all(), ["gripper_bellows_thick.s2"]);
    let level = &shape.level[0];
    assert_eq!((level.describe(), level.iterations), ("50 handles".to_owned(), 100));
    let names: Vec<&str> = design.objective.iter().map(ObjectiveConfig::name).collect();
    assert_eq!(
        names,
        [
            "target_match_cylinder",
            "target_match_intermediate_5",
            "target_match_intermediate_10",
            "target_match_intermediate_30",
            "collision_barrier",
            "layer_thickness",
            "quadratic_contact_force_norm"
        ]
    );
    let [proxy, target] = [6, 0].map(|i| &design.objective[i]);
    let key = |term: &ObjectiveConfig, key: &str| toml::Table::try_from(term).unwrap()[key].clone();
    let kinds = [proxy, target].map(|term| term.kind().key);
    assert_eq!(kinds, ["contact-proxy", "target"]);
    assert_eq!(
        (proxy.weight(), proxy.over()),
        (Weight::Factor(-1e4), &TimeIntegral::Steps(vec![53, 54]))
    );
    let on = ["cylinder_to_grasp_coarse.s50", "gripper_bellows_thick.s4"];
    assert_eq!(key(proxy, "on"), toml::Value::from(on.to_vec()));
    assert_eq!((target.weight(), key(target, "on")), (Weight::Factor(1e6), on[1].into()));
    assert_eq!(target.files(), [Path::new("targets/cylinder_smaller_target_v2.obj")]);
    let read = |path: PathBuf| std::fs::read(path).unwrap();
    let from = tests::shared(&format!("{FOLDER}/gripper_bellows/cylinder_smaller_target_v2.obj"));
    assert_eq!(read(dir.path("targets/cylinder_smaller_target_v2.obj")), read(from.unwrap()));
}

#[test]
fn the_optimisations_of_worm_and_walker() {
    let Some((dir, _)) = imported("worm/run_worm.json", &Options::default()) else { return };
    // its state file is not where it says
    let notes = dir.json("import.report.json")["notes"].to_string();
    assert!(notes.contains("../state_worm.json") && notes.contains("is not there"), "{notes}");
    let design = design(&dir);
    let shape = design.shape.expect("a shape");
    assert_eq!((shape.on.all().len(), &shape.on.all()[0][..]), (11, "worm_long_clean.s11"));
    let handles = shape.level[0].describe();
    assert!(handles.starts_with("60 handles on worm_long_clean.s1, 20 handles on"), "{handles}");
    assert_eq!(handles.matches("20 handles").count(), 10);
    let Some((dir, _)) = imported("walker/run_walker.json", &Options::default()) else { return };
    let design: DesignConfig = toml::from_str(&dir.text("design.toml")).unwrap();
    let slopes: Vec<(&str, [f64; 2])> =
        design.chamber.iter().map(|p| (p.on.as_str(), p.slope)).collect();
    assert!(design.shape.is_none() && slopes.len() == 2, "{slopes:?}");
    assert!(slopes.iter().all(|s| s.1 == [-5e3, 5e3]), "{slopes:?}");
}

#[test]
fn what_cannot_be_imported_leaves_nothing_behind() {
    for (file, words) in [
        ("frog/run_frog_quasistatic.json", &["state_frog_quasistatic.json", "frog_base_mesh.msh"]),
        ("finger/state_finger.json", &["state_finger.json", "finger_base_mesh.msh"]),
    ] {
        let Some(path) = tests::shared(&format!("{FOLDER}/{file}")) else { return };
        let dir = Workdir::new();
        let run = dir.solver(&format!("import {} -o out", path.display()));
        run.assert_refused(2, words);
        run.assert_refused(2, &["/geometry/0/mesh: there is no file", "put it there"]);
        assert_eq!(dir.files("out"), [""; 0]);
    }
    let dir = Workdir::new();
    dir.write("bad.json", "{");
    dir.solver("import bad.json -o out").assert_refused(2, &["bad.json: not JSON"]);
    dir.solver("import absent.json -o out").assert_refused(2, &["absent.json"]);
}

#[test]
fn the_program_warns_and_writes_what_it_says() {
    let Some(path) = tests::shared(&format!("{FOLDER}/walker/state_walker.json")) else { return };
    let dir = Workdir::new();
    let run = dir.solver(&format!("import {} -o out --thickness 0.01", path.display()));
    run.assert_good();
    for words in ["/solver/linear/solver", "0.010000 m thick", "wrote out/sim.toml"] {
        assert!(run.stderr.contains(words), "{}", run.stderr);
    }
    let names = ["import.report.json", "sim.toml", "square.msh", "walker.msh"];
    assert_eq!(dir.files("out"), names);
}
