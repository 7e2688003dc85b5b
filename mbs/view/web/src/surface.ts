// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// A surface, and the shapes on its vertices: u(v) = sum_k weight_k scale_k q_k(v), summed on the GPU from a texture.
import * as THREE from 'three';
import { readF4, readI4, readU2 } from './data';
import { predict, unpack, type Predictions } from './predict';
import { SectionForces, type SectionsHeader } from './section_forces';
import { textureWidth } from './shaders';

export interface SurfaceHeader {
  key: string; // blocks are named key/vertices, key/triangles, ...
  vertices: number;
  triangles: number;
  edges: number;
  levels?: number; // steps of a shape up to its largest displacement
  stress?: number; // components of the stress of each shape: 0, 1 (von Mises) or 6
  shapes: { scale: number; stress?: number }[]; // shape j is block key/shape/j, its stress key/stress/j
  sections?: SectionsHeader; // of beams: section forces of shape j are block key/section/j
}

/** A stack of layers with four 16-bit numbers for each vertex: what three uploads as it is. */
function layered(vertices: number, layers: number): THREE.DataArrayTexture {
  const height = Math.max(1, Math.ceil(vertices / textureWidth));
  const texture = new THREE.DataArrayTexture(
    new Int16Array(4 * textureWidth * height * layers) as never, textureWidth, height, layers);
  texture.format = THREE.RGBAIntegerFormat;
  texture.type = THREE.ShortType;
  texture.internalFormat = 'RGBA16I' as never;
  texture.minFilter = texture.magFilter = THREE.NearestFilter;
  texture.generateMipmaps = false;
  texture.needsUpdate = true;
  return texture;
}

export class Surface {
  readonly box = new THREE.Box3();
  readonly size: number; // diagonal of the box [m]
  /** Vertices drawn: corners are split at feature edges and interfaces; `source` is the number of the vertex. */
  source!: Float32Array;
  normals!: Float32Array;
  paint!: Float32Array; // 1 + number of the interface, or 0
  index!: Uint32Array;
  readonly texture: THREE.DataArrayTexture;
  readonly stress: THREE.DataArrayTexture | null;
  readonly stressLayers: number;
  readonly sections: SectionForces | null;
  private readonly q: (Int16Array | null)[];
  private readonly loading = new Map<number, Promise<void>>();
  private predictions: Predictions | null = null;

  private constructor(
    readonly header: SurfaceHeader, readonly vertices: Float32Array, readonly triangles: Int32Array,
    private readonly parent: Int32Array, readonly edges: Int32Array, triangleInterface: Int32Array,
  ) {
    this.box.setFromArray(vertices);
    this.size = this.box.getSize(new THREE.Vector3()).length() || 1;
    this.split(triangleInterface);
    this.q = header.shapes.map(() => null);
    this.sections = header.sections ? new SectionForces(header.sections, header.key) : null;
    this.texture = layered(header.vertices, Math.max(1, header.shapes.length));
    // WebGL 2 promises 256 layers and no more.
    this.stressLayers = header.stress === 6 ? 2 : header.stress === 1 ? 1 : 0;
    if (this.stressLayers * header.shapes.length > 256) this.stressLayers = 0;
    this.stress = this.stressLayers ? layered(header.vertices, this.stressLayers * Math.max(1, header.shapes.length)) : null;
  }

  static async read(header: SurfaceHeader): Promise<Surface> {
    const k = header.key;
    const [vertices, triangles, parent, edges, painted] = await Promise.all([
      readF4(`${k}/vertices`), readI4(`${k}/triangles`), readI4(`${k}/parent`), readI4(`${k}/edges`),
      readI4(`${k}/interface`),
    ]);
    return new Surface(header, vertices, triangles, parent, edges, painted);
  }

  /** Decodes shape j on first use and hands it to the GPU. */
  load(j: number): Promise<void> {
    let promise = this.loading.get(j);
    if (!promise) {
      promise = this.decode(j);
      this.loading.set(j, promise);
    }
    return promise;
  }

  isLoaded(j: number): boolean {
    return this.q[j] !== null;
  }

  private async decode(j: number): Promise<void> {
    const { key, vertices: n } = this.header;
    const p = (this.predictions ??= predict(this.triangles, this.parent, n));
    const layer = 4 * textureWidth * this.texture.image.height;
    const part = (texture: THREE.DataArrayTexture, i: number) =>
      (texture.image.data as unknown as Int16Array).subarray(i * layer, (i + 1) * layer);
    const rest = await readU2(`${key}/shape/${j}`);
    const q = part(this.texture, j);
    for (let axis = 0; axis < 3; ++axis) unpack(rest, axis, p, q, 4, axis);
    this.texture.addLayerUpdate(j);
    this.texture.needsUpdate = true;
    if (this.stress) {
      const stress = await readU2(`${key}/stress/${j}`);
      for (let c = 0; c < this.header.stress!; ++c) {
        unpack(stress, c, p, part(this.stress, this.stressLayers * j + Math.floor(c / 3)), 4, c % 3);
      }
      for (let i = 0; i < this.stressLayers; ++i) this.stress.addLayerUpdate(this.stressLayers * j + i);
      this.stress.needsUpdate = true;
    }
    this.q[j] = q;
  }

  /** Von Mises stress at a vertex [Pa] for weights of the shapes, from the page's own data. */
  vonMises(vertex: number, weights: ArrayLike<number>): number {
    if (!this.stress) return 0;
    const data = this.stress.image.data as unknown as Int16Array;
    const layer = 4 * textureWidth * this.texture.image.height;
    const sigma = [0, 0, 0, 0, 0, 0];
    for (let j = 0; j < this.q.length; ++j) {
      const w = weights[j];
      if (!this.q[j] || !w) continue;
      const s = w * (this.header.shapes[j].stress ?? 0);
      for (let c = 0; c < this.header.stress!; ++c) {
        sigma[c] += s * data[(this.stressLayers * j + Math.floor(c / 3)) * layer + 4 * vertex + (c % 3)];
      }
    }
    if (this.stressLayers === 1) return Math.abs(sigma[0]);
    const [xx, yy, zz, xy, yz, zx] = sigma;
    return Math.sqrt(((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * (xy * xy + yz * yz + zx * zx));
  }

  /** The largest one, over every `step`-th vertex [Pa]. */
  largestStress(weights: ArrayLike<number>, step = 1): number {
    let most = 0;
    for (let v = 0; v < this.header.vertices && this.stress; v += step) most = Math.max(most, this.vonMises(v, weights));
    return most;
  }

  /** Displacement of a vertex [m] for weights of the shapes, from the page's own data. */
  displacement(vertex: number, weights: ArrayLike<number>, out = new THREE.Vector3()): THREE.Vector3 {
    out.set(0, 0, 0);
    for (let j = 0; j < this.q.length; ++j) {
      const q = this.q[j];
      const w = weights[j];
      if (!q || !w) continue;
      const s = w * this.header.shapes[j].scale;
      out.x += s * q[4 * vertex];
      out.y += s * q[4 * vertex + 1];
      out.z += s * q[4 * vertex + 2];
    }
    return out;
  }

  position(vertex: number, out = new THREE.Vector3()): THREE.Vector3 {
    return out.fromArray(this.vertices, 3 * vertex);
  }

  /** Largest displacement of shape j for weight 1 [m]. */
  largest(j: number): number {
    const q = this.q[j];
    if (!q) return 0;
    let most = 0;
    for (let i = 0; i < 4 * this.header.vertices; i += 4) {
      most = Math.max(most, q[i] * q[i] + q[i + 1] * q[i + 1] + q[i + 2] * q[i + 2]);
    }
    return Math.sqrt(most) * this.header.shapes[j].scale;
  }

  /** Smooth normals inside a face, sharp ones across feature edges; corners of different interfaces are apart. */
  private split(triangleInterface: Int32Array): void {
    const { triangles, vertices } = this;
    const n = this.header.vertices;
    const n_t = triangles.length / 3;
    const sharp = new Set<number>();
    for (let i = 0; i < this.edges.length; i += 2) {
      const a = this.edges[i];
      const b = this.edges[i + 1];
      sharp.add(Math.min(a, b) * n + Math.max(a, b));
    }
    // Corners (3 per triangle) are joined across every shared edge that is not sharp: union-find.
    const root = new Int32Array(3 * n_t);
    for (let i = 0; i < root.length; ++i) root[i] = i;
    const find = (i: number): number => {
      while (root[i] !== i) {
        root[i] = root[root[i]];
        i = root[i];
      }
      return i;
    };
    const seen = new Map<number, number>();
    for (let t = 0; t < n_t; ++t) {
      for (let c = 0; c < 3; ++c) {
        const i = 3 * t + c;
        const j = 3 * t + ((c + 1) % 3);
        const a = triangles[i];
        const b = triangles[j];
        const key = Math.min(a, b) * n + Math.max(a, b);
        if (sharp.has(key)) continue;
        const other = seen.get(key);
        if (other === undefined) {
          seen.set(key, a < b ? i * 3 * n_t + j : j * 3 * n_t + i);
          continue;
        }
        const low = Math.floor(other / (3 * n_t));
        const high = other % (3 * n_t);
        const tOther = Math.floor(low / 3);
        if ((triangleInterface[t] ?? -1) !== (triangleInterface[tOther] ?? -1)) continue;
        const [mine_low, mine_high] = a < b ? [i, j] : [j, i];
        root[find(mine_low)] = find(low);
        root[find(mine_high)] = find(high);
      }
    }
    const place = new Int32Array(3 * n_t).fill(-1);
    const source: number[] = [];
    const paint: number[] = [];
    this.index = new Uint32Array(3 * n_t);
    for (let i = 0; i < 3 * n_t; ++i) {
      const r = find(i);
      if (place[r] < 0) {
        place[r] = source.length;
        source.push(triangles[i]);
        paint.push((triangleInterface[Math.floor(i / 3)] ?? -1) + 1);
      }
      this.index[i] = place[r];
    }
    this.source = Float32Array.from(source);
    this.paint = Float32Array.from(paint);
    this.normals = new Float32Array(3 * source.length);
    const a = new THREE.Vector3();
    const b = new THREE.Vector3();
    const c = new THREE.Vector3();
    for (let t = 0; t < n_t; ++t) {
      a.fromArray(vertices, 3 * triangles[3 * t]);
      b.fromArray(vertices, 3 * triangles[3 * t + 1]);
      c.fromArray(vertices, 3 * triangles[3 * t + 2]);
      b.sub(a);
      c.sub(a);
      b.cross(c); // weighted by area
      for (let k = 0; k < 3; ++k) {
        const at = 3 * this.index[3 * t + k];
        this.normals[at] += b.x;
        this.normals[at + 1] += b.y;
        this.normals[at + 2] += b.z;
      }
    }
  }
}
