// What of a mesh is drawn: the triangles of the skin or of a cut, and edges. A skin is smooth: its triangles share points, which have normals.
// The faces of a cut are flat, and figures of tetrahedra belong to triangles: each of these has three points of its own.
import * as THREE from "three";
import type { Scalars } from "./colour_scale";
import type { CutPlane, Frame } from "./framing";
import { UNKNOWN } from "./organ_material";
import { standIn, type SmoothSkin } from "./stand_in";
import { buildFaces, meshFault, outerFaces, uniqueEdges, vertexNormals, type Faces, type OrganMesh } from "./skin";

const MOST_WIRED_FACES = 150_000;
const STAND_IN_POINTS = 4000; // some 8,000 triangles, whose chords leave a round body by a fifth of a pixel of 500
const LEAST_REPLACED = 20_000; // smooth triangles: fewer have no stand-in

export class TriangleSoup {
  readonly geometry = new THREE.BufferGeometry();
  readonly edgeGeometry = new THREE.BufferGeometry();
  /** Where the vertices are now. */
  readonly positions: Float32Array;
  /** Three vertices of each triangle of the boundary. */
  readonly boundary: Uint32Array;

  private readonly rest: Float32Array;
  private readonly restNormals: Float32Array;
  private readonly normals: Float32Array;
  private readonly faces: Faces;
  private readonly skinFaces: Uint32Array;
  private readonly tetCount: number;
  private centroids: Float32Array | null = null;
  private scalars: Scalars | null = null;
  private corners: Uint32Array = new Uint32Array(); // three vertices of each drawn triangle
  private owners = new Int32Array(); // tetrahedron of each drawn triangle
  private isFlat = new Uint8Array(); // of each drawn triangle
  private points: Uint32Array = new Uint32Array(); // vertex of each drawn point
  private pointOwners = new Int32Array(); // a tetrahedron of each drawn point
  private flatPoints: Uint32Array = new Uint32Array(); // the first of the three points of each flat triangle
  private edgePoints: Uint32Array = new Uint32Array(); // vertex of each point that an edge ends at
  private wires: Uint32Array | null = null;
  private choice = "";
  private standInWork: Generator<void, Uint32Array, void> | null = null;
  private standInTriangles = 0; // 0: there is none
  private isAllotted = false;
  private isMoved = true;
  private isRecoloured = true;

  /** Throws: Error, in words for a reader, where the mesh is broken. */
  constructor(mesh: OrganMesh) {
    const fault = meshFault(mesh);
    if (fault) throw new Error(fault);
    const vertices = mesh.positions.length / 3;
    this.positions = mesh.positions.slice();
    this.rest = mesh.positions.slice();
    this.tetCount = mesh.tets.length / 4;
    this.faces = this.tetCount > 0 ? buildFaces(mesh.tets, vertices) : surfaceFaces(mesh.triangles!);
    this.skinFaces = outerFaces(this.faces, () => true);
    this.boundary = mesh.triangles ?? gather(this.faces.corners, this.skinFaces);
    this.normals = new Float32Array(mesh.positions.length);
    vertexNormals(this.positions, this.boundary, this.normals);
    this.restNormals = this.normals.slice();
    if (this.tetCount > 0) this.centroids = centroidsOf(mesh);
  }

  restNormal(vertex: number): [number, number, number] {
    return [this.restNormals[3 * vertex]!, this.restNormals[3 * vertex + 1]!, this.restNormals[3 * vertex + 2]!];
  }

  /** Throws: Error if the number of vertices differs. */
  setPositions(positions: Float32Array): void {
    if (positions.length !== this.positions.length)
      throw new Error(`expected ${this.positions.length / 3} vertices, found ${positions.length / 3}`);
    this.positions.set(positions);
    this.isMoved = true;
  }

  /** Throws: Error if there are more or fewer figures than vertices or tetrahedra. */
  setScalars(scalars: Scalars | null): void {
    const expected = scalars?.on === "tet" ? this.tetCount : this.positions.length / 3;
    if (scalars && scalars.values.length !== expected)
      throw new Error(`${scalars.name}: expected ${expected} figures, found ${scalars.values.length}`);
    if ((scalars?.on === "tet") !== (this.scalars?.on === "tet")) this.isAllotted = false;
    this.scalars = scalars;
    this.isRecoloured = true;
  }

  /**
   * Draws what lies behind the plane, whole tetrahedra by their middles, or the whole skin without a plane; with the edges of what is drawn,
   * of all tetrahedra, or none.
   */
  show(plane: CutPlane | null, edges: "none" | "drawn" | "all", frame: Frame): void {
    const choice = JSON.stringify([plane, edges]);
    if (choice === this.choice) return;
    this.choice = choice;
    const { centroids } = this;
    let shown = this.skinFaces;
    let isKept: (tet: number) => boolean = () => true;
    if (plane && centroids) {
      const [nx, ny, nz] = plane.normal;
      const bound = plane.offset * frame.radius + nx * frame.centre[0] + ny * frame.centre[1] + nz * frame.centre[2];
      isKept = (tet) => nx * centroids[3 * tet]! + ny * centroids[3 * tet + 1]! + nz * centroids[3 * tet + 2]! < bound;
      shown = outerFaces(this.faces, isKept);
    }
    this.choose(shown, isKept);
    this.allotEdges(edges === "none" ? new Uint32Array() : edges === "drawn" ? uniqueEdges(this.corners, this.positions.length / 3) : this.allEdges());
  }

  /** Brings what has changed to the graphics memory. */
  upload(): void {
    if (!this.isAllotted) this.allot();
    if (this.isMoved) this.fillPlaces();
    if (this.isRecoloured) this.fillScalars();
    this.isMoved = this.isRecoloured = false;
  }

  /**
   * Works on the stand-in of what is drawn, which is for a body that is turned where pictures are slow (stand_in.ts), until the clock says
   * `until_ms`. Whether there is more to do. There is none where triangles are few, or most are flat: a figure of tetrahedra, the faces of a cut.
   */
  workOnStandIn(until_ms: number): boolean {
    while (this.standInWork) {
      const step = this.standInWork.next();
      if (step.done) this.keepStandIn(step.value);
      else if (performance.now() >= until_ms) return true;
    }
    return false;
  }

  /** Draws the stand-in if there is one, or everything. */
  draw(what: "stand-in" | "everything"): void {
    const all = this.corners.length;
    if (what === "stand-in" && this.standInTriangles > 0) this.geometry.setDrawRange(all, 3 * this.standInTriangles);
    else this.geometry.setDrawRange(0, all);
  }

  /** How many triangles a picture has now. */
  get drawnTriangles(): number {
    return Math.min(this.geometry.drawRange.count, this.corners.length) / 3;
  }

  dispose(): void {
    this.standInWork = null;
    this.geometry.dispose();
    this.edgeGeometry.dispose();
  }

  private choose(shown: Uint32Array, isKept: (tet: number) => boolean): void {
    const { corners, inner, outer } = this.faces;
    this.corners = new Uint32Array(3 * shown.length);
    this.owners = new Int32Array(shown.length);
    this.isFlat = new Uint8Array(shown.length);
    shown.forEach((face, i) => {
      const isTurned = !isKept(inner[face]!);
      const [a, b, c] = [corners[3 * face]!, corners[3 * face + 1]!, corners[3 * face + 2]!];
      this.corners.set(isTurned ? [a, c, b] : [a, b, c], 3 * i);
      this.owners[i] = isTurned ? outer[face]! : inner[face]!;
      this.isFlat[i] = outer[face]! >= 0 ? 1 : 0;
    });
    this.isAllotted = false;
  }

  private allot(): void {
    const isSplit = this.scalars?.on === "tet";
    const first = new Int32Array(this.positions.length / 3).fill(-1); // the point that smooth triangles share
    const [points, owners, flat] = [[] as number[], [] as number[], [] as number[]];
    const smooth = isSplit ? 0 : this.isFlat.reduce((sum, each) => sum - each, this.isFlat.length);
    // What stands in for more than half of all triangles is behind them in the index.
    const hasStandIn = smooth >= LEAST_REPLACED && 2 * smooth > this.isFlat.length;
    const index = new Uint32Array(this.corners.length + (hasStandIn ? 3 * Math.floor(this.isFlat.length / 2) : 0));
    this.corners.forEach((vertex, i) => {
      const triangle = Math.floor(i / 3);
      const isOwn = isSplit || this.isFlat[triangle] === 1;
      if (this.isFlat[triangle] && i % 3 === 0) flat.push(points.length);
      if (isOwn || first[vertex]! < 0) {
        index[i] = points.length;
        if (!isOwn) first[vertex] = points.length;
        points.push(vertex);
        owners.push(this.owners[triangle]!);
      } else {
        index[i] = first[vertex]!;
      }
    });
    this.points = Uint32Array.from(points);
    this.pointOwners = Int32Array.from(owners);
    this.flatPoints = Uint32Array.from(flat);
    this.geometry.dispose();
    this.geometry.setIndex(new THREE.BufferAttribute(index, 1));
    for (const [name, width] of [["position", 3], ["normal", 3], ["rest", 3], ["restNormal", 3], ["scalar", 1]] as const)
      this.geometry.setAttribute(name, new THREE.BufferAttribute(new Float32Array(width * points.length), width).setUsage(THREE.DynamicDrawUsage));
    const rest = this.array("rest");
    copyVertices(this.points, this.rest, rest);
    const size = extentOf(this.rest);
    for (let i = 0; i < rest.length; i++) rest[i] = rest[i]! / size;
    copyVertices(this.points, this.restNormals, this.array("restNormal"));
    this.standInTriangles = 0;
    this.standInWork = hasStandIn ? this.makeStandIn(index) : null;
    this.draw("everything");
    this.isAllotted = this.isMoved = this.isRecoloured = true;
  }

  // Begins only when somebody asks for its first step.
  private *makeStandIn(index: Uint32Array): Generator<void, Uint32Array, void> {
    return yield* standIn(this.smoothSkin(index), STAND_IN_POINTS);
  }

  // Points that flat triangles share a vertex with stay, so that no gap opens between them.
  private smoothSkin(index: Uint32Array): SmoothSkin {
    const ofFlat = new Uint8Array(this.positions.length / 3);
    this.corners.forEach((vertex, i) => this.isFlat[Math.floor(i / 3)] && (ofFlat[vertex] = 1));
    const corners = index.subarray(0, this.corners.length).filter((_, i) => !this.isFlat[Math.floor(i / 3)]);
    return { places: this.array("rest"), normals: this.array("restNormal"), corners, isHeld: Uint8Array.from(this.points, (vertex) => ofFlat[vertex]!) };
  }

  private keepStandIn(smooth: Uint32Array): void {
    this.standInWork = null;
    const index = this.geometry.getIndex()!;
    const array = index.array as Uint32Array;
    const all = this.corners.length;
    const flat = array.subarray(0, all).filter((_, i) => this.isFlat[Math.floor(i / 3)] === 1);
    if (all + smooth.length + flat.length > array.length) return; // it would save too little
    array.set(smooth, all);
    array.set(flat, all + smooth.length);
    this.standInTriangles = (smooth.length + flat.length) / 3;
    index.needsUpdate = true;
  }

  private allotEdges(edges: Uint32Array): void {
    const place = new Int32Array(this.positions.length / 3).fill(-1);
    const points: number[] = [];
    for (const vertex of edges) {
      if (place[vertex]! >= 0) continue;
      place[vertex] = points.length;
      points.push(vertex);
    }
    this.edgePoints = Uint32Array.from(points);
    this.edgeGeometry.dispose();
    this.edgeGeometry.setIndex(new THREE.BufferAttribute(edges.map((vertex) => place[vertex]!), 1));
    this.edgeGeometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(3 * points.length), 3).setUsage(THREE.DynamicDrawUsage));
    this.isMoved = true;
  }

  // Of all tetrahedra, or of the skin where they are so many that nothing is seen through them.
  private allEdges(): Uint32Array {
    const isFew = this.faces.inner.length <= MOST_WIRED_FACES;
    return (this.wires ??= uniqueEdges(isFew ? this.faces.corners : this.boundary, this.positions.length / 3));
  }

  private array(name: string): Float32Array {
    return (this.geometry.getAttribute(name) as THREE.BufferAttribute).array as Float32Array;
  }

  private fillPlaces(): void {
    vertexNormals(this.positions, this.boundary, this.normals);
    const [place, normal] = [this.array("position"), this.array("normal")];
    copyVertices(this.points, this.positions, place);
    copyVertices(this.points, this.normals, normal);
    for (const point of this.flatPoints) flatten(place, normal, 3 * point);
    copyVertices(this.edgePoints, this.positions, this.edgeGeometry.getAttribute("position").array as Float32Array);
    for (const name of ["position", "normal"]) this.geometry.getAttribute(name).needsUpdate = true;
    this.edgeGeometry.getAttribute("position").needsUpdate = true;
  }

  private fillScalars(): void {
    const scalar = this.array("scalar");
    const { scalars } = this;
    for (let i = 0; i < scalar.length; i++) {
      const value = scalars ? scalars.values[scalars.on === "tet" ? this.pointOwners[i]! : this.points[i]!]! : 0;
      scalar[i] = Number.isFinite(value) ? value : UNKNOWN;
    }
    this.geometry.getAttribute("scalar").needsUpdate = true;
  }
}

// A surface without tetrahedra: each triangle bounds something of its own.
function surfaceFaces(triangles: Uint32Array): Faces {
  const count = triangles.length / 3;
  return { corners: triangles, inner: Int32Array.from({ length: count }, (_, i) => i), outer: new Int32Array(count).fill(-1) };
}

function gather(corners: Uint32Array, faces: Uint32Array): Uint32Array {
  const found = new Uint32Array(3 * faces.length);
  faces.forEach((face, i) => found.set(corners.subarray(3 * face, 3 * face + 3), 3 * i));
  return found;
}

function centroidsOf(mesh: OrganMesh): Float32Array {
  const found = new Float32Array((3 * mesh.tets.length) / 4);
  for (let i = 0; i < mesh.tets.length; i++) {
    for (let axis = 0; axis < 3; axis++) {
      const at = 3 * Math.floor(i / 4) + axis;
      found[at] = found[at]! + mesh.positions[3 * mesh.tets[i]! + axis]! / 4;
    }
  }
  return found;
}

function copyVertices(vertices: Uint32Array, from: Float32Array, to: Float32Array): void {
  for (let i = 0; i < vertices.length; i++) {
    const at = 3 * vertices[i]!;
    to[3 * i] = from[at]!;
    to[3 * i + 1] = from[at + 1]!;
    to[3 * i + 2] = from[at + 2]!;
  }
}

// The normal of the triangle whose nine coordinates begin at `at`, for all of its corners.
function flatten(place: Float32Array, normal: Float32Array, at: number): void {
  const d = (corner: number, axis: number) => place[at + 3 * corner + axis]! - place[at + axis]!;
  const n = [d(1, 1) * d(2, 2) - d(1, 2) * d(2, 1), d(1, 2) * d(2, 0) - d(1, 0) * d(2, 2), d(1, 0) * d(2, 1) - d(1, 1) * d(2, 0)];
  const length = Math.hypot(...n) || 1;
  for (let i = 0; i < 9; i++) normal[at + i] = n[i % 3]! / length;
}

function extentOf(positions: Float32Array): number {
  let size = 0;
  for (let axis = 0; axis < 3; axis++) {
    let [low, high] = [Infinity, -Infinity];
    for (let i = axis; i < positions.length; i += 3) {
      low = Math.min(low, positions[i]!);
      high = Math.max(high, positions[i]!);
    }
    size = Math.max(size, high - low);
  }
  return size || 1;
}
