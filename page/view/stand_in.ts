// Fewer triangles between the points of a skin, for the time in which it is turned where pictures are slow.
//
// Some of the points stand for those around them. A triangle is left where its corners are stood for by three different points, and then lies
// between these. Nothing is computed for the points that are left: place, normal, colour and texture are those that they have, so what moves
// the skin moves its stand-in. A closed skin has no holes in it: two triangles that share an edge still share it, or it has become a point.

/** What is drawn smoothly of a body. */
export interface SmoothSkin {
  /** x, y, z and the normal of each point, of the shape at first. */
  places: Float32Array;
  normals: Float32Array;
  /** Three points of each triangle. */
  corners: Uint32Array;
  /** Of each point: 1 if other triangles end there, so that it has to stay. */
  isHeld: Uint8Array;
}

const PIECE = 1024; // points or triangles between two moments at which the work can be left
const COVERED = 1.4; // the area that belongs to a point, over the square of the least distance: of points put down at random until no place is left
// Of the least cosine between a point's normal and those of its triangles: a corner of a cube has 0.58, its edges 0.71.
const SHARPEST = [0.65, 0.85, Infinity];

/**
 * Three points of each triangle of the stand-in, which has about `wanted` points. It can be left at each `yield` and gone on with.
 * The same skin gives the same stand-in.
 */
export function* standIn(skin: SmoothSkin, wanted: number): Generator<void, Uint32Array, void> {
  const { corners } = skin;
  const { first, around } = yield* trianglesAround(skin);
  const { area, sharpness } = yield* measure(skin);
  const reach = Math.sqrt(area / (COVERED * wanted));
  const { places, isHeld } = skin;
  const owner = new Int32Array(isHeld.length).fill(-1);
  const distance = new Float64Array(isHeld.length).fill(Infinity);
  for (let point = 0; point < owner.length; point++) {
    if (!isHeld[point]) continue;
    owner[point] = point;
    distance[point] = 0;
  }
  const apart = (a: number, b: number) => Math.hypot(places[3 * a]! - places[3 * b]!, places[3 * a + 1]! - places[3 * b + 1]!, places[3 * a + 2]! - places[3 * b + 2]!);
  const reached: number[] = [];
  // Goes along the skin, so that the other side of a thin body is another place.
  const own = (middle: number) => {
    owner[middle] = middle;
    distance[middle] = 0;
    reached.push(middle);
    while (reached.length) {
      const from = reached.pop()!;
      for (let k = first[from]!; k < first[from + 1]!; k++) {
        for (let corner = 0; corner < 3; corner++) {
          const to = corners[3 * around[k]! + corner]!;
          const length = apart(middle, to);
          if (length >= reach || length >= distance[to]!) continue;
          owner[to] = middle;
          distance[to] = length;
          reached.push(to);
        }
      }
    }
  };
  // Corners and sharp edges first: they are what a silhouette would miss.
  let done = 0;
  for (const [rank, bound] of SHARPEST.entries()) {
    for (let point = 0; point < owner.length; point++) {
      const isOfRank = sharpness[point]! < bound && (rank === 0 || sharpness[point]! >= SHARPEST[rank - 1]!);
      if (isOfRank && (owner[point]! < 0 || isHeld[point])) own(point);
      if (++done % PIECE === 0) yield;
    }
  }
  return yield* between(corners, owner);
}

// The triangles at each point, one point after the other.
function* trianglesAround({ corners, isHeld }: SmoothSkin): Generator<void, { first: Uint32Array; around: Uint32Array }, void> {
  const first = new Uint32Array(isHeld.length + 1);
  for (const point of corners) first[point + 1] = first[point + 1]! + 1;
  for (let point = 0; point < isHeld.length; point++) first[point + 1] = first[point + 1]! + first[point]!;
  const next = first.slice();
  const around = new Uint32Array(corners.length);
  for (let i = 0; i < corners.length; i++) {
    const point = corners[i]!;
    around[next[point]!] = Math.floor(i / 3);
    next[point] = next[point]! + 1;
    if (i % (3 * PIECE) === 0) yield;
  }
  return { first, around };
}

// The area of all triangles, and of each point the least cosine between its normal and those of its triangles.
function* measure({ places, normals, corners, isHeld }: SmoothSkin): Generator<void, { area: number; sharpness: Float32Array }, void> {
  const sharpness = new Float32Array(isHeld.length).fill(1);
  let area = 0;
  for (let i = 0; i < corners.length; i += 3) {
    const a = 3 * corners[i]!, b = 3 * corners[i + 1]!, c = 3 * corners[i + 2]!;
    const ux = places[b]! - places[a]!, uy = places[b + 1]! - places[a + 1]!, uz = places[b + 2]! - places[a + 2]!;
    const vx = places[c]! - places[a]!, vy = places[c + 1]! - places[a + 1]!, vz = places[c + 2]! - places[a + 2]!;
    const nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
    const length = Math.hypot(nx, ny, nz);
    area += length / 2;
    for (const at of [a, b, c]) {
      const cosine = (nx * normals[at]! + ny * normals[at + 1]! + nz * normals[at + 2]!) / length;
      if (cosine < sharpness[at / 3]!) sharpness[at / 3] = cosine;
    }
    if (i % (3 * PIECE) === 0) yield;
  }
  return { area, sharpness };
}

function* between(corners: Uint32Array, owner: Int32Array): Generator<void, Uint32Array, void> {
  const found: number[] = [];
  for (let i = 0; i < corners.length; i += 3) {
    const a = owner[corners[i]!]!, b = owner[corners[i + 1]!]!, c = owner[corners[i + 2]!]!;
    if (a !== b && b !== c && c !== a) found.push(a, b, c);
    if (i % (3 * PIECE) === 0) yield;
  }
  return Uint32Array.from(found);
}
