// How an organ is shaded: light at the vertices and its interpolation between them (Gouraud), times a small texture that sticks to the
// rest shape, as in section 4.2.8 of the thesis (normals averaged over the triangles around a vertex, a texture of 32 x 32 that repeats).
import * as THREE from "three";
import { colourTable, STEPS, type ScaleName } from "./colour_scale";

const TEXTURE_SIZE = 32;
const REPEATS = 7; // of the texture, over the longest side of the organ

const VERTEX = /* glsl */ `
  attribute vec3 rest;
  attribute vec3 restNormal;
  attribute float scalar;
  varying float vScalar;
  varying vec2 vLight;
  varying vec2 vLightBehind;
  varying vec3 vRest;
  varying vec3 vWeights;

  // Diffuse and specular light of a headlight a little above the left of the eye, and a faint one from behind.
  vec2 lightAt(vec3 n, vec3 eye) {
    vec3 key = normalize(vec3(-0.35, 0.45, 0.82));
    vec3 fill = normalize(vec3(0.7, -0.3, 0.35));
    float diffuse = 0.30 + 0.62 * max(dot(n, key), 0.0) + 0.16 * max(dot(n, fill), 0.0);
    float shine = pow(max(dot(reflect(-key, n), eye), 0.0), 26.0);
    return vec2(diffuse, shine);
  }

  void main() {
    vec4 place = modelViewMatrix * vec4(position, 1.0);
    vec3 n = normalize(normalMatrix * normal);
    vec3 eye = normalize(-place.xyz);
    vLight = lightAt(n, eye);
    vLightBehind = lightAt(-n, eye);
    vScalar = scalar;
    vRest = rest;
    vec3 w = pow(abs(restNormal), vec3(4.0)) + vec3(1e-5);
    vWeights = w / (w.x + w.y + w.z);
    gl_Position = projectionMatrix * place;
  }
`;

const FRAGMENT = /* glsl */ `
  uniform vec3 tint;
  uniform float textured;
  uniform float hasScalar;
  uniform float low;
  uniform float high;
  uniform float shine;
  uniform sampler2D skinMap;
  uniform sampler2D scaleMap;
  varying float vScalar;
  varying vec2 vLight;
  varying vec2 vLightBehind;
  varying vec3 vRest;
  varying vec3 vWeights;

  float skinAt(vec3 p) {
    return texture2D(skinMap, p.yz).r * vWeights.x + texture2D(skinMap, p.zx).r * vWeights.y + texture2D(skinMap, p.xy).r * vWeights.z;
  }

  void main() {
    float share = clamp((vScalar - low) / (high - low), 0.0, 1.0);
    vec3 scale = texture2D(scaleMap, vec2(share * ${((STEPS - 1) / STEPS).toFixed(6)} + ${(0.5 / STEPS).toFixed(6)}, 0.5)).rgb;
    bool isKnown = vScalar > -1e30;
    vec3 base = hasScalar > 0.5 ? (isKnown ? scale : vec3(0.5)) : tint;
    float skin = mix(1.0, 0.62 + 0.62 * skinAt(vRest * ${REPEATS.toFixed(1)}), hasScalar > 0.5 ? 0.0 : textured);
    vec2 light = gl_FrontFacing ? vLight : vLightBehind * vec2(0.55, 0.0);
    // A coloured figure is read from its colour: its light is flatter and has no shine.
    float diffuse = hasScalar > 0.5 ? mix(1.0, light.x, 0.45) : light.x;
    vec3 colour = base * skin * diffuse + vec3(light.y * shine * (hasScalar > 0.5 ? 0.0 : 1.0));
    gl_FragColor = vec4(colour, 1.0);
  }
`;

/** A figure that is not known at a vertex; drawn grey. */
export const UNKNOWN = -1e31;

/** The material of an organ's triangles. */
export function organMaterial(tint: THREE.ColorRepresentation): THREE.ShaderMaterial {
  return new THREE.ShaderMaterial({
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    side: THREE.DoubleSide,
    polygonOffset: true, // so that edges lie on top
    polygonOffsetFactor: 1,
    polygonOffsetUnits: 1,
    uniforms: {
      tint: { value: new THREE.Color(tint) },
      textured: { value: 0 },
      hasScalar: { value: 0 },
      low: { value: 0 },
      high: { value: 1 },
      shine: { value: 0.22 },
      skinMap: { value: skinTexture() },
      scaleMap: { value: scaleTexture("viridis") },
    },
  });
}

/** A colour scale as a texture of one row. */
export function scaleTexture(scale: ScaleName): THREE.DataTexture {
  const texture = new THREE.DataTexture(colourTable(scale), STEPS, 1, THREE.RGBAFormat);
  texture.minFilter = texture.magFilter = THREE.LinearFilter;
  texture.needsUpdate = true;
  return texture;
}

/** A speckled skin that repeats: three octaves of noise, from an integer hash, so that every browser draws the same. */
function skinTexture(): THREE.DataTexture {
  const bytes = new Uint8Array(4 * TEXTURE_SIZE * TEXTURE_SIZE);
  for (let y = 0; y < TEXTURE_SIZE; y++) {
    for (let x = 0; x < TEXTURE_SIZE; x++) {
      let value = 0;
      for (const [cells, weight] of [[4, 0.5], [8, 0.3], [16, 0.2]] as const) value += weight * noise(x, y, cells);
      const grey = Math.round(255 * value);
      bytes.set([grey, grey, grey, 255], 4 * (y * TEXTURE_SIZE + x));
    }
  }
  const texture = new THREE.DataTexture(bytes, TEXTURE_SIZE, TEXTURE_SIZE, THREE.RGBAFormat);
  texture.wrapS = texture.wrapT = THREE.RepeatWrapping;
  texture.magFilter = THREE.LinearFilter;
  texture.minFilter = THREE.LinearMipmapLinearFilter;
  texture.generateMipmaps = true;
  texture.needsUpdate = true;
  return texture;
}

// Smooth noise in [0, 1] on a grid of cells x cells that repeats.
function noise(x: number, y: number, cells: number): number {
  const [u, v] = [(x / TEXTURE_SIZE) * cells, (y / TEXTURE_SIZE) * cells];
  const [i, j] = [Math.floor(u), Math.floor(v)];
  const smooth = (t: number) => t * t * (3 - 2 * t);
  const [s, t] = [smooth(u - i), smooth(v - j)];
  const corner = (a: number, b: number) => hash(((i + a) % cells) + cells * ((j + b) % cells) + 1009 * cells);
  return (1 - t) * ((1 - s) * corner(0, 0) + s * corner(1, 0)) + t * ((1 - s) * corner(0, 1) + s * corner(1, 1));
}

function hash(value: number): number {
  let h = Math.imul(value ^ 0x9e3779b9, 0x85ebca6b);
  h = Math.imul(h ^ (h >>> 13), 0xc2b2ae35);
  return ((h ^ (h >>> 16)) >>> 0) / 0xffffffff;
}
