//! `solver` given what it cannot use: exit code, a message that names the file
//! and the number, no results, and never a panic.

use mesh::Tags;
use mesh::io::{read_tets, write_tets};
use tests::chamber::{self, beyond_any_equilibrium};
use tests::workdir::Workdir;

/// A change of a file's text, and what the message must say.
type Case = (&'static str, &'static str, &'static [&'static str]);

/// Makes each change in a fresh copy of `file` and expects exit code 2 without
/// results from `verb`.
fn refuse(verb: &str, file: &str, cases: &[Case]) {
    let dir = chamber::workdir();
    let sound = dir.text(file);
    for (from, to, words) in cases {
        assert!(sound.contains(from), "{from:?} is not in {file}");
        dir.write(file, &sound.replacen(from, to, 1));
        let run = dir.solver(&format!("{verb} {file} -o out"));
        run.assert_refused(2, words);
        run.assert_refused(2, &[file]);
        assert_eq!(dir.files("out"), [""; 0], "{to}");
    }
}

#[test]
fn scenes() {
    refuse(
        "simulate",
        "sim.toml",
        &[
            (
                "degree",
                "degre",
                &["unknown field `degre`", "did you mean `degree`", "`chamber`", "sim.toml:3:1"],
            ),
            ("c1 =", "c9 =", &["unknown parameter \"c9\"", "c1 [Pa]", "d1 [Pa]"]),
            ("mooney-rivlin", "rubber", &["\"rubber\"", "mooney-rivlin, ", "neo-hookean"]),
            ("degree = 2", "degree = \"two\"", &["sim.toml:3:10", "invalid type", "two"]),
            ("degree = 2", "degree = 4", &["degree = 4", "between 1 and 3"]),
            ("d1 = 1e6", "", &["no \"d1\"", "d1 [Pa]"]),
            ("c1 = 55e3", "c1 = -55e3", &["shear = 2 (c1 + c2) = -100000 Pa"]),
            ("c1 = 55e3", "c1 = -5e3", &["shear = 2 (c1 + c2) = 0 Pa"]),
            ("c1 = 55e3", "c1 = nan", &["c1 = NaN [Pa]"]),
            ("d1 = 1e6", "d1 = 0.0", &["bulk = 2 d1 = 0 Pa"]),
            (
                "pressure = 8e3",
                "pressure = nan",
                &["[[chamber]] on \"cavity\": pressure: NaN is not finite"],
            ),
            ("[[fixed]]\non = \"seat\"", "", &["edges of its rim are free", "[[fixed]]"]),
            ("on = \"seat\"", "on = \"seta\"", &["\"seta\"", "seat, cavity, top, skin"]),
            ("on = \"cavity\"", "on = \"hole\"", &["\"hole\"", "seat, cavity, top, skin"]),
            // the mouth is 8 edges around; with the top fixed instead, all are free
            ("on = \"seat\"", "on = \"top\"", &["\"cavity\": 8 of the 8 edges", "[[fixed]]"]),
        ],
    );
    refuse(
        "simulate",
        "p1.toml",
        &[
            ("[mat", "[solver]\nfirst_load_step = 2.0\n[mat", &["first_load_step = 2"]),
            ("[mat", "[solver]\nsmallest_load_step = 0.0\n[mat", &["smallest_load_step = 0"]),
            ("[mat", "[solver]\nnewton_iterations = 0\n[mat", &["newton_iterations", "positive"]),
            ("[mat", "[solver]\ntolerance = 0.0\n[mat", &["`tolerance`", "`relative_tolerance`"]),
        ],
    );
}

#[test]
fn schedules() {
    refuse(
        "simulate",
        "p1.toml",
        &[
            (
                "pressure = 8e3",
                "pressure = \"8e3*sn(t)\"",
                &[
                    "[[chamber]] on \"cavity\": pressure",
                    "p1.toml:1",
                    "\"8e3*sn(t)\"",
                    "\"sn\"",
                    "character 5",
                    "half_smoothstep",
                    "did you mean `sin`?",
                ],
            ),
            ("pressure = 8e3", "pressure = \"8e3*q\"", &["unknown name \"q\"", "t, x, y, z"]),
            ("pressure = 8e3", "pressure = \"8e3*(t\"", &["it ends where ')'", "character 7"]),
            ("pressure = 8e3", "pressure = true", &["a number, an expression", "a table"]),
            (
                "pressure = 8e3",
                "pressure = \"8e3*x\"",
                &["[[chamber]] on \"cavity\": pressure = \"8e3*x\": must depend on t alone"],
            ),
            (
                "pressure = 8e3",
                "pressure = \"8e3/(t - 1)\"",
                &["[[chamber]] on \"cavity\": pressure: \"8e3/(t - 1)\" is inf at t = 1 s"],
            ),
            ("pressure = 8e3", "pressure = \"1e308*t\"", &["\"1e308*t\" is ", "e30"]),
            ("pressure = 8e3", "pressure = \"log(t)\"", &["\"log(t)\" is -inf at t = 0 s"]),
            (
                "pressure = 8e3",
                "pressure = { t = [0, 0.5], value = [0, 8e3] }",
                &[
                    "[[chamber]] on \"cavity\": pressure",
                    "from t = 0 to 0.5 s",
                    "expected from 0 to 1 s",
                ],
            ),
            (
                "pressure = 8e3",
                "pressure = { t = [0, 1], value = [8e3] }",
                &["2 times and 1 value"],
            ),
            ("pressure = 8e3", "pressure = { t = [1, 0], value = [1, 2] }", &["increase", "1, 0"]),
            (
                "on = \"seat\"",
                "on = \"seat\"\ndisplacement = [\"t/x\", 0, 0]",
                &["[[fixed]] on \"seat\": displacement", "\"t/x\"", "at t = ", "(0.00000,"],
            ),
            (
                "[mat",
                "[[body_force]]\nforce = [0, 0, \"sqrt(-z)\"]\n[mat",
                &["[[body_force]]: force", "\"sqrt(-z)\" is NaN"],
            ),
            (
                "[mat",
                "[[traction]]\non = \"top\"\ntraction = [inf, 0, 0]\n[mat",
                &["[[traction]] on \"top\": traction along x: inf is not finite"],
            ),
        ],
    );
}

#[test]
fn times_and_volumes() {
    let volume = |text: &str| format!("[[chamber]]\non = \"cavity\"\n{text}\n");
    let dir = chamber::workdir();
    let sound = dir.text("p1.toml");
    let body = sound.replace("[[chamber]]\non = \"cavity\"\npressure = 8e3\n", "");
    assert_ne!(sound, body);
    for (scene, words) in [
        (sound.clone() + "[time]\nend = 1.0\n", &["[time]: expected either end [s] and steps"][..]),
        (sound.clone() + "[time]\nend = 1.0\nsteps = 2\nat = [1.0]\n", &["[time]", "or at"]),
        (sound.clone() + "[time]\nend = -1.0\nsteps = 2\n", &["end = -1 s", "positive"]),
        (sound.clone() + "[time]\nend = 1.0\nsteps = 0\n", &["steps = 0"]),
        (sound.clone() + "[time]\nat = []\n", &["at is empty"]),
        (sound.clone() + "[time]\nat = [0.5, 0.5]\n", &["0.5 s after 0.5 s", "increase from 0"]),
        (sound.clone() + "[time]\nat = [0.0, 0.5]\n", &["0 s after 0 s"]),
        (sound.clone() + "[time]\nat = [nan]\n", &["NaN s after 0 s", "finite"]),
        (
            sound.clone() + &volume("volume_factor = 1.1"),
            &["\"cavity\" is the wall of two chambers"],
        ),
        (
            body.clone() + &volume(""),
            &[
                "[[chamber]] on \"cavity\"",
                "exactly one of",
                "volume_change [m³], volume_factor [1]",
            ],
        ),
        (
            body.clone() + &volume("volume_change = 1e-9\nvolume_factor = 1.1"),
            &["exactly one of", "found volume_change and volume_factor"],
        ),
        (
            body.clone() + &volume("volume_factor = -0.1"),
            &["1.600e-5 m³ would have -1.600e-6 m³ at t = "],
        ),
        (
            body.clone() + &volume("volume_factor = \"y\""),
            &["volume_factor = \"y\": must depend on t alone"],
        ),
        (
            body.clone() + &volume("volume_factor = nan"),
            &["[[chamber]] on \"cavity\": volume_factor: NaN"],
        ),
    ] {
        dir.write("changed.toml", &scene);
        let run = dir.solver("simulate changed.toml -o out");
        run.assert_refused(2, words);
        run.assert_refused(2, &["changed.toml"]);
        assert_eq!(dir.files("out"), [""; 0], "{scene}");
    }
}

#[test]
fn a_time_without_equilibrium() {
    let dir = chamber::workdir();
    let timed = beyond_any_equilibrium(&dir.text("p1.toml").replace("8e3", "\"8e3*t\""));
    dir.write("high.toml", &(timed + "[time]\nmethod = 'quasistatic'\nend = 2.0\nsteps = 2\n"));
    let run = dir.solver("simulate high.toml -o out");
    run.assert_refused(1, &["high.toml", "no equilibrium beyond t = 0"]);
    assert_eq!(dir.files("out"), ["not_full_load.vtu", "report.json"]);
}

#[test]
fn missing_files_and_arguments() {
    let dir = chamber::workdir();
    dir.solver("simulate none.toml -o out").assert_refused(2, &["none.toml", "No such file"]);
    dir.solver("optimize none.toml -o out").assert_refused(2, &["none.toml", "No such file"]);
    dir.solver("simulate sim.toml --mesh none.msh -o out").assert_refused(2, &["none.msh"]);
    dir.solver("simulate sim.toml").assert_refused(2, &["--output"]);
    dir.solver("simulat sim.toml").assert_refused(2, &["simulat"]);
    std::fs::remove_file(dir.path("body.msh")).unwrap();
    dir.solver("simulate sim.toml -o out").assert_refused(2, &["body.msh", "No such file"]);
    assert!(!dir.path("out").exists());
}

/// Runs both verbs on a spoiled `body.msh`.
fn refuse_mesh(dir: &Workdir, words: &[&str]) {
    for arguments in ["simulate sim.toml -o out", "optimize design.toml -o out"] {
        let run = dir.solver(arguments);
        run.assert_refused(2, words);
        run.assert_refused(2, &["body.msh"]);
        assert!(!dir.path("out").exists());
    }
}

#[test]
fn truncated_meshes() {
    let dir = chamber::workdir();
    let text = dir.text("body.msh");
    // in the header, in the nodes, between sections, in the elements, before the last line
    let nodes = text.find("$EndNodes").unwrap();
    for length in [0, 12, nodes / 2, nodes + 10, text.len() * 3 / 4, text.len() - 15] {
        dir.write("body.msh", &text[..length]);
        refuse_mesh(&dir, &[]);
    }
}

#[test]
fn broken_meshes() {
    let dir = chamber::workdir();
    let sound = dir.text("body.msh");
    let first = sound.lines().skip_while(|l| *l != "$Nodes").nth(2).unwrap();
    let spoil = |to: &str| dir.write("body.msh", &sound.replacen(&format!("\n{first}\n"), to, 1));
    spoil("\n1 nan 0.0 0.0\n");
    refuse_mesh(&dir, &["not finite", "NaN"]);
    // the corner at the origin, moved through the block: its tetrahedra turn
    // over, which no renumbering repairs
    spoil("\n1 0.025 0.025 0.025\n");
    refuse_mesh(&dir, &["two tetrahedra on the same side"]);
    // into the plane of the opposite facets
    let body = chamber::chamber();
    let tet = body.mesh.tets.iter().find(|tet| tet.contains(&0)).unwrap();
    let [a, b, c] = [1, 2, 3].map(|i| body.mesh.vertices[tet[i]]);
    let flat = (a + b + c) / 3.0;
    spoil(&format!("\n1 {:?} {:?} {:?}\n", flat.x, flat.y, flat.z));
    refuse_mesh(&dir, &["tetrahedr"]);
    dir.write("body.msh", &sound.replacen("\"seat\"", "\"other\"", 1));
    let run = dir.solver("simulate sim.toml -o out");
    run.assert_refused(2, &["sim.toml", "\"seat\"", "other, cavity, top, skin"]);
}

/// A physical group without triangles is a name that nothing uses.
#[test]
fn a_tag_without_facets_does_no_harm() {
    let dir = chamber::workdir();
    let file = read_tets(&dir.path("body.msh")).unwrap();
    let mut names = file.tags.names.clone();
    names.push("nothing".to_owned());
    let tags = Tags { names, ..file.tags };
    write_tets(&dir.path("body.msh"), &file.mesh, &tags).unwrap();
    dir.solver("simulate p1.toml -o out").assert_good();
    assert_eq!(dir.json("out/report.json")["status"], "ok");
}

#[test]
fn a_mesh_without_tags_is_said_to_have_none() {
    let dir = chamber::workdir();
    let file = read_tets(&dir.path("body.msh")).unwrap();
    write_tets(&dir.path("body.msh"), &file.mesh, &Tags::default()).unwrap();
    dir.solver("simulate p1.toml -o out").assert_refused(2, &["\"seat\"; the mesh has no tags"]);
}

#[test]
fn a_scene_without_a_load_is_refused_and_one_of_zero_remarked_on() {
    let dir = chamber::workdir();
    let remark = "nothing moves the body";
    assert!(!dir.solver("simulate p1.toml -o out").stderr.contains(remark));
    let zero = dir.solver("simulate p1.toml --set chamber.cavity.pressure=0 -o zero");
    zero.assert_good();
    assert!(zero.stderr.contains("all its loads are zero"), "{}", zero.stderr);
    let text = dir.text("p1.toml");
    dir.write("p1.toml", &text[..text.find("[[chamber]]").unwrap()]);
    dir.solver("simulate p1.toml -o none").assert_refused(2, &[remark, "[[chamber]]"]);
    assert!(!dir.path("none").exists());
}

/// A tolerance that everything meets is no tolerance: the body stays at rest.
#[test]
fn tolerances_that_accept_anything() {
    let endless = "[solver]\nabsolute_tolerance = inf\n[mat";
    refuse(
        "simulate",
        "p1.toml",
        &[
            ("[mat", "[solver]\nrelative_tolerance = 10.0\n[mat", &["relative_tolerance"]),
            ("[mat", endless, &["absolute_tolerance"]),
        ],
    );
}

/// Two pressures on one wall add up, and the report can show only one.
#[test]
fn two_pressures_on_one_wall() {
    let twice = "[[chamber]]\non = \"cavity\"\npressure = 1e3\n\n[[chamber]]";
    refuse("simulate", "p1.toml", &[("[[chamber]]", twice, &["\"cavity\""])]);
}

#[test]
fn pressures_outside_of_chambers() {
    let told =
        |written| ("[[chamber]]", written, &["[[chamber]]", "--set chamber.TAG.pressure"][..]);
    refuse("simulate", "p1.toml", &[told("[[pressure]]"), told("[[volume]]"), told("[[gas]]")]);
    let design = "[[pressure]]\non = \"cavity\"\nslope = [-1e3, 1e3]\n\n[shape]";
    refuse("optimize", "design.toml", &[("[shape]", design, &["pressure:", "[[chamber]]"])]);
}

/// The program ran, but there is no result: exit code 1 and a report that says so.
#[test]
fn pressure_beyond_any_equilibrium() {
    let dir = chamber::workdir();
    dir.solver("simulate p1.toml -o out").assert_good();
    dir.write("high.toml", &beyond_any_equilibrium(&dir.text("p1.toml")));
    let run = dir.solver("simulate high.toml -o out");
    run.assert_refused(1, &["high.toml", "no equilibrium", "% of the load", "lower the pressure"]);
    // the good result of before must not remain beside it
    assert_eq!(dir.files("out"), ["not_full_load.vtu", "report.json"]);
    let report = dir.json("out/report.json");
    assert_eq!(report["status"], "no equilibrium");
    assert!(report["reason"].as_str().unwrap().contains("no equilibrium beyond"));
}

/// A file where the folder should be: refused for root, too, who may write
/// everywhere else.
#[test]
fn a_folder_that_cannot_be_made() {
    let dir = chamber::workdir();
    dir.write("taken", "mine");
    for output in ["taken", "taken/out"] {
        let run = dir.solver(&format!("simulate p1.toml -o {output}"));
        run.assert_refused(2, &[output]);
        dir.solver(&format!("optimize design.toml -o {output}")).assert_refused(2, &[output]);
    }
    assert_eq!(dir.text("taken"), "mine");
}

#[test]
fn a_full_disk() {
    let dir = chamber::workdir();
    dir.solver("simulate sim.toml -o good").assert_good();
    let mut failed = 0;
    // KiB: less than the smallest array, than the picture files, than nothing
    for limit in [4, 40, 4000] {
        let out = format!("out{limit}");
        let run = dir.solver_on_small_disk(limit, &format!("simulate sim.toml -o {out}"));
        if run.code == Some(0) {
            continue;
        }
        failed += 1;
        run.assert_refused(2, &[&out, "too large"]);
        let files = dir.files(&out);
        assert!(!files.contains(&"report.json".to_owned()), "{files:?}");
        // whatever is there is whole
        for file in files {
            let size = |folder: &str| dir.path(folder).join(&file).metadata().unwrap().len();
            assert_eq!(size(&out), size("good"), "{file}");
        }
    }
    assert_eq!(failed, 2);
}
