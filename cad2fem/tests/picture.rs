//! `cad2fem picture` as its users run it, judged by the pixels that it writes.

#![allow(clippy::unwrap_used)]

use std::fs::{self, File};
use std::io::BufReader;

use crate::support::{Run, Workdir};
use mesh::io::vtu::{CellType, Field, Grid, write_vtu};
use mesh::solid::Solid;
use mesh::{SurfaceMesh, Tags, TetMesh, Vec3, io};

/// A picture that was written: 8-bit sRGB.
struct Picture {
    width: usize,
    height: usize,
    bytes: Vec<u8>,
}

fn run(dir: &Workdir, args: &str, threads: &str) -> Run {
    dir.run_with("RAYON_NUM_THREADS", threads, &format!("picture {args} -o out.png"))
}

fn draw(dir: &Workdir, args: &str) -> Picture {
    run(dir, args, "2").succeeds();
    let decoder = png::Decoder::new(BufReader::new(File::open(dir.path("out.png")).unwrap()));
    let mut reader = decoder.read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    Picture { width: info.width as usize, height: info.height as usize, bytes }
}

#[track_caller]
fn fails(dir: &Workdir, args: &str, expected: &[&str]) {
    let run = run(dir, args, "2");
    expected.iter().for_each(|words| run.fails(2, words));
    assert!(!dir.path("out.png").exists(), "{args}: a picture was left behind");
}

impl Picture {
    fn at(&self, x: usize, y: usize) -> [i32; 3] {
        let i = 3 * (y * self.width + x);
        [0, 1, 2].map(|k| i32::from(self.bytes[i + k]))
    }

    fn center(&self) -> [i32; 3] {
        self.at(self.width / 2, self.height / 2)
    }

    /// Pixels that differ from the background, which depends on the row alone.
    fn drawn(&self) -> usize {
        let differs = |x: usize, y: usize| distance(self.at(x, y), self.at(0, y)) > 2;
        (0..self.height).map(|y| (0..self.width).filter(|&x| differs(x, y)).count()).sum()
    }
}

fn distance(a: [i32; 3], b: [i32; 3]) -> i32 {
    (0..3).map(|k| (a[k] - b[k]).abs()).max().unwrap()
}

fn cube() -> SurfaceMesh {
    Solid::cube(&Vec3::zeros(), &Vec3::new(1.0, 1.0, 1.0)).to_surface()
}

/// A cube of six tetrahedra around its diagonal; the side z = 0 is tagged.
fn cube_of_tets() -> (TetMesh, Tags) {
    let bit = |i: usize, k: usize| f64::from(u8::from(i >> k & 1 == 1));
    let vertices = (0..8).map(|i| Vec3::new(bit(i, 0), bit(i, 1), bit(i, 2))).collect();
    let paths = [[1, 2, 4], [2, 4, 1], [4, 1, 2], [1, 4, 2], [4, 2, 1], [2, 1, 4]];
    let mut tets: Vec<[usize; 4]> = paths.iter().map(|[a, b, _]| [0, *a, a + b, 7]).collect();
    tets[3..].iter_mut().for_each(|t| t.swap(2, 3));
    let mut tags = Tags::new(vec!["floor".into()]);
    tags.set([0, 1, 3], 1);
    tags.set([0, 2, 3], 1);
    (TetMesh { vertices, tets }, tags)
}

/// The cube as a quadratic result: displacement (0, 0, x) and a cell field.
fn result() -> Grid {
    let (mesh, _) = cube_of_tets();
    let mut points = Vec::new();
    let mut cells = Vec::new();
    for t in 0..mesh.tets.len() {
        let corners = mesh.corners(t);
        points.extend(corners);
        let edges = CellType::Tet10.edges();
        points.extend(edges.iter().map(|&[a, b]| 0.5 * (corners[a] + corners[b])));
        cells.extend(points.len() - 10..points.len());
    }
    let shift = points.iter().flat_map(|p| [0.0, 0.0, p.x]).collect();
    Grid {
        point_fields: vec![field("displacement", "m", 3, shift)],
        cell_fields: vec![field("pressure", "Pa", 1, vec![5.0; mesh.tets.len()])],
        points,
        cells,
        cell_type: CellType::Tet10,
    }
}

fn field(name: &str, unit: &str, components: usize, values: Vec<f64>) -> Field {
    Field { name: name.into(), unit: unit.into(), components, values }
}

const PLAIN: &str = "--orthographic --no-ground --smooth --size 400x300";

#[test]
fn silhouettes_have_the_right_area() {
    let dir = Workdir::new();
    let sphere = Solid::sphere(&Vec3::zeros(), 1.0, 128).to_surface();
    io::write_surface(&dir.path("sphere.stl"), &sphere).unwrap();
    io::write_surface(&dir.path("cube.obj"), &cube()).unwrap();
    // 6 % of the height stays free on both sides
    let side = 0.88 * 300.0;
    let circle = draw(&dir, &format!("sphere.stl {PLAIN}")).drawn() as f64;
    let expected = std::f64::consts::FRAC_PI_4 * side * side;
    // the rim covers pixels in part: less than half a pixel along the circumference
    assert!((circle - expected).abs() < 0.5 * std::f64::consts::PI * side, "{circle} {expected}");
    let square = draw(&dir, &format!("cube.obj --view front {PLAIN}")).drawn() as f64;
    assert!((square - side * side).abs() < 0.5 * 4.0 * side, "{square} {}", side * side);
    // seen along its diagonal, a cube is a regular hexagon standing on a corner
    let view = "--view 45,35.264389682754654";
    let hexagon = draw(&dir, &format!("cube.obj {view} {PLAIN}")).drawn() as f64;
    let expected = 1.5 * 3.0_f64.sqrt() * (0.5 * side).powi(2);
    // a slanting rim touches up to √2 as many pixels as it is long
    assert!((hexagon - expected).abs() < 0.71 * 3.0 * side, "{hexagon} {expected}");
}

#[test]
fn cut_surface_shows_its_face_and_cut_mesh_its_section() {
    let dir = Workdir::new();
    io::write_surface(&dir.path("cube.stl"), &cube()).unwrap();
    let (mesh, _) = cube_of_tets();
    io::write_tets(&dir.path("cube.msh"), &mesh, &Tags::default()).unwrap();
    let whole = draw(&dir, &format!("cube.stl --view front {PLAIN}"));
    for name in ["cube.stl", "cube.msh"] {
        let cut = draw(&dir, &format!("{name} --view front --cut y=0.5 {PLAIN}"));
        // the same square is seen, of another colour, and evenly: the face is flat
        assert!(cut.drawn().abs_diff(whole.drawn()) < 300, "{name}");
        assert!(distance(cut.center(), whole.center()) > 20, "{name}");
        assert!(distance(cut.center(), cut.at(150, 100)) < 12, "{name}");
    }
    let nothing = format!("cube.stl --cut 0,-1,0,-2 {PLAIN}");
    fs::remove_file(dir.path("out.png")).unwrap();
    fails(&dir, &nothing, &["the cut removes everything"]);
}

#[test]
fn open_surface_shows_its_inside_in_another_colour() {
    let dir = Workdir::new();
    let mut open = cube();
    let lid = |t: &[usize; 3]| t.iter().all(|&v| open.vertices[v].y < 0.5);
    open.triangles = open.triangles.iter().copied().filter(|t| !lid(t)).collect();
    io::write_surface(&dir.path("open.obj"), &open).unwrap();
    let [r, g, _] = draw(&dir, &format!("open.obj --view front {PLAIN}")).center();
    let [back_r, back_g, _] = draw(&dir, &format!("open.obj --view back {PLAIN}")).center();
    assert!(r > g && back_g > back_r, "inside is warm, outside is green");
}

#[test]
fn tags_have_their_colours_and_names() {
    let dir = Workdir::new();
    let (mesh, tags) = cube_of_tets();
    io::write_tets(&dir.path("cube.msh"), &mesh, &tags).unwrap();
    let [r, g, b] = draw(&dir, &format!("cube.msh --view bottom {PLAIN}")).center();
    assert!(b > g && g > r, "the tagged floor has the first colour, blue: {r} {g} {b}");
    let [r, g, b] = draw(&dir, &format!("cube.msh --view top {PLAIN}")).center();
    assert!((r - b).abs() < 12 && (r - g).abs() < 12, "the rest is grey: {r} {g} {b}");
}

#[test]
fn results_are_deformed_and_coloured_by_value() {
    let dir = Workdir::new();
    write_vtu(&dir.path("cube.vtu"), &result()).unwrap();
    let rest = draw(&dir, &format!("cube.vtu --view front --deform none {PLAIN}"));
    // rest: a square; deformed: a parallelogram twice as high as wide, of the same width
    assert!(rest.drawn() > 60_000);
    let bent = draw(&dir, &format!("cube.vtu --view front {PLAIN}"));
    let half = 0.5 * (0.88_f64 * 300.0).powi(2) / 2.0;
    assert!((bent.drawn() as f64 - half).abs() < 600.0, "{} {half}", bent.drawn());

    let args = format!("cube.vtu --view front --deform none --color displacement.z {PLAIN}");
    let picture = draw(&dir, &args);
    // viridis from dark blue at x = 0 to yellow at x = 1; the scale is at the right border
    let places: Vec<usize> =
        (0..400).filter(|&x| distance(picture.at(x, 150), picture.at(0, 150)) > 2).collect();
    let [r, _, b] = picture.at(places[4], 150);
    assert!(b > r, "dark blue at the left");
    let right = places.iter().rposition(|&x| x < 300).unwrap();
    let [r, _, b] = picture.at(places[right] - 8, 150);
    assert!(r > b + 60, "yellow at the right: {r} {b}");

    draw(&dir, &format!("cube.vtu --color pressure --edges {PLAIN}"));
    draw(&dir, &format!("cube.vtu --color displacement --cut x=0.4 --range 0,2 {PLAIN}"));
}

#[test]
fn same_picture_on_any_number_of_threads() {
    let dir = Workdir::new();
    write_vtu(&dir.path("cube.vtu"), &result()).unwrap();
    let picture = |threads| {
        run(&dir, "cube.vtu cube.vtu --color displacement --size 320x200", threads).succeeds();
        fs::read(dir.path("out.png")).unwrap()
    };
    let one = picture("1");
    assert!(one == picture("2") && one == picture("3"));
}

#[test]
fn files_go_side_by_side_or_together() {
    let dir = Workdir::new();
    io::write_surface(&dir.path("a.obj"), &cube()).unwrap();
    let mut far = cube();
    far.vertices.iter_mut().for_each(|v| v.x += 3.0);
    io::write_surface(&dir.path("b.obj"), &far).unwrap();
    let wide = "--orthographic --no-ground --smooth --size 600x300 --view front";
    let one = draw(&dir, &format!("a.obj b.obj --together {wide}"));
    // two unit cubes with two between them: half of the width is empty, the colours differ
    assert!(distance(one.center(), one.at(0, 150)) <= 2);
    assert!(distance(one.at(80, 150), one.at(520, 150)) > 30);
    let apart = draw(&dir, &format!("a.obj b.obj --together --spread 1 {wide}"));
    assert!(apart.drawn() < one.drawn() / 2, "farther apart, so drawn smaller");
    let panels = draw(&dir, &format!("a.obj b.obj --captions left,right {wide}"));
    assert_eq!((panels.width, panels.height), (600, 300));
}

/// A chamber within a skin is not seen from outside: it stands beside it, whatever the order of the files.
#[test]
fn walls_of_chambers_are_moved_out_of_what_hides_them() {
    let dir = Workdir::new();
    io::write_surface(&dir.path("skin.obj"), &cube()).unwrap();
    let mut wall = cube();
    wall.vertices.iter_mut().for_each(|v| *v = 0.3 * *v + Vec3::repeat(0.35));
    wall.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    io::write_surface(&dir.path("wall.obj"), &wall).unwrap();
    let plain = "--together --no-ground --smooth --size 400x300 --view front";
    // the second colour of the palette is orange, the first blue
    let orange = |args: &str| {
        let picture = draw(&dir, args);
        let all = (0..300).flat_map(|y| (0..400).map(move |x| (x, y)));
        all.filter(|&(x, y)| picture.at(x, y)[0] > picture.at(x, y)[2] + 40).count()
    };
    assert_eq!(orange(&format!("skin.obj wall.obj {plain}")), 0, "hidden");
    assert!(orange(&format!("skin.obj wall.obj --spread 1.2 {plain}")) > 1000);
    let skin_last = orange(&format!("wall.obj skin.obj --spread 1.2 {plain}"));
    let wall_last = orange(&format!("skin.obj wall.obj --spread 1.2 {plain}"));
    assert!(skin_last > 8 * wall_last, "the skin is orange then: {skin_last} {wall_last}");
}

#[test]
fn a_model_has_a_colour_a_label_and_a_legend_for_each_region() {
    let dir = Workdir::new();
    let body = cube();
    fs::create_dir_all(dir.path("model/patches")).unwrap();
    let ends = [body.triangles[..6].to_vec(), body.triangles[6..].to_vec()];
    for (name, triangles) in ["lid", "rest"].iter().zip(ends) {
        let patch = SurfaceMesh { triangles, ..body.clone() };
        io::write_surface(&dir.path(&format!("model/patches/{name}.stl")), &patch).unwrap();
    }
    fails(&dir, "model", &["model.json", "cad2fem model"]);
    let report = r#"{ "regions": [{ "name": "lid" }, { "name": "rest" }] }"#;
    fs::write(dir.path("model/model.json"), report).unwrap();
    let model = draw(&dir, "model --size 400x300");
    let files = "model/patches/lid.stl model/patches/rest.stl --together --label --size 400x300";
    assert!(model.bytes == draw(&dir, files).bytes);
    assert!(model.bytes != draw(&dir, &files.replace(" --label", "")).bytes);
    let apart = draw(&dir, "model --spread 1 --size 400x300");
    assert!(apart.bytes == draw(&dir, &format!("{files} --spread 1")).bytes);
    fs::remove_file(dir.path("out.png")).unwrap();
    fails(&dir, "model/patches/lid.stl --label", &["--label are for --together"]);
}

#[test]
fn errors_say_what_would_work() {
    let dir = Workdir::new();
    io::write_surface(&dir.path("cube.stl"), &cube()).unwrap();
    write_vtu(&dir.path("cube.vtu"), &result()).unwrap();
    let fields = "at points: displacement; in cells: pressure";
    fails(&dir, "cube.vtu --color velocity", &["velocity", fields, "cube.vtu"]);
    fails(&dir, "cube.vtu --color displacement.5", &["3 components"]);
    fails(&dir, "cube.vtu --deform velocity", &["velocity", fields]);
    fails(&dir, "cube.stl --color displacement", &["no file is a .vtu"]);
    fails(&dir, "cube.stl --captions a,b", &["2 captions for 1 files"]);
    fails(&dir, "cube.stl --view above", &["above", "iso, front"]);
    fails(&dir, "cube.stl --cut w=3", &["x=V"]);
    fails(&dir, "cube.stl --size 10x10", &["64 to"]);
    fails(&dir, "cube.vtu --color pressure --range 2,1", &["the first must be smaller"]);
    fails(&dir, "missing.stl", &["missing.stl"]);
    fs::write(dir.path("broken.vtu"), &fs::read(dir.path("cube.vtu")).unwrap()[..300]).unwrap();
    fails(&dir, "broken.vtu", &["broken.vtu"]);
}
