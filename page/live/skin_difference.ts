// How far two displacements of the same skin are apart.

/** For each vertex of `answer`'s order its number in the mesh. Vertices are the same where their coordinates are, to the bit. */
export function matchVertices(points: Float64Array, wholePoints: Float64Array, vertices: Uint32Array): Uint32Array | null {
  const key = (list: Float64Array, v: number) => `${list[3 * v]},${list[3 * v + 1]},${list[3 * v + 2]}`;
  const found = new Map<string, number>();
  for (let v = 0; v < points.length / 3; v++) found.set(key(points, v), v);
  const out = new Uint32Array(vertices.length);
  for (let k = 0; k < vertices.length; k++) {
    const at = found.get(key(wholePoints, vertices[k]!));
    if (at === undefined) return null;
    out[k] = at;
  }
  return out;
}

/**
 * Distances at the vertices into `distance` (in the displacements' unit, one a vertex of the mesh, 0 inside), the largest displacement of
 * `answer`, and the root mean square of the distances over that of `answer`; null where nothing moves.
 */
export function compareSkins(displacement: Float32Array, answer: Float32Array, vertices: Uint32Array, distance: Float32Array): { largest: number; relative: number | null } {
  let apart = 0;
  let own = 0;
  let largestSq = 0;
  for (let k = 0; k < vertices.length; k++) {
    const v = vertices[k]!;
    const [x, y, z] = [answer[3 * k]!, answer[3 * k + 1]!, answer[3 * k + 2]!];
    const [dx, dy, dz] = [displacement[3 * v]! - x, displacement[3 * v + 1]! - y, displacement[3 * v + 2]! - z];
    const squared = x * x + y * y + z * z;
    const off = dx * dx + dy * dy + dz * dz;
    apart += off;
    own += squared;
    largestSq = Math.max(largestSq, squared);
    distance[v] = Math.sqrt(off);
  }
  return { largest: Math.sqrt(largestSq), relative: own > 0 ? Math.sqrt(apart / own) : null };
}

/** The next of 1, 2, 5, 10, ... that is not below a value above zero. */
export function roundUp(value: number): number {
  const size = 10 ** Math.floor(Math.log10(value));
  return ([1, 2, 5].find((step) => step * size >= value * (1 - 1e-9)) ?? 10) * size;
}
