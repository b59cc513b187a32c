//! Tetrahedra of each degree: solver and files know the same nodes in the same order.

use mechanics::element::{FunctionSpace, HIGHEST_DEGREE, node_indices};
use mesh::io::vtu::CellType;

#[test]
fn elements_of_all_degrees_are_cells_of_results() {
    let cells = [CellType::Tet4, CellType::Tet10, CellType::Tet20];
    assert_eq!(cells.len(), HIGHEST_DEGREE);
    for (degree, cell) in (1..).zip(cells) {
        let space = FunctionSpace::new(degree, 4, vec![[0, 1, 2, 3]]);
        let nodes = node_indices(4, degree);
        assert_eq!((space.nodes_per_element(), nodes.len()), (cell.nodes(), cell.nodes()));
        // behind the corners, those of each edge from its first corner to its second
        let between = degree - 1;
        for (e, &[a, b]) in cell.edges().iter().enumerate() {
            for k in 1..=between {
                let mut index = vec![0; 4];
                (index[a], index[b]) = (degree - k, k);
                assert_eq!(nodes[4 + e * between + k - 1], index, "degree {degree}, edge {e}");
            }
        }
        assert_eq!(cell.edges().len(), if degree > 1 { 6 } else { 0 });
    }
}
