//! Planes of symmetry, by the program: the quarter and the half of a body against the whole,
//! which `solver mirror` makes of them.

use mesh::Vec3;
use mesh::io::read_tets;
use mesh::io::vtu::read_vtu;
use tests::symmetric::{LEVELS, LOADS, PARTS, difference, find, nodes, workdir};
use tests::workdir::Workdir;

/// Largest difference of displacements, relative to the largest, set before it was measured.
const SAME: f64 = 1e-9;

const CHAMBER: &str = "[[chamber]]\non = \"cavity\"\npressure = 8e3\n";

/// Writes the scene of each part and simulates it.
fn simulate_all(dir: &Workdir, head: &str, more: &str) {
    for (part, symmetry, _) in PARTS {
        let scene = format!("mesh = \"{part}.msh\"\n{head}\n{symmetry}{more}{LOADS}");
        dir.write(&format!("{part}.toml"), &scene);
        dir.solver(&format!("simulate {part}.toml -o {part}")).assert_good();
    }
}

/// Each part must move as the whole does, with a whole share of its volumes and energies.
fn assert_same(dir: &Workdir) {
    let whole = nodes(dir, "whole");
    let of_whole = dir.json("whole/report.json");
    for (part, _, count) in &PARTS[1..] {
        let off = difference(&nodes(dir, part), &whole);
        assert!(off < SAME, "{part} {off}");
        let report = dir.json(&format!("{part}/report.json"));
        let number = |v: &serde_json::Value, at: &str| v.pointer(at).unwrap().as_f64().unwrap();
        // relative to another number: of a prescribed volume the energy is zero
        let near_to = |pointer: &str, share: f64, size: &str| {
            let (found, expected) = (share * number(&report, pointer), number(&of_whole, pointer));
            let error = ((found - expected) / number(&of_whole, size)).abs();
            assert!(error < 1e-9, "{part} {pointer} {found} {expected}");
        };
        let near = |pointer: &str, share: f64| near_to(pointer, share, pointer);
        near("/chambers/cavity/volume_rest", *count);
        near("/chambers/cavity/volume", *count);
        near("/chambers/cavity/pressure", 1.0);
        near("/energies/elastic", *count);
        near_to("/energies/chamber", *count, "/energies/elastic");
    }
}

/// Closed chambers, whose rims slide in the planes; open ones, whose rim of the quarter has an arc at the seat, where a cap
/// closes it; gas, of which the pressure follows from the volume; motion; and two fabrics at ±45° to a plane, each the
/// mirror image of the other, of which one alone has none.
#[test]
fn parts_are_as_the_whole() {
    let chamber = |law: &str| format!("[[chamber]]\non = \"cavity\"\n{law}\n");
    let time = "[time]\nend = 0.02\nsteps = 4\nmethod = \"bdf2\"\n";
    let fabric = |y: f64| {
        format!(
            "[[membrane]]\non = \"top\"\nthickness = 1e-4\ndirection = [1, {y}, 0]\n\
             material = {{ kind = \"woven\", warp = 3e6, weft = 1e6, shear = 2e5, poisson = 0.3 }}\n"
        )
    };
    for (open, degree, more) in [
        (false, 1, CHAMBER.to_owned()),
        (false, 2, CHAMBER.to_owned()),
        (true, 1, chamber("fill = 9e3\nambient = 101.3e3\nexponent = 1.4")),
        (true, 1, chamber("volume_factor = 1.2")),
        (true, 1, time.to_owned() + CHAMBER),
        (false, 1, fabric(1.0) + &fabric(-1.0) + CHAMBER),
    ] {
        let dir = workdir(open);
        simulate_all(&dir, &format!("degree = {degree}"), &more);
        assert_same(&dir);
        if more.contains("membrane") {
            dir.write("one.toml", &dir.text("quarter.toml").replace(&fabric(-1.0), ""));
            let words = ["[[membrane]] on \"top\"", "mirror image", "the opposite angle"];
            dir.solver("simulate one.toml -o one").assert_refused(2, &words);
        }
    }
}

/// Mirrored results of a part are those of the whole.
#[test]
fn a_mirrored_result_is_that_of_the_whole() {
    let dir = workdir(false);
    simulate_all(&dir, "degree = 2", CHAMBER);
    dir.solver("mirror quarter -o mirrored").assert_good();
    let (mirrored, whole) = (nodes(&dir, "mirrored"), nodes(&dir, "whole"));
    assert_eq!(mirrored.len(), whole.len());
    let off = difference(&mirrored, &whole);
    assert!(off < SAME, "{off}");
    assert_eq!(
        dir.files("mirrored"),
        dir.files("quarter")
            .into_iter()
            .filter(|name| ![".json", ".jsonl", ".csv"].iter().any(|end| name.ends_with(end)))
            .collect::<Vec<_>>()
    );
    let grid = |folder: &str| read_vtu(&dir.path(&format!("{folder}/result.vtu"))).unwrap();
    assert_eq!(grid("mirrored").cell_count(), grid("whole").cell_count());
    dir.solver("mirror whole -o out").assert_refused(2, &["report.json", "no [[symmetry]]"]);
    dir.solver("mirror quarter --on cavity -o out").assert_refused(2, &["--on cavity"]);
    dir.solver("mirror quarter -o quarter").assert_refused(2, &["another folder"]);
    dir.solver("mirror quarter.msh --on cut_y -o half.msh").assert_refused(2, &["\"cut_y\""]);
    dir.solver("mirror quarter.msh -o out.msh").assert_refused(2, &["--on TAG"]);
    dir.solver("mirror quarter.msh --on skin -o out.msh").assert_refused(2, &["one plane"]);
}

const OBJECTIVES: &str = r#"
[shape]
on = "cavity"

[[shape.level]]
vertices = true
iterations = 2

[[objective]]
kind = "displacement"
name = "top moves"
weight = 1e9
on = ["top", "skin"]
displacement = [1e-3, 0, 0]

[[objective]]
kind = "volume"
name = "air"
weight = 1e3
on = "cavity"
measure = "deformed"

[[objective]]
kind = "stress"
name = "stress"
weight = 1e-4

[[objective]]
kind = "strain-limit"
name = "strain"
weight = 1e7
largest = 1.001

[[objective]]
kind = "smoothness"
name = "smooth"
weight = 1e-2
on = "cavity"
"#;

/// dJ/dX of J, the sum over all parts, at a vertex of a part is that at the same vertex of
/// the whole; in a plane half of it, as the other half belongs to the image.
#[test]
fn gradients_by_the_rest_shape_fold_into_the_part() {
    for (degree, open) in [(1, true), (2, false)] {
        let dir = workdir(open);
        let gradient = |part: &str, symmetry: &str, field: usize| {
            let head = format!("mesh = \"{part}.msh\"\ndegree = {degree}\n");
            dir.write(&format!("{part}.toml"), &format!("{head}{symmetry}{CHAMBER}{LOADS}"));
            let design = format!("scene = \"{part}.toml\"\n{OBJECTIVES}");
            dir.write("design.toml", &design);
            dir.solver("gradient design.toml -o out").assert_good();
            let grid = read_vtu(&dir.path("out/gradient.vtu")).unwrap();
            let values = grid.point_fields[field].values.chunks_exact(3);
            let values: Vec<Vec3> = values.map(Vec3::from_column_slice).collect();
            (grid.points, values)
        };
        // of the boundary that the interior follows, and of each vertex
        for field in [0, 1] {
            let (places, whole) = gradient("whole", "", field);
            let largest = whole.iter().map(Vec3::norm).fold(0.0, f64::max);
            for (part, symmetry, _) in &PARTS[1..] {
                let (own, folded) = gradient(part, symmetry, field);
                let cuts = [(1, LEVELS[0]), (2, LEVELS[1])];
                let cuts = &cuts[if *part == "half" { 1 } else { 0 }..];
                let mut worst = 0.0_f64;
                for (i, &v) in find(&own, &places).iter().enumerate() {
                    let planes =
                        cuts.iter().filter(|(axis, level)| own[i][*axis] == *level).count();
                    let expected = whole[v] / f64::from(1 << planes);
                    worst = worst.max((folded[i] - expected).norm() / largest);
                }
                assert!(worst < 1e-8, "{degree} {part} {worst}");
            }
        }
    }
}

/// The quarter under pressure.
pub fn quarter() -> Workdir {
    let dir = workdir(false);
    let head = format!("mesh = \"quarter.msh\"\ndegree = 1\n{}", PARTS[2].1);
    dir.write("sim.toml", &format!("{head}{CHAMBER}{LOADS}"));
    dir
}

/// The Taylor test of the program, with handles on and off the planes and with all vertices;
/// then a few iterations, after which the cuts are still in their planes.
#[test]
fn designs_keep_to_the_planes() {
    let dir = quarter();
    let handles =
        "[[shape.level]]\nhandles = 4\niterations = 3\n\n[[shape.level]]\nvertices = true";
    dir.write("vertices.toml", &format!("scene = \"sim.toml\"\n{OBJECTIVES}"));
    let both = OBJECTIVES.replacen("[[shape.level]]\nvertices = true", handles, 1);
    dir.write("design.toml", &format!("scene = \"sim.toml\"\n{both}"));
    dir.solver("check design.toml --design-only").assert_good();
    dir.solver("check vertices.toml --design-only").assert_good();
    dir.solver("optimize design.toml -o out").assert_good();
    let (before, after) = (dir.path("quarter.msh"), dir.path("out/design.msh"));
    let [before, after] = [before, after].map(|path| read_tets(&path).unwrap());
    let mut slid = 0.0_f64;
    for (axis, level) in [(1, LEVELS[0]), (2, LEVELS[1])] {
        for (facet, &id) in &before.tags.facets {
            if before.tags.names[id as usize - 1] == ["cut y", "cut z"][axis - 1] {
                for v in facet {
                    assert_eq!(after.mesh.vertices[*v][axis], level);
                    slid = slid.max((after.mesh.vertices[*v] - before.mesh.vertices[*v]).norm());
                }
            }
        }
    }
    assert!(slid > 1e-5, "{slid}");
    dir.solver("mirror out -o whole-result").assert_good();
}
