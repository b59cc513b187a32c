//! What all surface formats promise.

use super::*;
use crate::Vec3;

/// A tetrahedron whose coordinates need all 53 bits.
fn surface() -> SurfaceMesh {
    SurfaceMesh {
        vertices: vec![
            Vec3::new(0.1, 1.0 / 3.0, -1e-17),
            Vec3::new(1.0, f64::MIN_POSITIVE, 0.7),
            Vec3::new(-2.0 / 7.0, 1e3, 0.2),
            Vec3::new(std::f64::consts::PI, 0.3, 5e5),
        ],
        triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    }
}

fn bytes_of(format: &Format, surface: &SurfaceMesh) -> Vec<u8> {
    let mut bytes = Vec::new();
    (format.write)(surface, &mut bytes).expect("memory can be written");
    bytes
}

fn parse(format: &Format, bytes: &[u8]) -> Parsed<SurfaceMesh> {
    let surface = (format.parse)(bytes)?;
    require_sound(&surface)?;
    Ok(surface)
}

fn format(extension: &str) -> &'static Format {
    FORMATS.iter().find(|f| f.extension == extension).expect("a known extension")
}

#[test]
fn obj_and_ply_keep_every_bit() {
    for extension in ["obj", "ply"] {
        let bytes = bytes_of(format(extension), &surface());
        assert_eq!(parse(format(extension), &bytes).as_ref(), Ok(&surface()), "{extension}");
    }
}

#[test]
fn stl_keeps_32_bit_coordinates_and_welds_them() {
    let bytes = bytes_of(format("stl"), &surface());
    let read = parse(format("stl"), &bytes).expect("what was written");
    assert_eq!(bytes.len(), 84 + 4 * 50);
    assert_eq!((read.vertices.len(), read.triangles.len()), (4, 4));
    // STL has no indices: vertices come in the order in which triangles use them.
    let rounded = |v: &Vec3| v.map(|x| f64::from(x as f32));
    for t in 0..4 {
        let corners = surface().corners(t).map(|v| rounded(&v));
        let turned = [0, 1, 2].map(|first| [0, 1, 2].map(|k| corners[(first + k) % 3]));
        assert!(turned.contains(&read.corners(t)), "{:?}", read.corners(t));
        // the longest edge is opposite the first corner
        let [a, b, c] = read.corners(t);
        assert!((b - c).norm() >= (a - b).norm().max((a - c).norm()));
    }
    // Once rounded, nothing changes any more.
    assert_eq!(bytes_of(format("stl"), &read), bytes);
}

#[test]
fn ascii_stl_is_read_with_all_its_digits() {
    let text = "solid a body\n facet normal nan 0 1\n  outer loop\n   vertex 0 0 0\n
        vertex 0.1 0 0\n vertex 0 1e-1 0\n endloop\n endfacet\n
        facet normal 0 0 1\n outer loop\n vertex -0 0.1 0\n vertex 0.1 0 0\n vertex 1 1 0\n
        endloop\n endfacet\nendsolid a body\n";
    let read = parse(format("stl"), text.as_bytes()).expect("valid ASCII STL");
    // 0.1 and 1e-1 are the same number, and so are -0 and 0.
    assert_eq!(read.triangles, [[0, 1, 2], [2, 1, 3]]);
    assert_eq!(read.vertices[1].x, 0.1);
    let (cut, _) = text.split_once("endsolid").expect("the last line");
    let message = parse(format("stl"), cut.as_bytes()).expect_err("endsolid is missing");
    assert!(message.contains("endsolid"), "{message}");
}

#[test]
fn a_binary_stl_may_begin_with_solid() {
    let mut bytes = bytes_of(format("stl"), &surface());
    bytes[..5].copy_from_slice(b"solid");
    assert_eq!(parse(format("stl"), &bytes).expect("the size fits").triangles.len(), 4);
    bytes.pop();
    let message = parse(format("stl"), &bytes).expect_err("a byte is missing");
    assert!(message.contains("4 triangles") && message.contains("284"), "{message}");
}

#[test]
fn stl_leaves_out_triangles_that_repeat_a_corner_only() {
    let mut collapsed = surface();
    collapsed.vertices.push(Vec3::new(0.55, 0.3, 0.35));
    collapsed.triangles.push([0, 0, 1]);
    // Flat, but with three corners: a job for the checks, not for the reader.
    collapsed.vertices.extend([0.0, 0.5, 1.0].map(|x| Vec3::new(x, 0.0, 0.0)));
    collapsed.triangles.push([5, 6, 7]);
    let read = parse(format("stl"), &bytes_of(format("stl"), &collapsed)).expect("readable");
    assert_eq!(read.triangles.len(), 5);
}

#[test]
fn a_truncated_file_is_an_error_wherever_it_ends() {
    // OBJ has no counts: a cut is seen only if a face refers to what is missing.
    for extension in ["stl", "ply"] {
        let bytes = bytes_of(format(extension), &surface());
        for length in 0..bytes.len() {
            assert!(parse(format(extension), &bytes[..length]).is_err(), "{extension} {length}");
        }
    }
}

#[test]
fn bad_content_is_named() {
    let cases: &[(&str, &str, &str)] = &[
        ("obj", "v 0 0 0\nv 1 0 0\nf 1 2 3\n", "vertex 2, but there are 2"),
        ("obj", "v 0 0\n", "line 1: a vertex needs three"),
        ("obj", "v 0 0 zero\n", "\"zero\" is not a number"),
        ("obj", "v 0 0 0\nf 0 1 1\n", "line 2: there is no vertex 0"),
        ("obj", "v 0 0 0\nf -1 -2 -1\n", "line 2: there is no vertex -2"),
        ("obj", "v 0 0 0\nf 1 1\n", "at least 3 corners"),
        ("obj", "v 0 nan 0\nv 0 0 0\nf 1 2 2\n", "1 of 2 vertices are not finite"),
        ("obj", "v 0 0 1e999\nf 1 1 1\n", "not finite"),
        ("obj", "v 0 0 0\nv 1e155 0 0\nf 1 2 2\n", "1 of 2 vertices are beyond 1e9"),
        ("obj", "v 0 0 0\n", "empty: 1 vertices, no triangles"),
        ("stl", "", "0 bytes"),
        ("stl", "solid\nfacet normal 0 0 0 outer loop vertex 0 0 x", "\"x\""),
        ("stl", "solid\nendsolid\n", "empty"),
        ("ply", "ply\n", "header"),
        (
            "ply",
            "ply\nformat binary_little_endian 1.0\nelement vertex 999999999999\nend_header\n",
            "\"vertex\": 999999999999 announced, the file has 75 bytes",
        ),
        (
            "ply",
            "ply\nformat ascii 1.0\nelement face 99999999\nproperty list uchar int v\n\
             end_header\n1 0\n",
            "99999999 announced, the file has 84 bytes",
        ),
        (
            "ply",
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n",
            "empty",
        ),
    ];
    for (extension, content, needed) in cases {
        let message = parse(format(extension), content.as_bytes()).expect_err(needed);
        assert!(message.contains(needed), "{needed:?} is not in: {message}");
    }
}

#[test]
fn polygons_and_relative_indices_are_understood() {
    let text =
        b"# a square\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\ng s\nf -4/1 2//1 3/1/1 4\n";
    let square = parse(format("obj"), text).expect("a square");
    assert_eq!(square.triangles, [[0, 1, 2], [0, 2, 3]]);
    let marked = [b"\xef\xbb\xbf", &text[11..]].concat();
    assert_eq!(parse(format("obj"), &marked), Ok(square.clone()));
    let text = b"ply\nformat ascii 1.0\ncomment c\nelement vertex 4\nproperty float x\n\
        property float y\nproperty double z\nproperty uchar red\nelement face 1\n\
        property list uchar uint vertex_index\nend_header\n\
        0 0 0 9\n1 0 0 9\n1 1 0 9\n0 1 0 9\n4 0 1 2 3\n";
    assert_eq!(parse(format("ply"), text), Ok(square));
}

/// What was there stays until the new file is complete, and nothing else is left in the folder.
#[test]
fn files_are_written_whole_or_not_at_all_and_inputs_are_never_replaced() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = |name: &str| folder.path().join(name);
    let put = |name: &str, text: &str| write_atomic(&at(name), |out| write!(out, "{text}"));
    put("deep/result", "old").expect("a fresh file");
    let full = write_atomic(&at("deep/result"), |out| {
        write!(out, "half of the new")?;
        out.flush()?;
        Err(io::ErrorKind::StorageFull.into())
    });
    let message = full.expect_err("the closure failed").to_string();
    assert!(message.contains("result: cannot write"), "{message}");
    assert_eq!(read_own_text(&at("deep/result")).expect("the old file"), "old");
    assert_eq!(std::fs::read_dir(at("deep")).expect("a folder").count(), 1);
    // what this process has written may be read and written again, an input may not
    put("deep/result", "new").expect("its own");
    std::fs::write(at("input"), "precious").expect("writable");
    assert_eq!(read_text(&at("input")).expect("a text"), "precious");
    for refused in [put("input", "x"), put("./input", "x"), remove_output(&at("input"))] {
        let message = refused.expect_err("an input").to_string();
        assert!(message.contains("give the output another name"), "{message}");
    }
    let message = remove_output_folder(folder.path()).expect_err("it has an input").to_string();
    assert!(message.contains("/input as its input"), "{message}");
    remove_output(&at("deep/result")).expect("its own");
    remove_output(&at("deep/result")).expect("it is gone already");
    // litter of a killed program, but not what is just being written
    let mine = at(".incomplete-mine");
    std::fs::write(at(".incomplete-old"), "half").expect("writable");
    let (_, writing) =
        Unfinished::new(|| create_new(&mine), |_| mine.clone()).expect("it is not there");
    remove_litter(folder.path());
    assert!(!at(".incomplete-old").exists() && at("input").exists() && mine.exists());
    drop(writing);
    remove_litter(folder.path());
    assert!(!mine.exists());
}

#[test]
fn what_is_no_file_is_named() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("binary"), b"ab\xffc").expect("writable");
    std::fs::create_dir(at("folder")).expect("a folder");
    let large = std::fs::File::create(at("large")).expect("writable");
    large.set_len((4 << 30) + 7).expect("a hole, without blocks on the disk");
    for (name, words) in [
        ("binary", "byte 2 is not UTF-8"),
        ("folder", "it is a folder; a file is needed"),
        ("nothing", "nothing: cannot read"),
        ("large", "4294967303 bytes; up to 4294967296"),
        #[cfg(target_os = "linux")]
        ("/dev/zero", "it is a pipe or a device; a file is needed"),
    ] {
        let message = read_text(&at(name)).expect_err(name).to_string();
        assert!(message.contains(words), "{words:?} is not in: {message}");
    }
    assert!(write_atomic(&at("folder"), |out| write!(out, "x")).is_err());
    assert!(open_to_append(&at("folder")).is_err() && create_new(&at("binary")).is_err());
    #[cfg(target_os = "linux")]
    {
        // a device is written to and not replaced
        let full = write_atomic(Path::new("/dev/full"), |out| write!(out, "x"));
        assert!(full.expect_err("always full").to_string().contains("No space left"));
        assert!(!std::fs::metadata("/dev/full").expect("there").is_file());
        // and a pipe that the shell has opened is read, as `<(...)` is
        let (pipe, mut writer) = io::pipe().expect("a pipe");
        writer.write_all(b"text").expect("it is open");
        drop(writer);
        let path = format!("/dev/fd/{}", std::os::fd::AsRawFd::as_raw_fd(&pipe));
        assert_eq!(read_text(Path::new(&path)).expect("a pipe"), "text");
    }
}

#[test]
fn unknown_formats_list_the_known_ones_and_nothing_bad_is_written() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let message = read_surface(Path::new("body.step")).expect_err("unknown").to_string();
    assert!(message.contains("body.step") && message.contains("stl, obj, ply"), "{message}");
    let path = folder.path().join("a.stl");
    let mut bad = surface();
    bad.vertices[2].y = f64::NAN;
    let message = write_surface(&path, &bad).expect_err("not finite").to_string();
    assert!(message.contains("vertex 2 at (-0.2857142857142857, NaN, 0.2)"), "{message}");
    assert!(!path.exists());
}
