// Triangles with normals that are smooth but for creases.

/** Cosine of the angle between triangles above which the edge between them is sharp (40°). */
const CREASE = 0.77;

/** Triangles at each of `count` points: where the list of a point starts, and all lists. */
export function around(count, triangles) {
  const start = new Uint32Array(count + 1);
  for (const v of triangles) start[v + 1] += 1;
  for (let v = 0; v < count; v++) start[v + 1] += start[v];
  const next = start.slice();
  const of = new Uint32Array(triangles.length);
  for (let i = 0; i < triangles.length; i++) of[next[triangles[i]]++] = Math.floor(i / 3);
  return { start, of };
}

/** Writes positions and normals of every corner of every triangle from those of the points. */
export function shade(points, triangles, { start, of }, positions, normals) {
  const count = triangles.length / 3;
  const own = new Float32Array(3 * count);
  const area = new Float32Array(count);
  for (let t = 0; t < count; t++) {
    const [a, b, c] = [3 * triangles[3 * t], 3 * triangles[3 * t + 1], 3 * triangles[3 * t + 2]];
    const ux = points[b] - points[a], uy = points[b + 1] - points[a + 1], uz = points[b + 2] - points[a + 2];
    const vx = points[c] - points[a], vy = points[c + 1] - points[a + 1], vz = points[c + 2] - points[a + 2];
    const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
    area[t] = Math.hypot(x, y, z);
    const length = area[t] || 1;
    own[3 * t] = x / length;
    own[3 * t + 1] = y / length;
    own[3 * t + 2] = z / length;
  }
  for (let i = 0; i < triangles.length; i++) {
    const v = triangles[i];
    const t = 3 * Math.floor(i / 3);
    let x = 0, y = 0, z = 0;
    for (let k = start[v]; k < start[v + 1]; k++) {
      const n = 3 * of[k];
      const cosine = own[t] * own[n] + own[t + 1] * own[n + 1] + own[t + 2] * own[n + 2];
      if (cosine < CREASE) continue;
      const weight = area[of[k]];
      x += weight * own[n];
      y += weight * own[n + 1];
      z += weight * own[n + 2];
    }
    const length = Math.hypot(x, y, z) || 1;
    for (let c = 0; c < 3; c++) positions[3 * i + c] = points[3 * v + c];
    normals[3 * i] = x / length;
    normals[3 * i + 1] = y / length;
    normals[3 * i + 2] = z / length;
  }
}
