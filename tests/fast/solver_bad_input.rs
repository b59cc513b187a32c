//! `solver` given files that are missing or broken, folders that cannot be made, and loads that cannot be borne.

use mesh::Tags;
use mesh::io::{read_tets, write_tets};
use tests::chamber;
use tests::workdir::Workdir;

#[test]
fn missing_files_and_arguments() {
    let dir = chamber::workdir();
    dir.solver("simulate none.toml -o out").assert_refused(2, &["none.toml", "No such file"]);
    dir.solver("optimize none.toml -o out").assert_refused(2, &["none.toml", "No such file"]);
    dir.solver("simulate sim.toml --mesh none.msh -o out").assert_refused(2, &["none.msh"]);
    dir.solver("simulate sim.toml").assert_refused(2, &["--output"]);
    dir.solver("simulat sim.toml").assert_refused(2, &["simulat"]);
    dir.solver("simulate p1.toml --threads 1025 -o out").assert_refused(2, &["0..=1024"]);
    std::fs::remove_file(dir.path("target.stl")).unwrap();
    dir.solver("optimize design.toml -o none").assert_refused(2, &["target.stl", "No such file"]);
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
    dir.solver("simulate sim.toml -o out")
        .assert_refused(2, &["sim.toml", "\"seat\"", "other, cavity, top, skin"]);
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
    zero.assert_says(&["all its loads are zero"]);
    let text = dir.text("p1.toml");
    dir.write("p1.toml", &text[..text.find("[[chamber]]").unwrap()]);
    dir.solver("simulate p1.toml -o none").assert_refused(2, &[remark, "[[chamber]]"]);
    assert!(!dir.path("none").exists());
}

/// A file where the folder should be: refused for root, too, who may write
/// everywhere else.
#[test]
fn a_folder_that_cannot_be_made() {
    let dir = chamber::workdir();
    dir.write("taken", "mine");
    for output in ["taken", "taken/out"] {
        dir.solver(&format!("simulate p1.toml -o {output}")).assert_refused(2, &[output]);
        dir.solver(&format!("optimize design.toml -o {output}")).assert_refused(2, &[output]);
    }
    assert_eq!(dir.text("taken"), "mine");
}
