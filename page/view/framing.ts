// Where the eye stands at first: the same for all views of one body.
export interface Frame {
  centre: [number, number, number];
  /** Of the sphere around the centre that holds the body. */
  radius: number;
  /** From the centre to the eye, and what is up; unit vectors. */
  toEye: [number, number, number];
  up: [number, number, number];
}

/** A plane in the frame of the rest shape; what lies on the side of its normal is taken away. */
export interface CutPlane {
  normal: [number, number, number];
  /** From the centre of the body along the normal, in units of its radius: -1 takes all away, 1 nothing. */
  offset: number;
}

type Vector = [number, number, number];

/** A frame that looks at the broad side of a body, its longest axis across. */
export function frameOf(positions: Float32Array): Frame {
  const count = positions.length / 3;
  const low: Vector = [Infinity, Infinity, Infinity];
  const high: Vector = [-Infinity, -Infinity, -Infinity];
  const mean: Vector = [0, 0, 0];
  for (let i = 0; i < positions.length; i++) {
    const axis = i % 3;
    low[axis] = Math.min(low[axis]!, positions[i]!);
    high[axis] = Math.max(high[axis]!, positions[i]!);
    mean[axis] = mean[axis]! + positions[i]! / count;
  }
  const centre = low.map((value, axis) => (value + high[axis]!) / 2) as Vector;
  let radius = 0;
  for (let i = 0; i < positions.length; i += 3)
    radius = Math.max(radius, Math.hypot(positions[i]! - centre[0], positions[i + 1]! - centre[1], positions[i + 2]! - centre[2]));
  const [longest, middle] = principalAxes(positions, mean);
  const shortest = cross(longest, middle);
  const toEye = unit(combine(shortest, 1, middle, 0.35, longest, 0.3));
  return { centre, radius: radius || 1, toEye, up: middle };
}

// The two longest axes of inertia; the largest component of each is positive.
function principalAxes(positions: Float32Array, mean: Vector): [Vector, Vector] {
  const s = [[0, 0, 0], [0, 0, 0], [0, 0, 0]];
  for (let i = 0; i < positions.length; i += 3) {
    const d = [positions[i]! - mean[0], positions[i + 1]! - mean[1], positions[i + 2]! - mean[2]];
    for (let a = 0; a < 3; a++) for (let b = 0; b < 3; b++) s[a]![b] = s[a]![b]! + d[a]! * d[b]!;
  }
  const axes = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]; // columns are axes[.][k]
  for (let sweep = 0; sweep < 30; sweep++) {
    for (const [p, q] of [[0, 1], [0, 2], [1, 2]] as const) {
      if (s[p]![q] === 0) continue;
      const theta = (s[q]![q]! - s[p]![p]!) / (2 * s[p]![q]!);
      const t = Math.sign(theta || 1) / (Math.abs(theta) + Math.hypot(theta, 1));
      const c = 1 / Math.hypot(t, 1);
      rotate(s, axes, p, q, c, t * c);
    }
  }
  const order = [0, 1, 2].sort((a, b) => s[b]![b]! - s[a]![a]!);
  const axis = (k: number): Vector => {
    const v = [axes[0]![k]!, axes[1]![k]!, axes[2]![k]!] as Vector;
    const largest = v.reduce((best, value) => (Math.abs(value) > Math.abs(best) ? value : best), 0);
    return largest < 0 ? (v.map((value) => -value) as Vector) : v;
  };
  return [axis(order[0]!), axis(order[1]!)];
}

// One Jacobi rotation of the symmetric matrix, and of the axes with it.
function rotate(s: number[][], axes: number[][], p: number, q: number, c: number, sine: number): void {
  for (let k = 0; k < 3; k++) {
    const [a, b] = [s[k]![p]!, s[k]![q]!];
    s[k]![p] = c * a - sine * b;
    s[k]![q] = sine * a + c * b;
  }
  for (let k = 0; k < 3; k++) {
    const [a, b] = [s[p]![k]!, s[q]![k]!];
    s[p]![k] = c * a - sine * b;
    s[q]![k] = sine * a + c * b;
    const [u, v] = [axes[k]![p]!, axes[k]![q]!];
    axes[k]![p] = c * u - sine * v;
    axes[k]![q] = sine * u + c * v;
  }
}

function cross(a: Vector, b: Vector): Vector {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

function combine(a: Vector, x: number, b: Vector, y: number, c: Vector, z: number): Vector {
  return [0, 1, 2].map((i) => x * a[i]! + y * b[i]! + z * c[i]!) as Vector;
}

function unit(v: Vector): Vector {
  const length = Math.hypot(...v) || 1;
  return v.map((value) => value / length) as Vector;
}
