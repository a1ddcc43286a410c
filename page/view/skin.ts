// The triangles of a tetrahedral mesh, and normals at its vertices.

/** A tetrahedral mesh as it is drawn. */
export interface OrganMesh {
  /** x, y, z of each vertex. */
  positions: Float32Array;
  /** Four vertices of each tetrahedron, counted from 0, positively oriented. */
  tets: Uint32Array;
  /** Three vertices of each triangle of the boundary, seen from outside counter-clockwise; found from the tetrahedra if it is not given. */
  triangles?: Uint32Array;
}

/** Each face of a mesh once, with the tetrahedra on both sides. */
export interface Faces {
  /** Three vertices a face, counter-clockwise seen from outside of the first tetrahedron. */
  corners: Uint32Array;
  /** The tetrahedron that the corners look out of. */
  inner: Int32Array;
  /** The one on the other side, -1 on the boundary. */
  outer: Int32Array;
}

// Of a positively oriented tetrahedron, counter-clockwise seen from outside.
const FACES_OF_TET = [
  [1, 2, 3],
  [0, 3, 2],
  [0, 1, 3],
  [0, 2, 1],
] as const;

/** All faces of the tetrahedra, in the order in which they come. */
export function buildFaces(tets: Uint32Array, vertices: number): Faces {
  const tetCount = tets.length / 4;
  const corners = new Uint32Array(12 * tetCount);
  const inner = new Int32Array(4 * tetCount);
  const outer = new Int32Array(4 * tetCount).fill(-1);
  // Faces hang in chains from their least vertex.
  const first = new Int32Array(vertices).fill(-1);
  const next = new Int32Array(4 * tetCount);
  let count = 0;
  for (let tet = 0; tet < tetCount; tet++) {
    for (const face of FACES_OF_TET) {
      const a = tets[4 * tet + face[0]]!;
      const b = tets[4 * tet + face[1]]!;
      const c = tets[4 * tet + face[2]]!;
      const least = Math.min(a, b, c);
      const sum = a + b + c;
      let found = first[least]!;
      while (found >= 0) {
        const [p, q, r] = [corners[3 * found]!, corners[3 * found + 1]!, corners[3 * found + 2]!];
        if (outer[found]! < 0 && p + q + r === sum && isCorner(a, p, q, r) && isCorner(b, p, q, r)) break;
        found = next[found]!;
      }
      if (found >= 0) {
        outer[found] = tet;
        continue;
      }
      corners.set([a, b, c], 3 * count);
      inner[count] = tet;
      next[count] = first[least]!;
      first[least] = count++;
    }
  }
  return { corners: corners.slice(0, 3 * count), inner: inner.slice(0, count), outer: outer.slice(0, count) };
}

function isCorner(vertex: number, p: number, q: number, r: number): boolean {
  return vertex === p || vertex === q || vertex === r;
}

/** The numbers of the faces that bound the kept tetrahedra. */
export function outerFaces(faces: Faces, isKept: (tet: number) => boolean): Uint32Array {
  const found: number[] = [];
  for (let face = 0; face < faces.inner.length; face++) {
    const inside = isKept(faces.inner[face]!);
    const beyond = faces.outer[face]! >= 0 && isKept(faces.outer[face]!);
    if (inside !== beyond) found.push(face);
  }
  return Uint32Array.from(found);
}

/**
 * Normals at the vertices: the mean of the normals of the triangles around each, weighted by their areas.
 * Vertices of no triangle have a normal of 0. Writes into `normals`, x, y, z of each vertex.
 */
export function vertexNormals(positions: Float32Array, triangles: Uint32Array, normals: Float32Array): void {
  normals.fill(0);
  for (let i = 0; i < triangles.length; i += 3) {
    const a = 3 * triangles[i]!;
    const b = 3 * triangles[i + 1]!;
    const c = 3 * triangles[i + 2]!;
    const ux = positions[b]! - positions[a]!, uy = positions[b + 1]! - positions[a + 1]!, uz = positions[b + 2]! - positions[a + 2]!;
    const vx = positions[c]! - positions[a]!, vy = positions[c + 1]! - positions[a + 1]!, vz = positions[c + 2]! - positions[a + 2]!;
    const nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
    for (const at of [a, b, c]) {
      normals[at] = normals[at]! + nx;
      normals[at + 1] = normals[at + 1]! + ny;
      normals[at + 2] = normals[at + 2]! + nz;
    }
  }
  for (let i = 0; i < normals.length; i += 3) {
    const length = Math.hypot(normals[i]!, normals[i + 1]!, normals[i + 2]!);
    if (length === 0) continue;
    normals[i] = normals[i]! / length;
    normals[i + 1] = normals[i + 1]! / length;
    normals[i + 2] = normals[i + 2]! / length;
  }
}

/** Each edge of these triangles once: two vertices an edge. */
export function uniqueEdges(triangles: Uint32Array, vertices: number): Uint32Array {
  const seen = new Set<number>();
  const edges: number[] = [];
  for (let i = 0; i < triangles.length; i += 3) {
    for (let side = 0; side < 3; side++) {
      const a = triangles[i + side]!;
      const b = triangles[i + ((side + 1) % 3)]!;
      const key = Math.min(a, b) * vertices + Math.max(a, b);
      if (seen.has(key)) continue;
      seen.add(key);
      edges.push(a, b);
    }
  }
  return Uint32Array.from(edges);
}

/** Says what is wrong with a mesh, or nothing. */
export function meshFault(mesh: OrganMesh): string | null {
  if (mesh.positions.length === 0 || mesh.positions.length % 3 !== 0) return "the mesh has no vertices";
  if (mesh.tets.length % 4 !== 0) return "the tetrahedra are incomplete";
  if (mesh.triangles && mesh.triangles.length % 3 !== 0) return "the triangles are incomplete";
  if (mesh.tets.length === 0 && !mesh.triangles?.length) return "the mesh has neither tetrahedra nor triangles";
  const vertices = mesh.positions.length / 3;
  for (const list of [mesh.tets, mesh.triangles ?? new Uint32Array()]) {
    for (const vertex of list) if (vertex >= vertices) return `vertex ${vertex} is named, and there are ${vertices}`;
  }
  for (const value of mesh.positions) if (!Number.isFinite(value)) return "a coordinate is no finite number";
  return null;
}
