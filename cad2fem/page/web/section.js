// The face that a plane leaves on a solid of tetrahedra, with the values on it.

// The corners of the eight tetrahedra of a quadratic one, by its nodes in VTK's order.
const EIGHT = [
  [0, 4, 6, 7], [4, 1, 5, 8], [6, 5, 2, 9], [7, 8, 9, 3],
  [4, 6, 5, 8], [4, 6, 7, 8], [6, 5, 9, 8], [6, 7, 9, 8],
];
const ONE = [[0, 1, 2, 3]];

/**
 * Triangles of the cut n·p = offset: `positions` of their corners, and `values` there, which are
 * those of the points or, with `ofCell`, those of the cells.
 */
export function cut(points, cells, perCell, { normal, offset }, source, ofCell) {
  const count = points.length / 3;
  const height = new Float32Array(count);
  for (let v = 0; v < count; v++) {
    height[v] = normal[0] * points[3 * v] + normal[1] * points[3 * v + 1] + normal[2] * points[3 * v + 2] - offset;
  }
  const positions = [];
  const values = [];
  const small = perCell === 10 ? EIGHT : ONE;
  const corners = new Array(4);
  const emit = (low, high, cell) => {
    const t = height[low] / (height[low] - height[high]);
    for (let c = 0; c < 3; c++) positions.push(points[3 * low + c] + t * (points[3 * high + c] - points[3 * low + c]));
    if (!source) return;
    values.push(ofCell ? source[cell] : source[low] + t * (source[high] - source[low]));
  };
  for (let cell = 0; cell * perCell < cells.length; cell++) {
    const first = cell * perCell;
    let above = 0;
    for (let i = 0; i < perCell; i++) above += height[cells[first + i]] > 0;
    if (above === 0 || above === perCell) continue;
    for (const tet of small) {
      let up = 0;
      for (let i = 0; i < 4; i++) {
        corners[i] = cells[first + tet[i]];
        up += height[corners[i]] > 0;
      }
      if (up === 0 || up === 4) continue;
      const high = corners.filter((v) => height[v] > 0);
      const low = corners.filter((v) => !(height[v] > 0));
      if (up === 2) {
        const quad = [[0, 0], [0, 1], [1, 1], [1, 0]].map(([i, j]) => [low[i], high[j]]);
        for (const i of [0, 1, 2, 0, 2, 3]) emit(...quad[i], cell);
      } else if (up === 1) {
        for (const v of low) emit(v, high[0], cell);
      } else {
        for (const v of high) emit(low[0], v, cell);
      }
    }
  }
  return { positions: new Float32Array(positions), values };
}

/** The lines that a plane leaves on triangles: positions of their ends. */
export function outline(points, triangles, { normal, offset }) {
  const height = (v) => normal[0] * points[3 * v] + normal[1] * points[3 * v + 1] + normal[2] * points[3 * v + 2] - offset;
  const positions = [];
  for (let t = 0; t < triangles.length; t += 3) {
    const corners = [triangles[t], triangles[t + 1], triangles[t + 2]];
    const heights = corners.map(height);
    const above = heights.map((h) => h > 0);
    if (above[0] === above[1] && above[1] === above[2]) continue;
    for (let i = 0; i < 3; i++) {
      const j = (i + 1) % 3;
      if (above[i] === above[j]) continue;
      const part = heights[i] / (heights[i] - heights[j]);
      const [a, b] = [3 * corners[i], 3 * corners[j]];
      for (let c = 0; c < 3; c++) positions.push(points[a + c] + part * (points[b + c] - points[a + c]));
    }
  }
  return new Float32Array(positions);
}
