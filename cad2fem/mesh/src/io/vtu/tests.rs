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

/// How another program may write its numbers.
#[derive(Clone, Copy, Debug)]
struct Form {
    format: &'static str,
    /// How appended data is written: `raw` or `base64`.
    encoding: &'static str,
    word: usize,
    compressed: bool,
    big_endian: bool,
    single: bool,
}

impl Form {
    /// All that are read.
    fn all() -> Vec<Self> {
        let mut all = Vec::new();
        for (format, encoding) in
            [("ascii", ""), ("binary", ""), ("appended", "raw"), ("appended", "base64")]
        {
            for i in 0..16_usize {
                let [compressed, big_endian, single] = [1, 2, 4].map(|bit| i & bit > 0);
                let word = if i & 8 > 0 { 8 } else { 4 };
                all.push(Self { format, encoding, word, compressed, big_endian, single });
            }
        }
        all
    }

    fn bytes(self, number: u64, size: usize) -> Vec<u8> {
        let mut bytes = number.to_le_bytes()[..size].to_vec();
        if self.big_endian {
            bytes.reverse();
        }
        bytes
    }

    /// Data behind their sizes, in blocks of 32 bytes.
    fn encoded(self, data: &[u8]) -> Vec<u8> {
        let word = |n: usize| self.bytes(n as u64, self.word);
        let base = |bytes: &[u8]| match (self.format, self.encoding) {
            ("appended", "raw") => bytes.to_vec(),
            _ => base64(bytes),
        };
        if !self.compressed {
            return base(&[word(data.len()), data.to_vec()].concat());
        }
        let blocks: Vec<Vec<u8>> = data.chunks(32).map(zlib).collect();
        let mut head = [word(blocks.len()), word(32), word(data.len() % 32)].concat();
        blocks.iter().for_each(|block| head.extend(word(block.len())));
        // each by itself, as VTK does
        [base(&head), base(&blocks.concat())].concat()
    }
}

fn zlib(data: &[u8]) -> Vec<u8> {
    let mut out = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
    std::io::Write::write_all(&mut out, data).expect("memory");
    out.finish().expect("memory")
}

fn base64(bytes: &[u8]) -> Vec<u8> {
    const LETTERS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = Vec::new();
    for part in bytes.chunks(3) {
        let at = |i: usize| u32::from(part.get(i).copied().unwrap_or(0));
        let bits = at(0) << 16 | at(1) << 8 | at(2);
        for i in 0..4 {
            let letter = LETTERS[(bits >> (18 - 6 * i) & 63) as usize];
            out.push(if i > part.len() { b'=' } else { letter });
        }
    }
    out
}

/// A file as another program writes it, with a note in an array, data of the whole file, and integers of 4 bytes.
fn foreign(grid: &Grid, form: Form) -> Vec<u8> {
    let (mut xml, mut appended) = (String::new(), Vec::new());
    let header = if form.word == 8 { "UInt64" } else { "UInt32" };
    let order = if form.big_endian { "BigEndian" } else { "LittleEndian" };
    let compressor = if form.compressed { " compressor=\"vtkZLibDataCompressor\"" } else { "" };
    xml += &format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"{order}\" \
         header_type=\"{header}\"{compressor}>\n<UnstructuredGrid>\n<FieldData>\n<DataArray type=\"Float64\" \
         Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">\n0.5\n</DataArray>\n</FieldData>\n\
         <Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n",
        grid.points.len(),
        grid.cell_count()
    );
    let mut array = |kind: &str, name: &str, components: usize, values: &[f64]| {
        let (size, real) = match kind {
            "UInt8" => (1, false),
            "Int32" => (4, false),
            "Float32" => (4, true),
            _ => (8, true),
        };
        let bits = |x: f64| match (real, size) {
            (true, 4) => u64::from((x as f32).to_bits()),
            (true, _) => x.to_bits(),
            _ => x as u64,
        };
        let head = format!(
            "<DataArray type=\"{kind}\"\n Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"{}\"",
            form.format
        );
        let note = "<InformationKey name=\"L2_NORM_RANGE\" length=\"1\">\n<Value index=\"0\">\n7\n</Value>\n</InformationKey>\n";
        let data: Vec<u8> = values.iter().flat_map(|&x| form.bytes(bits(x), size)).collect();
        match form.format {
            "appended" => {
                let offset = appended.len();
                appended.extend(form.encoded(&data));
                format!("{head} offset=\"{offset}\">\n{note}</DataArray>\n")
            }
            "binary" => {
                let text = String::from_utf8(form.encoded(&data)).expect("letters");
                format!("{head}>\n  {text}\n{note}</DataArray>\n")
            }
            _ => {
                let words: Vec<String> = values.iter().map(f64::to_string).collect();
                format!("{head}>\n{note}{}\n</DataArray>\n", words.join("\n "))
            }
        }
    };
    let real = if form.single { "Float32" } else { "Float64" };
    let nodes = grid.cell_type.nodes();
    let mut group = |name: &str, arrays: Vec<String>| {
        xml += &format!("<{name}>\n{}</{name}>\n", arrays.concat());
    };
    let flat: Vec<f64> = grid.points.iter().flatten().copied().collect();
    let cells: Vec<f64> = grid.cells.iter().map(|&i| i as f64).collect();
    let ends: Vec<f64> = (1..=grid.cell_count()).map(|i| (i * nodes) as f64).collect();
    let types = vec![f64::from(grid.cell_type as u8); grid.cell_count()];
    group("Points", vec![array(real, "coords", 3, &flat)]);
    group(
        "Cells",
        vec![
            array("Int32", "connectivity", 1, &cells),
            array("Int32", "offsets", 1, &ends),
            array("UInt8", "types", 1, &types),
        ],
    );
    for (name, fields) in [("PointData", &grid.point_fields), ("CellData", &grid.cell_fields)] {
        group(name, fields.iter().map(|f| array(real, &f.name, f.components, &f.values)).collect());
    }
    xml += "</Piece>\n</UnstructuredGrid>\n";
    let mut bytes = xml.into_bytes();
    if form.format == "appended" {
        bytes.extend(format!("<AppendedData encoding=\"{}\">\n  _", form.encoding).bytes());
        bytes.extend(appended);
        bytes.extend(b"\n</AppendedData>\n");
    }
    bytes.extend(b"</VTKFile>\n");
    bytes
}

/// The grid as a file of others has it, without units, perhaps in single precision.
fn plain(cell_type: CellType, single: bool) -> Grid {
    let mut grid = grid(cell_type);
    for field in grid.point_fields.iter_mut().chain(&mut grid.cell_fields) {
        field.unit.clear();
        field.name.retain(|c| c.is_ascii_alphanumeric());
        if single {
            field.values.iter_mut().for_each(|x| *x = f64::from(*x as f32));
        }
    }
    grid
}

#[test]
fn files_of_others_are_read_in_every_form() {
    for form in Form::all() {
        for cell_type in [CellType::Tet4, CellType::Tet10] {
            let expected = plain(cell_type, form.single);
            let found = read::parse(&foreign(&expected, form));
            assert_eq!(found.as_ref(), Ok(&expected), "{form:?}");
        }
    }
}

#[test]
fn files_of_others_that_are_cut_or_changed_end_with_an_error_or_a_grid() {
    for form in Form::all() {
        let bytes = foreign(&plain(CellType::Tet4, false), form);
        let end = bytes.len() - "\n</AppendedData>\n</VTKFile>\n".len();
        for length in (0..end).step_by(7).filter(|_| form.format == "appended") {
            assert!(read::parse(&bytes[..length]).is_err(), "{form:?}: {length} of {end}");
        }
        for at in (0..bytes.len()).step_by(11) {
            let mut bytes = bytes.clone();
            bytes[at] ^= 0x15;
            drop(read::parse(&bytes));
        }
    }
}

#[test]
fn what_files_of_others_have_and_should_not_is_said() {
    let form = Form {
        format: "ascii",
        encoding: "",
        word: 8,
        compressed: false,
        big_endian: false,
        single: false,
    };
    let text = String::from_utf8(foreign(&plain(CellType::Tet4, false), form)).expect("letters");
    for (from, to, words) in [
        ("header_type=\"UInt64\"", "compressor=\"vtkLZ4DataCompressor\"", "vtkZLibDataCompressor"),
        ("UnstructuredGrid\" v", "PolyData\" v", "UnstructuredGrid is needed"),
        ("10\n 10", "10\n 5", "cells of types 10 and 5"),
        ("10\n 10", "12\n 12", "cells are of type 12"),
        ("</Piece>", "</Piece><Piece>", "several pieces"),
        ("format=\"ascii\">\n<", "format=\"text\">\n<", "ascii, binary or appended"),
        ("type=\"Float64\"\n", "type=\"Bit\"\n", "no type of numbers"),
    ] {
        let message = read::parse(text.replacen(from, to, 1).as_bytes()).expect_err(to);
        assert!(message.contains(words), "{words:?} is not in: {message}");
    }
}
