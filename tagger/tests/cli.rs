//! The program as its users run it, on a block of 5 × 5 × 5 cubes of 1 mm with
//! a blind hole from below: seat = underside, cavity = wall of the hole.

#![allow(clippy::unwrap_used)]

#[path = "../../fab/tests/fixture/cubes.rs"]
mod cubes;
#[path = "../../fab/tests/fixture/run.rs"]
#[allow(dead_code)]
mod run;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use cubes::Cubes;
use mesh::{SurfaceMesh, Tags, TetMesh, Vec3, io, topology};
use run::Run;
use tempfile::TempDir;

const CUBES: usize = 5;
const SIDE: f64 = 1e-3;

/// The block, with the tags of its three patches.
fn block() -> (TetMesh, Tags) {
    let hole = |[x, y, z]: [usize; 3]| x == 2 && y == 2 && z < 3;
    Cubes { count: [CUBES; 3], solid: |_| true, chamber: hole }.mesh(SIDE)
}

/// The facets with a tag whose centroid is picked.
fn patch((mesh, tags): &(TetMesh, Tags), tag: &str, pick: impl Fn(&Vec3) -> bool) -> SurfaceMesh {
    let centroid = |f: &[usize; 3]| f.iter().map(|&v| mesh.vertices[v]).sum::<Vec3>() / 3.0;
    let own = |f: &[usize; 3]| tags.get(*f) == tags.id(tag) && pick(&centroid(f));
    let facets: Vec<_> = topology::boundary(mesh).facets.into_iter().filter(own).collect();
    topology::submesh(&mesh.vertices, &facets).0
}

struct Scene {
    dir: TempDir,
}

impl Scene {
    /// A folder with volume.msh and the three patches.
    fn new() -> Self {
        Self::of(&block())
    }

    /// A folder with the volume.msh and three patches of a block that was bent a little.
    fn of(block: &(TetMesh, Tags)) -> Self {
        let scene = Self { dir: tempfile::tempdir().unwrap() };
        scene.write_volume(&block.0);
        for tag in ["seat", "cavity", "skin"] {
            scene.write_patch(&format!("{tag}.obj"), &patch(block, tag, |_| true));
        }
        scene
    }

    fn write_volume(&self, mesh: &TetMesh) {
        io::write_tets(&self.path("volume.msh"), mesh, &Tags::default()).unwrap();
    }

    fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    fn write_patch(&self, name: &str, surface: &SurfaceMesh) {
        io::write_surface(&self.path(name), surface).unwrap();
    }

    fn run(&self, args: &[&str]) -> Run {
        let mut command = Command::new(env!("CARGO_BIN_EXE_tagger"));
        command.args(args).current_dir(self.dir.path()).output().unwrap().into()
    }

    fn tag(&self, config: &str) -> Run {
        fs::write(self.path("tags.toml"), config).unwrap();
        self.run(&["tag", "volume.msh", "--config", "tags.toml", "-o", "tagged.msh"])
    }

    /// A tag file is refused with an exit code and all of `expected`, and no result.
    fn fails(&self, config: &str, code: i32, expected: &[&str]) {
        self.tag(config).ended(code, expected);
        assert!(!self.path("tagged.msh").exists());
    }
}

const PATCHES: &str = r#"
    [[tag]]
    name = "seat"
    patch = "seat.obj"
    [[tag]]
    name = "cavity"
    patch = "cavity.obj"
    pressure = true
    rim = "seat"
    [[tag]]
    name = "skin"
    patch = "skin.obj"
"#;

fn facet_count(path: &Path, name: &str) -> usize {
    let file = io::read_tets(path).unwrap();
    file.tags.facets_of(file.tags.id(name).unwrap()).len()
}

#[test]
fn several_patches_and_picked_faces_are_tags() {
    let scene = Scene::new();
    let tags = "[[tag]]\nname = \"outside\"\npatch = [\"se*.obj\", \"skin.obj\"]\n\
                [[tag]]\nname = \"hole\"\npatch = \"cav*\"\n";
    scene.tag(tags).good();
    let tagged = scene.path("tagged.msh");
    assert_eq!(["outside", "hole"].map(|name| facet_count(&tagged, name)), [298, 26]);

    let picked = |angle: f64| {
        format!(
            "[[tag]]\nname = \"top\"\npoint = {{ at = [2.5e-3, 2.5e-3, 9e-3], angle = {angle} }}\n"
        )
    };
    scene.tag(&picked(40.0)).good();
    assert_eq!(facet_count(&tagged, "top"), 50); // 25 squares
    scene.tag(&picked(180.0)).good();
    assert_eq!(facet_count(&tagged, "top"), 324);
}

#[test]
fn patches_partition_the_boundary() {
    let scene = Scene::new();
    let message = scene.tag(PATCHES).good().to_owned();
    assert!(message.contains("0 contested, 0 of 324 facets left over"), "{message}");
    let tagged = scene.path("tagged.msh");
    // two triangles per square: 25 − 1 below, 4 × 3 + 1 in the hole, 5 × 25 outside
    let counts = ["seat", "cavity", "skin"].map(|name| facet_count(&tagged, name));
    assert_eq!(counts, [48, 26, 250]);
    let shown = scene.run(&["show", "tagged.msh"]);
    let json: serde_json::Value =
        serde_json::from_slice(&fs::read(scene.path("tags.json")).unwrap()).unwrap();
    assert_eq!(json["names"][1], "cavity");
    assert_eq!(json["ids"][1], 2);
    // 13 squares of 1 mm², summed with rounding of order 1e-16 relative
    assert!((json["areas"][1].as_f64().unwrap() - 13e-6).abs() < 1e-18);
    shown.good();
    let table = shown.stdout.clone();
    assert_eq!(fs::read_to_string(scene.path("tags.txt")).unwrap(), table);
    let row = |name: &str| -> Vec<String> {
        let line = table.lines().find(|l| l.starts_with(name)).unwrap();
        line.split_whitespace().map(str::to_owned).collect()
    };
    assert_eq!(row("seat"), ["seat", "1", "48", "24.000", "1", "2"]);
    assert_eq!(row("cavity"), ["cavity", "2", "26", "13.000", "1", "1"]);
}

#[test]
fn other_selectors_pick_the_same_facets() {
    let scene = Scene::new();
    let config = r#"
        [[tag]]
        name = "seat"
        plane = { point = [0, 0, 0], normal = [0, 0, -2] }
        [[tag]]
        name = "cavity"
        box = { min = [0.0019, 0.0019, 0.0], max = [0.0031, 0.0031, 0.0031] }
        pressure = true
        rim = "seat"
        [[tag]]
        name = "skin"
        component = 0
    "#;
    let message = scene.tag(config).good().to_owned();
    assert!(
        message.contains("skin: 250 facets") && message.contains("74 contested, 0 of 324"),
        "{message}"
    );
    // a box that takes a part of a patch
    let half = "[[tag]]\nname = \"half\"\nbox = { min = [-1, -1, -1], max = [0.002, 1, 1e-6] }\n";
    let config = format!("{half}{PATCHES}").replace("pressure = true\n    rim = \"seat\"", "");
    let message = scene.tag(&config).good().to_owned();
    assert!(message.contains("warning: seat: area 14.000 mm² differs by 41.7 %"), "{message}");
}

#[test]
fn closed_volume_selects_by_winding_number() {
    let scene = Scene::new();
    // a slab around the underside, turned inside out on purpose
    let slab =
        mesh::solid::Solid::cube(&Vec3::new(-1e-4, -1e-4, -1e-4), &Vec3::new(5.1e-3, 5.1e-3, 1e-4));
    let mut surface = slab.to_surface();
    surface.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    scene.write_patch("slab.obj", &surface);
    scene.tag("[[tag]]\nname = \"seat\"\nvolume = \"slab.obj\"\n").good();
    assert_eq!(facet_count(&scene.path("tagged.msh"), "seat"), 48);
}

#[test]
fn what_selects_nothing_or_cannot_be_meant_is_refused() {
    let scene = Scene::new();
    let block = block();
    let seat = patch(&block, "seat", |_| true);
    let mut far = seat.clone();
    far.vertices.iter_mut().for_each(|v| v.z -= 0.01);
    let mut turned = seat;
    turned.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    // a seat that ends one square before the mouth of the hole at one side
    let short = patch(&block, "seat", |c| c.x < 2.0 * SIDE);
    let surfaces =
        [("far", &far), ("turned", &turned), ("short", &short), ("sheet", &sheet(3.5 * SIDE))];
    for (name, surface) in surfaces {
        scene.write_patch(&format!("{name}.obj"), surface);
    }
    let tag = |keys: &str| format!("[[tag]]\nname = \"seat\"\n{keys}\n");
    let all = "[[tag]]\nname = \"all\"\ncomponent = 0\n".to_owned();
    for (config, code, words) in [
        (
            tag("patch = \"far.obj\""),
            1,
            &["`seat`: empty selection", "1.000e-2 m", "epsilon is 8.660e-6 m"][..],
        ),
        (tag("patch = \"turned.obj\""), 1, &["48 facets lie within epsilon", "face the other way"]),
        // the first selection wins
        (
            all + &tag("patch = \"seat.obj\""),
            1,
            &["`seat`: empty selection: all its 48 facets", "`all` (48)"],
        ),
        // the outer border has 4 × 5 edges, the hole 4
        (
            tag("volume = \"seat.obj\""),
            2,
            &["not closed: 24 boundary edges, first", "cad2fem offset"],
        ),
        (
            PATCHES.replace("seat.obj", "short.obj"),
            1,
            &[
                "3 edges of the rim",
                "`seat`",
                "1 boundary loops",
                "4 edges, 4.000 mm",
                "first vertex",
            ],
        ),
        (
            tag("patch = \"cavity.obj\"\npressure = true"),
            1,
            &["the pressure wall is open: 1 boundary loops", "rim ="],
        ),
        (
            tag("ptach = \"seat.obj\""),
            2,
            &["tags.toml:3:1", "unknown field `ptach`; did you mean `patch`?", "`patch`, `volume`"],
        ),
        (
            tag("point = { at = [0, 0, 0], angle = 200 }"),
            2,
            &["angle = 200°: must lie between 0 and 180°"],
        ),
        (tag("patch = \"face-*.stl\""), 2, &["is called face-*.stl; there are", "skin.obj"]),
        (tag("patch = \"none.obj\""), 2, &["is called none.obj; there are", "skin.obj"]),
        // the mesh does not follow the sheet
        (
            format!("{PATCHES}{SHEET}"),
            1,
            &["[[tag]] `sheet`", "0 facets inside", "does not follow", "tetmesh SURFACE --inside"],
        ),
    ] {
        scene.fails(&config, code, words);
    }
    let whole = fs::read(scene.path("volume.msh")).unwrap();
    fs::write(scene.path("volume.msh"), &whole[..whole.len() / 2]).unwrap();
    scene.fails(PATCHES, 2, &["volume.msh"]);
}

#[test]
fn pinhole_is_filled() {
    let scene = Scene::new();
    let mut wall = patch(&block(), "cavity", |_| true);
    let top = |t: &[usize; 3]| t.iter().all(|&v| wall.vertices[v].z > 2.9 * SIDE);
    let hole = wall.triangles.iter().position(top).unwrap();
    wall.triangles.remove(hole);
    scene.write_patch("cavity.obj", &wall);
    let plain = PATCHES.replace("pressure = true\n    rim = \"seat\"", "");
    for config in [PATCHES, &plain] {
        let message = scene.tag(config).good().to_owned();
        assert!(
            message.contains("cavity: 26 facets, 13.000 mm², 0 contested, 1 pinholes"),
            "{message}"
        );
        assert!(message.contains(", 0 of "), "{message}");
    }
}

/// A mouth that narrows upward, and a sliver on its rim that faces up: neither the seat nor the
/// wall does.
#[test]
fn a_sliver_on_the_rim_does_not_open_the_wall() {
    let (mut mesh, tags) = block();
    let at = |mesh: &TetMesh, place: [f64; 3]| {
        let place = SIDE * Vec3::from(place);
        mesh.vertices.iter().position(|p| (p - place).norm() < 1e-9).unwrap()
    };
    for place in [[2.0, 2.0, 1.0], [3.0, 2.0, 1.0]] {
        let v = at(&mesh, place);
        mesh.vertices[v].y += 0.3 * SIDE;
    }
    let scene = Scene::of(&(mesh.clone(), tags));
    // 6 µm across the rim and half a micrometre below the seat; epsilon is 8.7 µm
    let rim = [at(&mesh, [2.0, 2.0, 0.0]), at(&mesh, [3.0, 2.0, 0.0])];
    let beside = |f: &[usize; 3]| {
        rim.iter().all(|v| f.contains(v)) && f.iter().all(|&v| mesh.vertices[v].z == 0.0)
    };
    let [a, b, c] = topology::boundary(&mesh).facets.into_iter().find(beside).unwrap();
    mesh.vertices.push(Vec3::new(2.5 * SIDE, 2.0 * SIDE + 6e-6, -5e-7));
    mesh.tets.push([a, b, c, mesh.vertices.len() - 1]);
    scene.write_volume(&mesh);
    let message = scene.tag(PATCHES).good().to_owned();
    assert!(message.contains("0 contested, 0 of "), "{message}");
}

/// Two triangles across the block at a height [m].
fn sheet(z: f64) -> SurfaceMesh {
    let end = CUBES as f64 * SIDE;
    let corners = [(0.0, 0.0), (end, 0.0), (end, end), (0.0, end)];
    let vertices = corners.map(|(x, y)| Vec3::new(x, y, z)).to_vec();
    SurfaceMesh { vertices, triangles: vec![[0, 1, 2], [0, 2, 3]] }
}

const SHEET: &str = "[[tag]]\nname = \"sheet\"\npatch = \"sheet.obj\"\ninside = true\n";

#[test]
fn a_sheet_inside_is_one_layer_of_facets() {
    let scene = Scene::new();
    scene.write_patch("sheet.obj", &sheet(4.0 * SIDE));
    let message = scene.tag(&format!("{PATCHES}{SHEET}")).good().to_owned();
    assert!(message.contains("sheet: 50 facets inside, 25.000 mm²"), "{message}");
    let tagged = scene.path("tagged.msh");
    // two triangles per square, and the boundary as without it
    let counts = ["seat", "cavity", "skin", "sheet"].map(|name| facet_count(&tagged, name));
    assert_eq!(counts, [48, 26, 250, 50]);
    // above the hole it is a part of the boundary, and no sheet; the rest of its plane is
    scene.write_patch("sheet.obj", &sheet(3.0 * SIDE));
    let message = scene.tag(&format!("{PATCHES}{SHEET}")).good().to_owned();
    assert!(message.contains("sheet: 48 facets inside, 24.000 mm²"), "{message}");
}

const VOLUMES: &str = r#"
    [[volume]]
    name = "floor"
    box = { min = [-1, -1, -1], max = [1, 1, 0.001] }
    [[volume]]
    name = "roof"
    plane = { point = [0, 0, 0.004], normal = [0, 0, 1] }
"#;

#[test]
fn tetrahedra_are_named_and_keep_their_names() {
    let scene = Scene::new();
    let message = scene.tag(&format!("{PATCHES}{VOLUMES}")).good().to_owned();
    // six per cube, and one cube less where the hole is
    for line in ["floor: 144 tetrahedra, 24.000 mm³", "roof: 150 tetrahedra, 25.000 mm³"] {
        assert!(message.contains(line), "{message}");
    }
    assert!(!message.contains("cross its surface"), "{message}");
    let count = |name: &str| {
        let volumes = io::read_tets(&scene.path(name)).unwrap().tags.volumes;
        let count = |i: usize| volumes.of.iter().filter(|&&of| of == i).count();
        volumes.names.iter().enumerate().map(|(i, n)| (n.clone(), count(i))).collect::<Vec<_>>()
    };
    let expected = [("floor", 144), ("roof", 150), ("body", 6 * 122 - 294)];
    let expected = expected.map(|(name, count)| (name.to_owned(), count));
    assert_eq!(count("tagged.msh"), expected);
    // tagged again without volumes it keeps those that it has
    fs::rename(scene.path("tagged.msh"), scene.path("volume.msh")).unwrap();
    scene.tag(PATCHES).good();
    assert_eq!(count("tagged.msh"), expected);
}

#[test]
fn volumes_that_overlap_are_refused_and_rough_ones_told() {
    let scene = Scene::new();
    let volumes = format!("{PATCHES}{VOLUMES}");
    let words = ["[[volume]] `floor` and [[volume]] `roof` overlap", "mm³, are in both"];
    scene.fails(&volumes.replace("0.004]", "0.0005]"), 1, &words);
    let words = ["[[volume]] `roof`: no centroid"];
    scene.fails(&volumes.replace("0, 0, 0.004", "0, 0, 0.4"), 1, &words);
    let words = ["unknown field `patch`, expected one of `name`, `volume`, `plane`, `box`"];
    let patch = format!("{PATCHES}[[volume]]\nname = \"a\"\npatch = \"seat.obj\"\n");
    scene.fails(&patch, 2, &words);
    let message = scene.tag(&volumes.replace("0, 0, 0.004", "0, 0, 0.0035"));
    message.ended(0, &["volume roof", "cross its surface"]);
}
