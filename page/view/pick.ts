// Which triangle of the boundary a ray meets first.

export interface Hit {
  /** The corner of the triangle nearest to the point. */
  vertex: number;
  /** The triangle's place among the boundary's. */
  triangle: number;
  point: [number, number, number];
  /** Of the triangle, outwards, of length 1. */
  normal: [number, number, number];
  distance: number;
}

/**
 * The first triangle that looks to the ray's origin and that the ray meets (Moeller and Trumbore), or nothing.
 * `direction` has length 1.
 */
export function pickTriangle(positions: Float32Array, triangles: Uint32Array, origin: readonly number[], direction: readonly number[]): Hit | null {
  let best: Hit | null = null;
  const [ox, oy, oz] = origin as [number, number, number];
  const [dx, dy, dz] = direction as [number, number, number];
  for (let i = 0; i < triangles.length; i += 3) {
    const a = 3 * triangles[i]!, b = 3 * triangles[i + 1]!, c = 3 * triangles[i + 2]!;
    const ax = positions[a]!, ay = positions[a + 1]!, az = positions[a + 2]!;
    const e1x = positions[b]! - ax, e1y = positions[b + 1]! - ay, e1z = positions[b + 2]! - az;
    const e2x = positions[c]! - ax, e2y = positions[c + 1]! - ay, e2z = positions[c + 2]! - az;
    const px = dy * e2z - dz * e2y, py = dz * e2x - dx * e2z, pz = dx * e2y - dy * e2x;
    const det = e1x * px + e1y * py + e1z * pz;
    if (!(det > 0)) continue; // from behind, or along
    const tx = ox - ax, ty = oy - ay, tz = oz - az;
    const u = tx * px + ty * py + tz * pz;
    if (u < 0 || u > det) continue;
    const qx = ty * e1z - tz * e1y, qy = tz * e1x - tx * e1z, qz = tx * e1y - ty * e1x;
    const v = dx * qx + dy * qy + dz * qz;
    if (v < 0 || u + v > det) continue;
    const t = (e2x * qx + e2y * qy + e2z * qz) / det;
    if (t <= 0 || (best && t >= best.distance)) continue;
    const weights = [1 - (u + v) / det, u / det, v / det];
    const nx = e1y * e2z - e1z * e2y, ny = e1z * e2x - e1x * e2z, nz = e1x * e2y - e1y * e2x;
    const length = Math.hypot(nx, ny, nz) || 1;
    best = {
      vertex: triangles[i + weights.indexOf(Math.max(...weights))]!,
      triangle: i / 3,
      point: [ox + t * dx, oy + t * dy, oz + t * dz],
      normal: [nx / length, ny / length, nz / length],
      distance: t,
    };
  }
  return best;
}
