//! Gmsh files: ours and hand-made ones.

use std::io::Write;

use super::*;
use crate::measure::volume;
use crate::{Vec3, Volumes};

/// Two tetrahedra on a common facet, with coordinates that need all 53 bits.
fn mesh() -> TetMesh {
    TetMesh {
        vertices: vec![
            Vec3::new(0.1, 1e-300, -1.0 / 3.0),
            Vec3::new(1.0, 0.0, -0.0),
            Vec3::new(0.0, 2.0_f64.sqrt(), 1e-17),
            Vec3::new(0.0, 0.0, 1.0),
            Vec3::new(1.0, 1.0, 1.0 + f64::EPSILON),
        ],
        tets: vec![[0, 1, 2, 3], [1, 4, 2, 3]],
    }
}

fn tags() -> Tags {
    let mut tags = Tags::new(vec!["seat".into(), "never used".into(), "Ω wall".into()]);
    tags.set([0, 1, 2], 1);
    tags.set([1, 4, 2], 3);
    tags
}

fn read(bytes: &[u8]) -> Parsed<MshFile> {
    Ok(parse(bytes).and_then(assemble::assemble)?.0)
}

fn written() -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("a.msh");
    write_tets(&path, &mesh(), &tags()).expect("writable");
    std::fs::read(&path).expect("readable")
}

#[test]
fn what_is_written_comes_back_bit_for_bit() {
    let file = read(&written()).expect("what was written");
    assert_eq!(file.mesh, mesh());
    assert!(file.mesh.vertices[1].z.is_sign_negative());
    assert_eq!(file.tags, tags());
}

#[test]
fn volumes_come_back_by_their_names() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("a.msh");
    let mut tags = tags();
    tags.volumes = Volumes { names: vec!["floor".into(), "walls".into()], of: vec![1, 0] };
    write_tets(&path, &mesh(), &tags).expect("writable");
    assert_eq!(read_tets(&path).expect("what was written").tags, tags);
    tags.volumes.of.pop();
    let message = write_tets(&path, &mesh(), &tags).expect_err("one is missing").to_string();
    assert!(message.contains("volumes of 1 tetrahedra by 2 names, there are 2"), "{message}");
}

#[test]
fn compressed_files_are_read_and_damaged_ones_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("a.msh.gz");
    let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    gzip.write_all(&written()).expect("into memory");
    let bytes = gzip.finish().expect("into memory");
    std::fs::write(&path, &bytes).expect("writable");
    assert_eq!(read_tets(&path).expect("what was written").mesh, mesh());
    std::fs::write(&path, &bytes[..bytes.len() / 2]).expect("writable");
    let message = read_tets(&path).expect_err("half a file").to_string();
    assert!(message.contains("compressed by gzip, and damaged"), "{message}");
}

#[test]
fn a_truncated_file_is_an_error_wherever_it_ends() {
    let binary = binary_41();
    // Nothing is lost with the final line end.
    for bytes in [written(), binary] {
        for length in 0..bytes.len() - 1 {
            assert!(read(&bytes[..length]).is_err(), "{length} of {}", bytes.len());
        }
    }
}

/// Format 4.1, binary: an inverted second-order tetrahedron whose
/// surface 5 is in physical group 7, and a node that only a line uses.
fn binary_41() -> Vec<u8> {
    let mut bytes = b"$MeshFormat\n4.1 1 8\n".to_vec();
    let int = |bytes: &mut Vec<u8>, values: &[i32]| {
        bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    };
    let size = |bytes: &mut Vec<u8>, values: &[u64]| {
        bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    };
    let double = |bytes: &mut Vec<u8>, values: &[f64]| {
        bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    };
    int(&mut bytes, &[1]);
    bytes.extend(b"\n$EndMeshFormat\n$PhysicalNames\n2\n2 7 \"inner wall\"\n3 4 \"body\"\n");
    bytes.extend(b"$EndPhysicalNames\n$Entities\n");
    size(&mut bytes, &[1, 0, 1, 1]);
    int(&mut bytes, &[1]); // point 1
    double(&mut bytes, &[0.0; 3]);
    size(&mut bytes, &[0]);
    int(&mut bytes, &[5]); // surface 5, bounded by two curves
    double(&mut bytes, &[0.0; 6]);
    size(&mut bytes, &[1]);
    int(&mut bytes, &[7]);
    size(&mut bytes, &[2]);
    int(&mut bytes, &[1, -2]);
    int(&mut bytes, &[9]); // volume 9
    double(&mut bytes, &[0.0; 6]);
    size(&mut bytes, &[1]);
    int(&mut bytes, &[4]);
    size(&mut bytes, &[0]);
    bytes.extend(b"\n$EndEntities\n$Nodes\n");
    size(&mut bytes, &[2, 11, 10, 20]);
    int(&mut bytes, &[2, 5, 1]); // two parameters per node of a surface
    size(&mut bytes, &[3, 20, 12, 11]);
    for position in [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]] {
        double(&mut bytes, &position);
        double(&mut bytes, &[0.25, 0.75]);
    }
    int(&mut bytes, &[3, 9, 0]);
    size(&mut bytes, &[8, 10, 13, 14, 15, 16, 17, 18, 19]);
    double(&mut bytes, &[0.0; 24]);
    bytes.extend(b"\n$EndNodes\n$Elements\n");
    size(&mut bytes, &[3, 3, 1, 3]);
    int(&mut bytes, &[1, 1, 1]);
    size(&mut bytes, &[1, 1, 19, 10]);
    int(&mut bytes, &[2, 5, 2]);
    size(&mut bytes, &[1, 2, 12, 11, 20]);
    int(&mut bytes, &[3, 9, 11]);
    size(&mut bytes, &[1, 3, 10, 12, 11, 20, 13, 14, 15, 16, 17, 18]);
    bytes.extend(b"\n$EndElements\n");
    bytes
}

#[test]
fn second_order_binary_41_yields_its_corners_groups_and_a_positive_volume() {
    let file = read(&binary_41()).expect("a valid file");
    // In the order of the file: nodes 20, 12, 11, 10.
    assert_eq!(file.mesh.vertices, [Vec3::z(), Vec3::y(), Vec3::x(), Vec3::zeros()]);
    assert_eq!(volume(&file.mesh), 1.0 / 6.0);
    assert_eq!(file.tags.names, ["inner wall"]);
    assert_eq!(file.tags.get([0, 1, 2]), Some(1));
    assert_eq!(file.tags.volumes, Volumes::default());
}

#[test]
fn groups_without_a_name_are_called_by_their_number() {
    let text = String::from_utf8(written()).expect("ASCII");
    let start = text.find("$PhysicalNames").expect("written");
    let end = text.find("$Nodes").expect("written");
    let nameless = format!("{}{}", &text[..start], &text[end..]);
    let file = read(nameless.as_bytes()).expect("names are optional");
    assert_eq!(file.tags.names, ["1", "3"]);
    assert_eq!(file.tags.get([1, 2, 4]), Some(2));
}

#[test]
fn bad_content_is_named() {
    let text = String::from_utf8(written()).expect("ASCII");
    let cases = [
        ("2.2 0 8", "4.0 0 8", "gmsh IN.msh -save -format msh41"),
        ("2.2 0 8", "2.2 0 4", "8 are needed"),
        ("$Nodes\n5", "$Nodes\n4", "in section $Nodes: found \"5\" where $EndNodes is due"),
        ("$Nodes\n5", "$Nodes\n6", "\"$EndNodes\" where a number is due"),
        ("$Elements\n4", "$Elements\n99999999999", "where a number is due"),
        ("2 1.0 0.0", "2 nan 0.0", "1 of 5 vertices are not finite, the first is vertex 1"),
        ("2 1.0 0.0", "1 1.0 0.0", "node number 1 occurs twice"),
        ("4 4 2 1 1 2 5 3 4", "4 4 2 1 1 2 9 3 4", "tetrahedron 1 has node 9"),
        ("4 4 2 1 1 2 5 3 4", "4 5 2 1 1 2 5 3 4", "type 5 (hexahedron)"),
        ("1 2 2 1 1 1 2 3", "1 2 2 1 1 1 2 5", "1 of 2 tagged triangles are no facet"),
        ("2 2 2 3 3 2 3 5", "2 2 2 3 3 1 2 3", "the groups \"seat\" and \"Ω wall\""),
        ("\"never used\"", "\"seat\"", "two physical groups of triangles are called \"seat\""),
        ("$MeshFormat", "ply", "not a Gmsh file"),
    ];
    for (good, bad, needed) in cases {
        assert!(text.contains(good), "{good:?} is not in:\n{text}");
        let message = read(text.replacen(good, bad, 1).as_bytes()).expect_err(needed);
        assert!(message.contains(needed), "{needed:?} is not in: {message}");
    }
    let message = read(b"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n").expect_err("empty");
    assert!(message.contains("no tetrahedra among 0 nodes"), "{message}");
}

#[test]
fn nothing_unreadable_is_written() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("a.msh");
    let quote = Tags::new(vec!["a \"quoted\" name".into()]);
    let mut stranger = tags();
    stranger.set([0, 1, 77], 1);
    let mut lost = mesh();
    lost.tets[1][2] = 5;
    for (mesh, tags) in [(mesh(), quote), (mesh(), stranger), (lost, tags()), Default::default()] {
        let message = write_tets(&path, &mesh, &tags).expect_err("unreadable").to_string();
        assert!(message.contains("a.msh: not written"), "{message}");
    }
    assert!(!path.exists());
}
