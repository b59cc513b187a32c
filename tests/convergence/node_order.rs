//! Files of quadratic and cubic results as other programs read them.

use std::path::Path;
use std::process::Command;

use mechanics::element::FunctionSpace;
use run::report::results::grid;
use tests::block;
use tests::workdir::python;

/// What the scripts import.
const PACKAGES: &str = "meshio, gmsh, numpy";

/// Reads a file with meshio and interpolates the field `place`, which holds the
/// coordinates of the nodes, by the Lagrange basis on VTK's node order: it must
/// be the affine map of the corners at random points. The order is that of
/// vtkQuadraticTetra and vtkHigherOrderTetra: vertices, edges 01 12 20 03 13 23
/// from their first end, faces 013 123 023 012.
const READ: &str = r#"
import sys, numpy as np, meshio
mesh = meshio.read(sys.argv[1])
degree = int(sys.argv[2])
cells = mesh.cells[0]
assert cells.type == {1: "tetra", 2: "tetra10", 3: "VTK_LAGRANGE_TETRAHEDRON"}[degree], cells.type
place = mesh.point_data["displacement"]
assert np.array_equal(place, mesh.points)
unit = np.eye(4)
nodes = [degree * unit[i] for i in range(4)]
for a, b in [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]:
    nodes += [(degree - k) * unit[a] + k * unit[b] for k in range(1, degree)]
if degree == 3:
    nodes += [sum(unit[c] for c in face) for face in [(0, 1, 3), (1, 2, 3), (0, 2, 3), (0, 1, 2)]]
assert cells.data.shape[1] == len(nodes), cells.data.shape
def basis(index, point):
    value = 1.0
    for m, l in zip(index, point):
        for s in range(int(m)):
            value *= (degree * l - s) / (s + 1)
    return value
rng = np.random.default_rng(1)
worst = 0.0
for point in rng.dirichlet(np.ones(4), 20):
    weights = np.array([basis(n, point) for n in nodes])
    inside = np.einsum("a,caj->cj", weights, place[cells.data])
    affine = np.einsum("a,caj->cj", point, mesh.points[cells.data[:, :4]])
    worst = max(worst, np.abs(inside - affine).max())
print(worst)
assert worst < 1e-15, worst
"#;

/// Meshes of a cube by Gmsh, straight, quadratic and cubic, and the coordinates
/// of the nodes of its reference elements.
const GMSH: &str = r#"
import sys, gmsh, numpy as np
gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.model.occ.addBox(0, 0, 0, 0.01, 0.02, 0.03)
gmsh.model.occ.synchronize()
gmsh.option.setNumber("Mesh.MeshSizeMin", 0.008)
gmsh.option.setNumber("Mesh.MeshSizeMax", 0.008)
gmsh.model.mesh.generate(3)
for degree in (1, 2, 3):
    gmsh.model.mesh.setOrder(degree)
    for version in (2.2, 4.1):
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.write(f"{sys.argv[1]}/box{degree}v{int(version)}.msh")
gmsh.finalize()
"#;

fn run(python: &Path, script: &str, arguments: &[&str]) {
    let output = Command::new(python).arg("-c").arg(script).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn other_programs_find_the_nodes_of_results_in_place() {
    let Some(python) = python(PACKAGES) else { return };
    let folder = tempfile::tempdir().unwrap();
    let mesh = block([2, 2, 2], 0.01, |_| false, |p| p);
    for degree in [1, 2, 3] {
        let space = FunctionSpace::new(degree, mesh.vertices.len(), mesh.tets.clone());
        let positions = space.node_positions(&mesh.vertices);
        let place: Vec<f64> = positions.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
        let path = folder.path().join(format!("p{degree}.vtu"));
        let grid = grid(&space, &mesh.vertices, &place);
        mesh::io::vtu::write_vtu(&path, &grid).unwrap();
        assert_eq!(mesh::io::vtu::read_vtu(&path).unwrap(), grid);
        run(&python, READ, &[path.to_str().unwrap(), &degree.to_string()]);
    }
}

#[test]
fn curved_meshes_of_gmsh_give_their_straight_body() {
    let Some(python) = python(PACKAGES) else { return };
    let folder = tempfile::tempdir().unwrap();
    run(&python, GMSH, &[folder.path().to_str().unwrap()]);
    let mut counts = Vec::new();
    for degree in [1, 2, 3] {
        for version in [2, 4] {
            let path = folder.path().join(format!("box{degree}v{version}.msh"));
            let mesh = mesh::io::read_tets(&path).unwrap().mesh;
            let volume: f64 = mesh
                .tets
                .iter()
                .map(|t| {
                    let [a, b, c, d] = t.map(|v| mesh.vertices[v]);
                    mesh::measure::tet_volume(a, b, c, d)
                })
                .sum();
            assert!((volume / 6e-6 - 1.0).abs() < 1e-12, "{volume}");
            counts.push((mesh.vertices.len(), mesh.tets.len()));
        }
    }
    assert!(counts.iter().all(|c| *c == counts[0]), "{counts:?}");
}
