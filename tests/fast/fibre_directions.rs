//! Directions of fibres from files.

use mesh::io::npy::write_f64;
use mesh::io::read_tets;
use tests::chamber;
use tests::workdir::Workdir;

/// The chamber with linear elements and a family that leads as `keys` say.
fn workdir(keys: &str) -> Workdir {
    let dir = chamber::workdir();
    let family = format!("\n[[fibre]]\nname = \"weave\"\nk1 = 2e5\nslack = 0.1\n{keys}\n");
    let probe = "\n[[probe]]\nname = \"air\"\nkind = \"volume\"\non = \"cavity\"\n";
    dir.write("p1.toml", &(dir.text("p1.toml") + probe + &family));
    dir
}

fn air(dir: &Workdir) -> f64 {
    dir.solver("simulate p1.toml -o out").assert_good();
    dir.probe("out", "air")
}

/// Vectors in a file of numpy.
fn write_vectors(dir: &Workdir, count: usize, vector: impl Fn(usize) -> [f64; 3]) {
    let values: Vec<f64> = (0..count).flat_map(vector).collect();
    write_f64(&dir.path("a.npy"), &values, &[count, 3]).unwrap();
}

/// [elements, vertices] of the body.
fn counts(dir: &Workdir) -> [usize; 2] {
    let body = read_tets(&dir.path("body.msh")).unwrap().mesh;
    [body.tets.len(), body.vertices.len()]
}

/// The same bits, however one direction is said.
#[test]
fn one_direction_is_the_same_from_a_formula_and_a_file() {
    let formula = workdir("direction = [1, 0, 0]");
    let expected = air(&formula).to_bits();
    let table = workdir("file = \"a.npy\"");
    let [elements, vertices] = counts(&table);
    write_vectors(&table, elements, |_| [4.0, 0.0, 0.0]);
    assert_eq!(air(&table).to_bits(), expected);
    // fibres have no sense
    write_vectors(&table, vertices, |v| [if v % 2 == 0 { 1.0 } else { -1.0 }, 0.0, 0.0]);
    assert_eq!(air(&table).to_bits(), expected);
    let grid = workdir("file = \"formula.vtu\"\nfield = \"fibre_weave_direction\"");
    std::fs::copy(formula.path("out/result.vtu"), grid.path("formula.vtu")).unwrap();
    assert_eq!(air(&grid).to_bits(), expected);
}

/// The direction of an element stays while a designed shape moves.
#[test]
fn gradients_by_shape_pass_their_test() {
    // numbers of the family change little: states are as accurate as their remainders need
    let dir = workdir(
        "file = \"a.npy\"\n[solver]\nrelative_tolerance = 1e-12\nabsolute_tolerance = 1e-14",
    );
    write_vectors(&dir, counts(&dir)[0], |_| [0.6, 0.0, 0.8]);
    dir.write(
        "design.toml",
        "scene = \"p1.toml\"\n[shape]\non = \"cavity\"\n[[shape.level]]\nhandles = 1\niterations = 1\n\
         [[objective]]\nkind = \"volume\"\nname = \"air\"\nweight = 1e6\non = \"cavity\"\nvolume = 2e-5\n\
         measure = \"deformed\"\n",
    );
    let run = dir.solver("check design.toml --handles 1 --random 1");
    run.assert_good();
    assert!(run.stdout.contains("fibre.weave"), "{}", run.stdout);
}

#[test]
fn directions_that_cannot_be_used_are_refused() {
    let refuse = |keys: &str, words: &[&str]| {
        let dir = workdir(keys);
        write_vectors(&dir, 7, |_| [1.0, 0.0, 0.0]);
        dir.solver("simulate p1.toml -o out").assert_refused(2, words);
    };
    refuse("", &["[[fibre]] \"weave\" has no direction", "around = {", "file = "]);
    refuse("direction = [1, 0, 0]\nfile = \"a.npy\"", &["direction beside file"]);
    refuse("direction = [1, 0, 0]\nangle = 4", &["angle without an axis"]);
    refuse("direction = [1, 0, 0]\nfield = \"a\"", &["field without a file"]);
    refuse("file = \"b.npy\"", &["b.npy"]);
    refuse("file = \"a.npy\"", &["a.npy: 7 vectors", "tetrahedra of the mesh"]);
    let dir = workdir("file = \"a.npy\"");
    let [elements, _] = counts(&dir);
    write_vectors(&dir, elements, |e| [if e == 3 { 0.0 } else { 1.0 }, 0.0, 0.0]);
    let run = dir.solver("simulate p1.toml -o out");
    run.assert_refused(2, &["file: no direction in the element at (", "the vector is [0, 0, 0]"]);
    write_f64(&dir.path("a.npy"), &[1.0; 4], &[2, 2]).unwrap();
    dir.solver("simulate p1.toml -o out").assert_refused(2, &["shape [2, 2]", "three columns"]);
    let made = workdir("direction = [1, 0, 0]");
    air(&made);
    let dir = workdir("file = \"made.vtu\"");
    std::fs::copy(made.path("out/result.vtu"), dir.path("made.vtu")).unwrap();
    let run = dir.solver("simulate p1.toml -o out");
    run.assert_refused(2, &["made.vtu: no vectors called \"\"", "fibre_weave_direction"]);
}
