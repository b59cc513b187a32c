//! Levels of a cascade that differ in what moves, what counts and how the scene is simulated.

use serde_json::Value;
use tests::chamber;
use tests::workdir::Workdir;

/// The chamber with linear elements, blown up in six steps to a peak that may change.
fn with(levels: &str, more: &str) -> Workdir {
    let dir = chamber::workdir();
    let sim = chamber::SIM
        .replace("degree = 2", "degree = 1")
        .replace("pressure = 8e3", "pressure = \"peak*t\"");
    // tight enough that an iteration more or less is told
    let time = "[solver]\nabsolute_tolerance = 1e-10\n[parameters]\npeak = 8e3\n[time]\nmethod = \"quasistatic\"\nend = 1.0\nsteps = 6\n";
    dir.write("sim.toml", &(sim + time));
    let (head, objectives) = chamber::DESIGN.split_once("[[objective]]").unwrap();
    let head = &head[..head.find("[[shape.level]]").unwrap()];
    dir.write("design.toml", &format!("{head}{levels}\n[[objective]]{objectives}{more}"));
    dir
}

/// Cheap levels are framed by the scene itself, and end where it says they do.
#[test]
fn a_cascade_on_fewer_time_steps_ends_with_the_scene_itself() {
    let level = "[[shape.level]]\nhandles = { first = 1, factor = 3, levels = 2 }\n\
                 iterations = 2\ntime = { steps = 2 }\n";
    let dir = with(level, "");
    dir.solver("-q optimize design.toml -o out").assert_good();
    let history = dir.lines("out/history.jsonl");
    let steps = |level: u64| -> Vec<u64> {
        let of = history.iter().filter(|line| line["level"] == level);
        of.map(|line| line["time_steps"].as_u64().unwrap()).collect()
    };
    assert_eq!(
        [steps(1), steps(2), steps(3), steps(4)],
        [vec![6], vec![2; 3], vec![2; 3], vec![6]]
    );
    let handles = |line: &Value| line["handles"].as_u64().unwrap();
    assert_eq!((handles(&history[1]), handles(&history[4])), (1, 3));
    // the scene is quasistatic and elastic: its last state does not depend on the steps before
    let objective = |line: usize| history[line]["objective"].as_f64().unwrap();
    for (a, b) in [(0, 1), (6, 7)] {
        let gap = (objective(a) / objective(b) - 1.0).abs();
        assert!(gap < 1e-4, "{a} {b}: {gap}");
    }
    assert!(objective(7) < 0.9 * objective(0), "{} {}", objective(0), objective(7));
    // the last level goes beside the one before, and not from rest
    let newton = |line: usize| history[line]["newton_iterations"].as_f64().unwrap();
    assert!(newton(7) < newton(0), "{} {}", newton(7), newton(0));
    // the design is that of the last line
    dir.solver("-q simulate sim.toml --mesh out/design.msh -o again").assert_good();
    let again = dir.json("again/report.json")["tags"]["top"]["mean_displacement"].as_f64().unwrap();
    let said = history[7]["mean_displacement"]["top"].as_f64().unwrap();
    assert!((again / said - 1.0).abs() < 1e-6, "{again} {said}");
}

/// A level with another degree begins with the displacement of the one before.
#[test]
fn a_cheap_level_may_have_another_degree() {
    let dir = chamber::workdir();
    let cheap = chamber::DESIGN.replacen("iterations = 3", "iterations = 3\ndegree = 1", 1);
    dir.write("design.toml", &cheap);
    dir.solver("-q optimize design.toml -o out").assert_good();
    let history = dir.lines("out/history.jsonl");
    let dofs = |level: u64| history.iter().find(|l| l["level"] == level).unwrap()["dofs"].clone();
    assert_eq!(dofs(1), dofs(3));
    assert!(dofs(2).as_u64() < dofs(1).as_u64());
    assert_eq!(history.last().unwrap()["level"], 3);
}

/// Steps are as long as L-BFGS wants them, or as `largest_step` lets them.
#[test]
fn later_steps_are_as_long_as_they_may_be() {
    let dir = chamber::workdir();
    let own = "method = \"l-bfgs\"\nfirst_step";
    let design = dir.text("design.toml").replacen("first_step", own, 1);
    let lengths = |more: &str| -> Vec<f64> {
        dir.write("design.toml", &design.replacen("first_step", &format!("{more}first_step"), 1));
        dir.solver("-q optimize design.toml -o out --restart").assert_good();
        let level = |line: &Value| line["level"] == 1 && line["iteration"] != 0;
        let history = dir.lines("out/history.jsonl").into_iter().filter(level);
        history.map(|line| line["motion_m"].as_f64().unwrap()).collect()
    };
    let (free, held) = (lengths(""), lengths("largest_step = 0.02\n"));
    assert!((held[0] / free[0] - 1.0).abs() < 1e-9, "the first step: {held:?} {free:?}");
    assert!(free[1] > 0.4 * free[0], "L-BFGS wants more: {free:?}");
    assert!(held[1..].iter().all(|&motion| motion < 0.21 * held[0]), "{held:?}");
}

/// What is gained on a coarse mesh is kept on the scene's, to which the design is carried, and the reverse.
#[test]
fn a_level_may_have_another_mesh() {
    let dir = chamber::workdir();
    let [coarse, fine] = [2, 3].map(chamber::refined);
    mesh::io::write_tets(&dir.path("body.msh"), &coarse.mesh, &coarse.tags).unwrap();
    mesh::io::write_tets(&dir.path("fine.msh"), &fine.mesh, &fine.tags).unwrap();
    dir.write("p1.toml", &dir.text("p1.toml").replace("body.msh", "fine.msh"));
    // the term of walls differs too much from mesh to mesh: 2 and 6 % of the objective
    let level = |more: &str| {
        let head = "[[shape.level]]\nhandles = 1\niterations = 2\nweights = { wall = 0 }\n";
        format!("{head}{more}")
    };
    let levels = [level("mesh = 'body.msh'\n"), level(""), level("mesh = 'body.msh'\n")].concat();
    // steps of Gauss and Newton go so far that each mesh has a shape of its own
    let short = "method = \"l-bfgs\"\nfirst_step";
    let design = dir.text("design.toml").replacen("first_step", short, 1);
    let (head, tail) = (design.find("[[shape").unwrap(), design.find("[[objective]]").unwrap());
    dir.write("design.toml", &format!("{}{levels}{}", &design[..head], &design[tail..]));
    dir.solver("-q optimize design.toml -o out").assert_good();
    let history = dir.lines("out/history.jsonl");
    let of = |level: u64| history.iter().filter(move |line| line["level"] == level);
    let number = |line: &Value, key: &str| line[key].as_f64().unwrap();
    let dofs: Vec<f64> = (1..=5).map(|l| number(of(l).next().unwrap(), "dofs")).collect();
    assert_eq!(dofs[0], 3.0 * fine.mesh.vertices.len() as f64);
    assert_eq!(dofs[1], 3.0 * coarse.mesh.vertices.len() as f64);
    assert_eq!([dofs[2], dofs[3], dofs[4]], [dofs[0], dofs[1], dofs[0]]);
    let ends = |level: u64| {
        let own: Vec<f64> = of(level).map(|line| number(line, "objective")).collect();
        (own[0], *own.last().unwrap())
    };
    for level in [2, 4] {
        let (gained, (start, end)) = (ends(level - 1).1 - ends(level + 1).0, ends(level));
        assert!(
            gained > 0.5 * (start - end) && start > end,
            "level {level}: {gained:.3e} of {start:.3e} to {end:.3e}"
        );
    }
    let designed = mesh::io::read_tets(&dir.path("out/design.msh")).unwrap();
    assert_eq!(designed.mesh.vertices.len(), fine.mesh.vertices.len());
    let report = dir.json("out/report.json");
    for (kind, path) in [("level_meshes", "../body.msh"), ("targets", "../target.stl")] {
        let named = report["inputs"][kind].as_array().unwrap();
        assert_eq!(named.len(), 1, "each once: {named:?}");
        assert_eq!(named[0]["path"], path);
    }
}

#[test]
fn designed_loads_go_from_level_to_level() {
    let levels = "[[shape.level]]\nhandles = 1\niterations = 2\n\
                  [[shape.level]]\nhandles = 3\niterations = 1\n";
    let dir = with(levels, "[[parameter]]\nname = \"peak\"\nbounds = [0, 2e4]\n");
    dir.solver("-q optimize design.toml -o out").assert_good();
    let history = dir.lines("out/history.jsonl");
    let peak = |line: &Value| line["parameters"]["peak"].as_f64().unwrap();
    let before = history.iter().rfind(|line| line["level"] == 1).unwrap();
    let after = history.iter().find(|line| line["level"] == 2).unwrap();
    assert!((peak(before) / 8e3 - 1.0).abs() > 1e-3, "the peak has not changed: {before}");
    assert!((peak(after) / peak(before) - 1.0).abs() < 1e-12, "{before} {after}");
}

#[test]
fn weights_count_in_their_level_only() {
    let levels = "[[shape.level]]\nhandles = 1\niterations = 0\nweights = { smooth = 4 }\n\
                  [[shape.level]]\nhandles = 1\nmotion = \"translation\"\niterations = 1\n";
    let dir = with(levels, "");
    dir.solver("-q optimize design.toml -o out").assert_good();
    let history = dir.lines("out/history.jsonl");
    let smooth = |line: usize| history[line]["terms"]["smooth"].as_f64().unwrap();
    assert!((smooth(0) / smooth(1) - 4.0).abs() < 1e-9, "{} {}", smooth(0), smooth(1));
    assert_eq!([6, 3].map(Value::from), [0, 1].map(|line| history[line]["variables"].clone()));
}

/// A peak is sought at a third of the time, then at its end: a level's time and weights are its own.
#[test]
fn a_design_of_loads_alone_has_levels_too() {
    let dir = with("[[shape.level]]\nhandles = 1\niterations = 1\n", "");
    dir.solver("-q simulate sim.toml -o out").assert_good();
    let steps = dir.lines("out/steps.jsonl");
    let volume = |line: usize| steps[line]["chambers"]["cavity"]["volume"].as_f64().unwrap();
    let objective = |name: &str, volume: f64| {
        format!(
            "[[objective]]\nkind = \"volume\"\nname = \"{name}\"\nweight = 1e14\n\
             on = \"cavity\"\nvolume = {volume:e}\nmeasure = \"deformed\"\n"
        )
    };
    let levels = "[[level]]\niterations = 12\ntime = { steps = 2, end = 0.333333333333 }\n\
                  weights = { late = 0 }\n\
                  [[level]]\niterations = 1\nweights = { early = 0 }\n";
    let head = "scene = \"low.toml\"\n[optimizer]\nfirst_step = 1.0\n";
    let parameter = "[[parameter]]\nname = \"peak\"\nbounds = [0, 2e4]\n";
    let objectives = objective("early", volume(1)) + &objective("late", volume(5));
    let low = dir.text("sim.toml").replace("peak = 8e3", "peak = 5e3");
    dir.write("low.toml", &low);
    dir.write("design.toml", &format!("{head}{levels}{parameter}{objectives}"));
    dir.solver("-q optimize design.toml -o out").assert_good();
    let history = dir.lines("out/history.jsonl");
    let of = |level: u64| history.iter().rfind(|line| line["level"] == level).unwrap();
    // the first and the last level are the scene itself
    assert_eq!([1, 2, 3].map(|l| of(l)["time_steps"].as_u64().unwrap()), [6, 2, 6]);
    let early = of(2);
    assert_eq!(early["terms"]["late"].as_f64(), Some(0.0));
    let peak = early["parameters"]["peak"].as_f64().unwrap();
    assert!((peak / 8e3 - 1.0).abs() < 1e-3, "{early}");

    for (from, to, words) in [
        (
            "[[level]]\niterations = 12",
            "[[level]]\nhandles = 1\niterations = 12",
            "[[level]]: handles",
        ),
        ("first_step = 1.0", "iterations = 3", "beside [[level]]"),
    ] {
        let design = format!("{head}{levels}{parameter}{objectives}").replacen(from, to, 1);
        dir.write("bad.toml", &design);
        dir.solver("optimize bad.toml -o bad").assert_refused(2, &["bad.toml", words]);
    }
}

/// Terms begin with the shares that they are to have, and keep the weights that this takes.
#[test]
fn terms_begin_with_their_shares() {
    let dir = chamber::workdir();
    let sim = chamber::SIM.replace("degree = 2", "degree = 1");
    dir.write("sim.toml", &sim);
    let shared = chamber::DESIGN
        .replace("weight = 1e10", "share = 0.6")
        .replace("weight = 1e5", "share = 0.3");
    dir.write("design.toml", &shared);
    let run = dir.solver("optimize design.toml -o out");
    run.assert_good();
    assert!(run.stderr.contains("level 1 begins with top 60.0 %, wall 30.0 %"), "{}", run.stderr);
    let first = &dir.lines("out/history.jsonl")[0]["terms"];
    let term = |name: &str| first[name].as_f64().unwrap();
    let total: f64 = ["top", "wall", "smooth", "clear"].iter().map(|name| term(name)).sum();
    for (name, share) in [("top", 0.6), ("wall", 0.3)] {
        assert!((term(name) / total - share).abs() < 1e-12, "{name}: {first}");
    }
    // the same design with these weights written has the same bits
    let weights = dir.json("out/report.json")["weights"].clone();
    let mut weighted = chamber::DESIGN.to_owned();
    for (name, old) in [("top", "1e10"), ("wall", "1e5")] {
        weighted =
            weighted.replace(&format!("weight = {old}"), &format!("weight = {}", weights[name]));
    }
    dir.write("weighted.toml", &weighted);
    dir.solver("-q optimize weighted.toml -o again").assert_good();
    assert_eq!(dir.text("out/design.msh"), dir.text("again/design.msh"));
    dir.solver("check design.toml --design-only").assert_good();
    // nothing of the wall is thinner than the barrier sees
    dir.write("design.toml", &shared.replace("activation = 9e-3", "activation = 1e-6"));
    let run = dir.solver("optimize design.toml -o none");
    run.assert_refused(2, &["objective \"wall\": share = 0.3: the term is 0 at the start"]);
    assert!(!dir.path("none/report.json").exists());
}
