//! Grids to files and back.

use std::path::PathBuf;

use super::*;

/// Places of the nodes in a cell with corners at the origin and on the axes, as
/// VTK defines them (vtkQuadraticTetra, vtkQuadraticTriangle).
const VTK_PLACES: [[f64; 3]; 10] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.5, 0.0, 0.0],
    [0.5, 0.5, 0.0],
    [0.0, 0.5, 0.0],
    [0.0, 0.0, 0.5],
    [0.5, 0.0, 0.5],
    [0.0, 0.5, 0.5],
];

#[test]
fn nodes_of_quadratic_cells_are_where_vtk_wants_them() {
    let places = VTK_PLACES.map(Vec3::from);
    let middle = |[i, j]: [usize; 2]| (places[i] + places[j]) / 2.0;
    let tet: Vec<Vec3> = CellType::Tet10.edges().iter().map(|&edge| middle(edge)).collect();
    assert_eq!(tet, places[4..]);
    // The triangle is the facet z = 0, its nodes without those of the apex.
    let triangle: Vec<Vec3> = CellType::Tri6.edges().iter().map(|&edge| middle(edge)).collect();
    assert_eq!(triangle, places[4..7]);
}

fn field(name: &str, unit: &str, components: usize, count: usize) -> Field {
    let values = (0..count * components).map(|i| 0.1 * i as f64 - 1.0 / 3.0).collect();
    Field { name: name.into(), unit: unit.into(), components, values }
}

fn grid(cell_type: CellType) -> Grid {
    Grid {
        points: VTK_PLACES.map(Vec3::from).repeat(2),
        // The same cell twice, from different points.
        cells: (0..cell_type.nodes()).chain((0..cell_type.nodes()).rev()).collect(),
        cell_type,
        point_fields: vec![field("displacement", "m", 3, 20), field("a < b & \"c\"", "", 1, 20)],
        cell_fields: vec![field("stress", "Pa", 9, 2), field("detF [odd", "1", 1, 2)],
    }
}

fn written(grid: &Grid) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("a.vtu");
    write_vtu(&path, grid).expect("writable");
    (folder, path)
}

#[test]
fn what_is_written_comes_back_bit_for_bit() {
    for cell_type in CellType::ALL {
        let grid = grid(cell_type);
        let (_folder, path) = written(&grid);
        assert_eq!(read_vtu(&path).expect("what was written"), grid);
    }
}

#[test]
fn a_truncated_file_is_an_error_wherever_its_data_end() {
    let (_folder, path) = written(&grid(CellType::Tet10));
    let bytes = std::fs::read(&path).expect("readable");
    let end = bytes.len() - "\n</AppendedData>\n</VTKFile>\n".len();
    for length in 0..end {
        assert!(read::parse(&bytes[..length]).is_err(), "{length} of {}", bytes.len());
    }
}

#[test]
fn counts_and_numbers_that_cannot_be_are_refused() {
    let (_folder, path) = written(&grid(CellType::Tet4));
    let bytes = std::fs::read(&path).expect("readable");
    let replaced = |from: &[u8], to: &[u8]| {
        let at = bytes.windows(from.len()).position(|w| w == from).expect("it is there");
        [&bytes[..at], to, &bytes[at + from.len()..]].concat()
    };
    // 2^61 + 1 times 8 components is 8 in 64 bits
    let many = replaced(b"NumberOfPoints=\"", b"NumberOfPoints=\"2305843009213693953\" x=\"");
    let flat = replaced(b"Name=\"Points\" NumberOfComponents=\"3\"", b"Name=\"Points\"");
    let first = grid(CellType::Tet4).points[1].x;
    let nan = replaced(&first.to_le_bytes(), &f64::NAN.to_le_bytes());
    for damaged in [many, flat, nan] {
        assert!(read::parse(&damaged).is_err());
    }
}

#[test]
fn what_does_not_fit_is_not_written() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("a.vtu");
    type Damage = fn(&mut Grid);
    let broken: [(&str, Damage); 4] = [
        ("field \"stress\" has 17 values, not 2 × 9", |g| g.cell_fields[0].values.truncate(17)),
        ("field \"displacement\" is NaN at index 5", |g| g.point_fields[0].values[5] = f64::NAN),
        ("cell 1 refers to point 20 of 20", |g| g.cells[4] = 20),
        ("do not divide into 4", |g| g.cells.truncate(7)),
    ];
    for (needed, damage) in broken {
        let mut grid = grid(CellType::Tet4);
        damage(&mut grid);
        let message = write_vtu(&path, &grid).expect_err(needed).to_string();
        assert!(message.contains(needed), "{needed:?} is not in: {message}");
    }
    assert!(!path.exists());
}

#[test]
fn a_time_series_names_its_files() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("a.pvd");
    write_pvd(&path, &[(0.0, "step0.vtu".into()), (0.1, "R&D/step1.vtu".into())]).expect("fine");
    let text = std::fs::read_to_string(&path).expect("readable");
    assert!(text.contains("timestep=\"0.1\" part=\"0\" file=\"R&amp;D/step1.vtu\""), "{text}");
}

#[test]
fn cubic_cells_become_quadratic_ones_through_the_same_middles() {
    let cubic = |p: &Vec3| p.x.powi(3) - 2.0 * p.y * p.z * p.x + p.z * p.z - 0.5 * p.y;
    let corners = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
    let mut points = corners.to_vec();
    for &[a, b] in CellType::Tet20.edges() {
        let third = |k: f64| corners[a] + (corners[b] - corners[a]) * (k / 3.0);
        points.extend([third(1.0), third(2.0)]);
    }
    for face in [[0, 1, 3], [1, 2, 3], [0, 2, 3], [0, 1, 2]] {
        points.push(face.map(|c| corners[c]).iter().sum::<Vec3>() / 3.0);
    }
    let values = points.iter().flat_map(|p| [p.x, cubic(p)]).collect();
    let grid = Grid {
        points,
        cells: (0..20).collect(),
        cell_type: CellType::Tet20,
        point_fields: vec![Field { name: "f".into(), unit: String::new(), components: 2, values }],
        cell_fields: vec![],
    };
    let lowered = grid.at_most_quadratic();
    assert_eq!((lowered.cell_type, lowered.cells.len()), (CellType::Tet10, 10));
    for (&node, place) in lowered.cells.iter().zip(VTK_PLACES.map(Vec3::from)) {
        assert!((lowered.points[node] - place).norm() < 1e-15);
        let values = &lowered.point_fields[0].values[2 * node..2 * node + 2];
        assert!((values[0] - place.x).abs() < 1e-15 && (values[1] - cubic(&place)).abs() < 1e-15);
    }
}

/// A file as ParaView writes it: single precision, sizes of 4 bytes, a note in an array, and data of the whole file.
fn foreign() -> Vec<u8> {
    let (mut data, mut offsets) = (Vec::new(), Vec::new());
    let mut append = |bytes: Vec<u8>| {
        offsets.push(data.len());
        data.extend((bytes.len() as u32).to_le_bytes());
        data.extend(bytes);
    };
    append(VTK_PLACES[..4].iter().flatten().flat_map(|&x| (x as f32).to_le_bytes()).collect());
    append([0_i32, 1, 2, 3].iter().flat_map(|i| i.to_le_bytes()).collect());
    append(4_i32.to_le_bytes().to_vec());
    append(vec![10]);
    append(0.25_f32.to_le_bytes().to_vec());
    let array = |kind: &str, name: &str, i: usize| {
        let head = format!("<DataArray type=\"{kind}\"\n Name=\"{name}\" format=\"appended\"");
        let parts = if i == 0 { 3 } else { 1 };
        format!(
            "{head} NumberOfComponents=\"{parts}\" offset=\"{}\">\n<InformationKey name=\"L2_NORM_RANGE\">\n\
             <Value index=\"0\">\n7\n</Value>\n</InformationKey>\n</DataArray>\n",
            offsets[i]
        )
    };
    let xml = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt32\">\n<UnstructuredGrid>\n<FieldData>\n<DataArray type=\"Float64\" Name=\"TimeValue\" \
         NumberOfTuples=\"1\" format=\"ascii\">\n0.5\n</DataArray>\n</FieldData>\n<Piece NumberOfPoints=\"4\" \
         NumberOfCells=\"1\">\n<Points>\n{}</Points>\n<Cells>\n{}{}{}</Cells>\n<CellData>\n{}</CellData>\n</Piece>\n\
         </UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n _",
        array("Float32", "coords", 0),
        array("Int32", "connectivity", 1),
        array("Int32", "offsets", 2),
        array("UInt8", "types", 3),
        array("Float32", "quality", 4),
    );
    [xml.as_bytes(), &data, b"\n</AppendedData>\n</VTKFile>\n"].concat()
}

#[test]
fn a_file_of_paraview_is_read() {
    let expected = Grid {
        points: VTK_PLACES[..4].iter().map(|&p| Vec3::from(p)).collect(),
        cells: vec![0, 1, 2, 3],
        cell_type: CellType::Tet4,
        point_fields: vec![],
        cell_fields: vec![Field {
            unit: String::new(),
            values: vec![0.25],
            ..field("quality", "", 1, 1)
        }],
    };
    assert_eq!(read::parse(&foreign()), Ok(expected));
}

#[test]
fn what_files_of_others_have_and_should_not_is_said() {
    let bytes = foreign();
    for (from, to, words) in [
        ("header_type=\"UInt32\"", "compressor=\"vtkLZ4DataCompressor\"", "without encoding"),
        ("encoding=\"raw\"", "encoding=\"base64\"", "without encoding"),
        ("coords\" format=\"appended\"", "coords\" format=\"binary\"", "the data mode Appended"),
        ("UnstructuredGrid\" v", "PolyData\" v", "UnstructuredGrid is needed"),
        ("</Piece>", "</Piece><Piece>", "several pieces"),
        ("type=\"Float32\"\n", "type=\"Bit\"\n", "no type of numbers"),
    ] {
        let at = bytes.windows(from.len()).position(|w| w == from.as_bytes()).expect(from);
        let changed = [&bytes[..at], to.as_bytes(), &bytes[at + from.len()..]].concat();
        let message = read::parse(&changed).expect_err(to);
        assert!(message.contains(words), "{words:?} is not in: {message}");
    }
}
