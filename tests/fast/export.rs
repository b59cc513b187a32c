//! `solver export`: decks of CalculiX and FEBio say what the scene says, and CalculiX finds the same displacements where it
//! is installed.

use std::collections::BTreeMap;
use std::process::Command;

use mesh::Vec3;
use mesh::io::npy;
use tests::chamber::{self, SIM};
use tests::skip::skip;

/// Corners beside each middle node, in the manuals of both programs.
const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];
/// Corners of the faces 1 to 4 in the manual of CalculiX.
const FACES: [[usize; 3]; 4] = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];
/// Everything that a deck can say.
const LOADS: &str = r#"
gravity = [0, 0, -9.81]

[[fixed]]
on = "top"
components = "z"
displacement = [0, 0, "0.1*x"]

[[traction]]
on = "skin"
traction = [0, 100, 0]
"#;

/// The lines below the first line that begins so, up to the next keyword.
fn block<'a>(deck: &'a str, keyword: &str) -> Vec<&'a str> {
    let mut lines = deck.lines().skip_while(|line| !line.starts_with(keyword));
    assert!(lines.next().is_some(), "no {keyword}");
    lines.take_while(|line| !line.starts_with('*')).filter(|line| !line.trim().is_empty()).collect()
}

fn numbers(line: &str) -> Vec<f64> {
    let words = line.split(',').map(str::trim).filter(|word| !word.is_empty());
    words.map(|word| word.parse().unwrap_or_else(|_| panic!("{line}"))).collect()
}

/// The nodes of a deck, and the nodes of its elements, counted from 1.
fn mesh_of(deck: &str) -> (Vec<Vec3>, Vec<Vec<usize>>) {
    let nodes = block(deck, "*NODE,")
        .into_iter()
        .map(|line| 1e-3 * Vec3::from_column_slice(&numbers(line)[1..]));
    let ids = |line: &str| numbers(line)[1..].iter().map(|id| *id as usize).collect();
    (nodes.collect(), block(deck, "*ELEMENT,").into_iter().map(ids).collect())
}

fn scene(degree: usize, law: &str, more: &str) -> String {
    let start = SIM.find("kind").unwrap();
    let end = SIM.find("[[fixed]]").unwrap();
    let (top, tables) = more.split_at(more.find("\n[[").map_or(0, |at| at + 1));
    format!(
        "{top}{}{law}\ndensity = 1000\n\n{}{tables}",
        SIM[..start].replace("degree = 2", &format!("degree = {degree}")),
        &SIM[end..]
    )
}

const LOGARITHMIC: &str = "kind = \"mooney-rivlin\"\nc1 = 55e3\nc2 = 5e3\nc3 = 1.7e3\nd1 = 1e6";
const QUADRATIC: &str =
    "kind = \"mooney-rivlin-quadratic\"\nc1 = 55e3\nc2 = 5e3\nc3 = 1.7e3\nd1 = 1e6";

#[test]
fn a_deck_of_calculix_has_nodes_faces_and_sets_where_they_belong() {
    let dir = chamber::workdir();
    dir.write("sim.toml", &scene(2, LOGARITHMIC, LOADS));
    let run = dir.solver("export sim.toml -o deck.inp");
    run.assert_good();
    assert!(
        run.stderr.contains("another energy") && run.stderr.contains("(J - 1)"),
        "{}",
        run.stderr
    );
    let deck = dir.text("deck.inp");
    let (x, elements) = mesh_of(&deck);
    assert_eq!(elements.len(), 384);
    let corner = |element: &[usize], i: usize| x[element[i] - 1];
    for element in &elements {
        for (i, [a, b]) in EDGES.into_iter().enumerate() {
            let middle = 0.5 * (corner(element, a) + corner(element, b));
            assert!((corner(element, 4 + i) - middle).norm() < 1e-12);
        }
        let [a, b, c, d] = [0, 1, 2, 3].map(|i| corner(element, i));
        assert!((b - a).cross(&(c - a)).dot(&(d - a)) > 0.0);
    }
    // the wall of the chamber, without its mouth: 4 sides of 40 × 20 mm and the end, seen from the solid
    let (mut area, mut vector) = (0.0, Vec3::zeros());
    for line in block(&deck, "*DLOAD") {
        let words: Vec<&str> = line.split(',').map(str::trim).collect();
        let element = &elements[words[0].parse::<usize>().unwrap() - 1];
        let face = FACES[words[1].strip_prefix('P').unwrap().parse::<usize>().unwrap() - 1];
        assert_eq!(words[2].parse::<f64>().unwrap(), 8e3);
        let [a, b, c] = face.map(|i| corner(element, i));
        let inner = corner(element, (0..4).find(|i| !face.contains(i)).unwrap());
        let normal = 0.5 * (b - a).cross(&(c - a));
        let outward = normal * -normal.dot(&(inner - a)).signum();
        area += outward.norm();
        vector += outward;
    }
    assert!(
        (area - 3.6e-3).abs() < 1e-12 && (vector - Vec3::new(-4e-4, 0.0, 0.0)).norm() < 1e-12,
        "{area} {vector}"
    );
    let sets: Vec<usize> = block(&deck, "*NSET, NSET=FIX_XYZ_seat")
        .into_iter()
        .flat_map(|line| numbers(line).into_iter().map(|id| id as usize))
        .collect();
    assert!(sets.iter().all(|id| x[id - 1].x < 1e-9) && sets.len() > 50);
    let forces =
        block(&deck, "*CLOAD").into_iter().map(numbers).fold(Vec3::zeros(), |mut sum, line| {
            sum[line[1] as usize - 1] += 1e-6 * line[2];
            sum
        });
    // 64 cm³ of 1000 kg/m³, and 100 Pa on the sides and the far end
    let skin: f64 = 2.0 * 0.05 * 0.04 + 0.05 * 0.04 + 0.04 * 0.04;
    assert!((forces - Vec3::new(0.0, 100.0 * skin, -9.81 * 0.064)).norm() < 1e-9, "{forces}");
    assert!(deck.contains("*HYPERELASTIC, POLYNOMIAL, N=2\n5.5"), "the law");
}

#[test]
fn laws_are_those_of_calculix() {
    if Command::new("ccx").arg("-v").output().is_err() {
        return skip("ccx (CalculiX) is not installed");
    }
    // laws that are the same there, and linear elements, which are integrated alike: only convergence differs
    let exact = [
        (QUADRATIC, 2e-6),
        ("kind = \"saint-venant-kirchhoff\"\nyoung = 3e5\npoisson = 0.4", 2e-6),
        (LOGARITHMIC, 5e-3),
        ("kind = \"mooney-rivlin\"\nc1 = 55e3\nc2 = 5e3\nc3 = 0\nd1 = 1e6", 5e-3),
        ("kind = \"yeoh\"\nc1 = 55e3\nc2 = 2.25e3\nc3 = -54\nbulk = 2e6", 5e-3),
        ("kind = \"ogden\"\nmu = [34e3, -12e3]\nalpha = [2.9, -1.7]\nbulk = 2.5e6", 5e-3),
        ("kind = \"arruda-boyce\"\nmu = 60e3\nlambda_m = 2.8\nbulk = 2.4e6", 5e-3),
        ("kind = \"neo-hookean\"\nyoung = 3e5\npoisson = 0.49", 5e-3),
    ];
    for (law, within) in exact {
        let apart = difference(&scene(1, law, LOADS));
        let name = law.lines().next().unwrap();
        assert!(apart < within, "{name}: {apart:.1e}, not below {within:.0e}");
    }
    // of degree 2 CalculiX has 4 points in an element, and we 14
    let apart = difference(&scene(2, QUADRATIC, LOADS));
    assert!(apart < 5e-3, "degree 2: {apart:.1e}");
}

/// The largest difference of the displacement of a node over the largest displacement.
fn difference(scene: &str) -> f64 {
    let dir = chamber::workdir();
    dir.write("sim.toml", scene);
    dir.solver("export sim.toml -o deck.inp").assert_good();
    dir.solver("simulate sim.toml -o run --final-only").assert_good();
    let run = Command::new("ccx").arg("deck").current_dir(dir.path("")).output().unwrap();
    let said = String::from_utf8_lossy(&run.stdout);
    assert!(run.status.success() && !said.contains("*ERROR"), "{said}");
    let table = dir.text("deck.dat");
    let (_, last) = table.rsplit_once("displacements").unwrap();
    let mut lines = last.lines();
    let time = lines.next().and_then(|line| line.split_whitespace().last()).unwrap();
    assert!((time.parse::<f64>().unwrap() - 1.0).abs() < 1e-9, "ended at {time}");
    let row = |line: &str| {
        let words = line.split_whitespace().skip(1).map(|word| word.parse::<f64>().unwrap());
        1e-3 * Vec3::from_iterator(words)
    };
    let theirs: Vec<Vec3> = lines.filter(|line| !line.trim().is_empty()).map(row).collect();
    let (ours, _) = npy::read_f64(&dir.path("run/displacement.npy")).unwrap();
    assert_eq!(ours.len(), 3 * theirs.len());
    let ours: Vec<Vec3> = ours.chunks_exact(3).map(Vec3::from_column_slice).collect();
    let apart = ours.iter().zip(&theirs).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    apart / ours.iter().map(Vec3::norm).fold(0.0, f64::max)
}

#[test]
fn a_deck_of_febio_has_what_that_of_calculix_has() {
    let dir = chamber::workdir();
    dir.write("sim.toml", &scene(2, LOGARITHMIC, LOADS));
    dir.solver("export sim.toml -o deck.inp").assert_good();
    let run = dir.solver("export sim.toml -o deck.feb");
    run.assert_good();
    assert!(!run.stderr.contains("another energy"), "{}", run.stderr);
    let (x, elements) = mesh_of(&dir.text("deck.inp"));
    let deck = dir.text("deck.feb");
    let within = |tag: &str| {
        let of = |line: &&str| line.trim_start().starts_with(&format!("<{tag} id="));
        let inner =
            |line: &str| numbers(line.split_once('>').unwrap().1.split_once('<').unwrap().0);
        deck.lines().filter(of).map(inner).collect::<Vec<_>>()
    };
    let nodes = within("node");
    assert_eq!(nodes.len(), x.len());
    assert!(nodes.iter().zip(&x).all(|(a, b)| (Vec3::from_column_slice(a) - b).norm() < 1e-12));
    let ids: Vec<Vec<usize>> =
        within("elem").iter().map(|e| e.iter().map(|id| *id as usize).collect()).collect();
    assert_eq!(ids, elements);
    // faces of all tags, counterclockwise from outside
    let mut vectors = BTreeMap::new();
    let mut surface = "";
    for line in deck.lines().map(str::trim) {
        if let Some(name) = line.strip_prefix("<Surface name=\"") {
            surface = name.trim_end_matches("\">");
        }
        if let Some(face) = line.strip_prefix("<tri6 id=") {
            let n = numbers(face.split_once('>').unwrap().1.split_once('<').unwrap().0);
            let at = |i: usize| x[n[i] as usize - 1];
            for (i, [a, b]) in EDGES[..3].iter().enumerate() {
                assert!((at(3 + i) - 0.5 * (at(*a) + at(*b))).norm() < 1e-12);
            }
            *vectors.entry(surface).or_insert(Vec3::zeros()) +=
                0.5 * (at(1) - at(0)).cross(&(at(2) - at(0)));
        }
    }
    assert!((vectors["S_cavity"] - Vec3::new(-4e-4, 0.0, 0.0)).norm() < 1e-12, "{vectors:?}");
    assert!((vectors["S_top"] - Vec3::new(0.0, 0.0, 2e-3)).norm() < 1e-12, "{vectors:?}");
    for part in [
        "<W>55000*(I1-3) + 5000*(I2-3) + 1700*(I1-3)*(I2-3)</W>",
        "<k>2e6</k>",
        "surface=\"S_cavity\" type=\"pressure\"",
        "<pressure lc=\"1\">8e3</pressure>",
        "node_set=\"FIX_XYZ_seat\" type=\"zero displacement\"",
        "<value lc=\"1\" type=\"map\">FIX_Z_top_z</value>",
    ] {
        assert!(deck.contains(part), "{part}");
    }
}
