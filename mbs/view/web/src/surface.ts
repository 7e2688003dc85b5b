// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// A surface, and the shapes on its vertices: u(v) = sum_k weight_k scale_k q_k(v), summed on the GPU from a texture.
import * as THREE from 'three';
import { setBehind } from './primitives';
import { readF4, readI4, readU2 } from './data';
import { predict, unpack, type Predictions } from './predict';
import { lineFragment, lineVertex, surfaceFragment, surfaceVertex, textureWidth } from './shaders';

export interface SurfaceHeader {
  key: string; // blocks are named key/vertices, key/triangles, ...
  vertices: number;
  triangles: number;
  edges: number;
  stress?: number; // components of the stress of each shape: 0, 1 (von Mises) or 6
  shapes: { scale: number; stress?: number }[]; // shape j is block key/shape/j, its stress key/stress/j
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

export interface Look {
  color: THREE.Color;
  accent: THREE.Color;
  edge: THREE.Color;
  outline: THREE.Color;
  opacity: number;
}

/** One drawn body: a surface with its own weights; several may share the surface's shapes. */
export class DeformedBody {
  readonly group = new THREE.Group();
  readonly weights: Float32Array;
  readonly mesh: THREE.Mesh;
  readonly edges: THREE.LineSegments;
  readonly outline: THREE.LineSegments;
  readonly marker: THREE.Points;
  private readonly table: THREE.DataTexture;
  private readonly shared: Record<string, THREE.IUniform>;

  constructor(readonly surface: Surface, scale: THREE.Texture) {
    const n = Math.max(1, surface.header.shapes.length);
    this.weights = new Float32Array(surface.header.shapes.length);
    this.table = new THREE.DataTexture(new Float32Array(4 * n), n, 1, THREE.RGBAFormat, THREE.FloatType);
    this.shared = {
      uShapes: { value: surface.texture }, uWeights: { value: this.table }, uCount: { value: 0 },
      uStress: { value: surface.stress ?? surface.texture }, uStressLayers: { value: surface.stressLayers },
      uMagnify: { value: 1 }, uRange: { value: new THREE.Vector2(0, 1) }, uScale: { value: scale },
      uCut: { value: new THREE.Vector4(0, 0, 0, 0) },
    };
    const uniforms = (own: Record<string, unknown>) => ({
      ...this.shared, ...Object.fromEntries(Object.entries(own).map(([k, v]) => [k, { value: v }])),
    });

    const faces = new THREE.BufferGeometry();
    const drawn = surface.source.length;
    const position = new Float32Array(3 * drawn);
    for (let i = 0; i < drawn; ++i) {
      for (let a = 0; a < 3; ++a) position[3 * i + a] = surface.vertices[3 * surface.source[i] + a];
    }
    faces.setAttribute('position', new THREE.BufferAttribute(position, 3));
    faces.setAttribute('normal', new THREE.BufferAttribute(surface.normals, 3));
    faces.setAttribute('vertex', new THREE.BufferAttribute(surface.source, 1));
    faces.setAttribute('paint', new THREE.BufferAttribute(surface.paint, 1));
    faces.setIndex(new THREE.BufferAttribute(surface.index, 1));
    this.mesh = new THREE.Mesh(faces, new THREE.ShaderMaterial({
      glslVersion: THREE.GLSL3, vertexShader: surfaceVertex, fragmentShader: surfaceFragment,
      side: THREE.DoubleSide,
      uniforms: uniforms({
        uColor: new THREE.Color(), uAccent: new THREE.Color(), uOpacity: 1, uPaint: 1, uField: 0,
      }),
    }));

    const lines = new THREE.BufferGeometry();
    const ends = new Float32Array(3 * surface.edges.length);
    for (let i = 0; i < surface.edges.length; ++i) {
      for (let a = 0; a < 3; ++a) ends[3 * i + a] = surface.vertices[3 * surface.edges[i] + a];
    }
    lines.setAttribute('position', new THREE.BufferAttribute(ends, 3));
    lines.setAttribute('vertex', new THREE.BufferAttribute(Float32Array.from(surface.edges), 1));
    const lineMaterial = (own: Record<string, unknown>) => new THREE.ShaderMaterial({
      glslVersion: THREE.GLSL3, vertexShader: lineVertex, fragmentShader: lineFragment, transparent: true,
      uniforms: uniforms({ uColor: new THREE.Color(), uOpacity: 1, uField: 0, uPull: 0.0015, uPoint: 1, ...own }),
    });
    this.edges = new THREE.LineSegments(lines, lineMaterial({}));
    const outline = lineMaterial({ uPull: 0 });
    outline.uniforms.uCount = { value: 0 };
    this.outline = new THREE.LineSegments(lines, outline);
    const point = new THREE.BufferGeometry();
    point.setAttribute('position', new THREE.BufferAttribute(new Float32Array(3), 3));
    point.setAttribute('vertex', new THREE.BufferAttribute(new Float32Array(1), 1));
    const dot = lineMaterial({ uPoint: 9 });
    dot.depthTest = false;
    this.marker = new THREE.Points(point, dot);
    this.marker.visible = false;
    this.marker.renderOrder = 3;
    this.edges.renderOrder = 1;
    this.group.add(this.mesh, this.edges, this.outline, this.marker);
    // Deformed shapes leave the undeformed box.
    for (const child of this.group.children) child.frustumCulled = false;
  }

  private uniform(of: THREE.Mesh | THREE.LineSegments | THREE.Points, name: string): THREE.IUniform {
    return (of.material as THREE.ShaderMaterial).uniforms[name];
  }

  /** Hands the weights to the GPU; shapes with weight zero or not yet decoded cost nothing. */
  update(): void {
    const data = this.table.image.data as Float32Array;
    let count = 0;
    for (let j = 0; j < this.weights.length; ++j) {
      if (this.weights[j] === 0 || !this.surface.isLoaded(j)) continue;
      data[4 * count] = this.weights[j] * this.surface.header.shapes[j].scale;
      data[4 * count + 1] = j;
      data[4 * count + 2] = this.weights[j] * (this.surface.header.shapes[j].stress ?? 0);
      ++count;
    }
    this.shared.uCount.value = count;
    this.table.needsUpdate = true;
  }

  set magnify(value: number) {
    this.shared.uMagnify.value = value;
  }
  get magnify(): number {
    return this.shared.uMagnify.value as number;
  }

  set cut(plane: THREE.Vector4) {
    (this.shared.uCut.value as THREE.Vector4).copy(plane);
  }

  /** What is coloured: 0 nothing, 1 magnitude, 2..4 a component [m], 5 von Mises stress [Pa]; between the two values. */
  setField(field: number, low: number, high: number): void {
    this.uniform(this.mesh, 'uField').value = field;
    (this.shared.uRange.value as THREE.Vector2).set(low, high);
    // A body without faces (a beam) shows the colours on its lines.
    if (this.surface.index.length === 0) this.uniform(this.edges, 'uField').value = field;
  }

  setLook(look: Look): void {
    (this.uniform(this.mesh, 'uColor').value as THREE.Color).copy(look.color);
    (this.uniform(this.mesh, 'uAccent').value as THREE.Color).copy(look.accent);
    this.uniform(this.mesh, 'uOpacity').value = look.opacity;
    const material = this.mesh.material as THREE.ShaderMaterial;
    material.transparent = look.opacity < 1;
    material.depthWrite = look.opacity >= 1;
    setBehind(material, look.opacity < 1);
    (this.uniform(this.edges, 'uColor').value as THREE.Color).copy(look.edge);
    this.uniform(this.edges, 'uOpacity').value = look.opacity < 1 ? 0.6 : 1;
    (this.uniform(this.outline, 'uColor').value as THREE.Color).copy(look.outline);
    this.uniform(this.outline, 'uOpacity').value = 0.55;
    (this.uniform(this.marker, 'uColor').value as THREE.Color).set(1, 0, 1);
  }

  set paint(amount: number) {
    this.uniform(this.mesh, 'uPaint').value = amount;
  }

  /** Draws a dot on a vertex, moved by the same shader as the surface; -1 takes it away. */
  mark(vertex: number): void {
    this.marker.visible = vertex >= 0;
    if (vertex < 0) return;
    const position = this.marker.geometry.getAttribute('position') as THREE.BufferAttribute;
    const number = this.marker.geometry.getAttribute('vertex') as THREE.BufferAttribute;
    const p = this.surface.position(vertex);
    position.setXYZ(0, p.x, p.y, p.z);
    number.setX(0, vertex);
    position.needsUpdate = number.needsUpdate = true;
  }

  /** Drawn position of a vertex in W, from the page's own data. */
  drawn(vertex: number, out = new THREE.Vector3()): THREE.Vector3 {
    this.surface.displacement(vertex, this.weights, out).multiplyScalar(this.magnify);
    out.add(this.surface.position(vertex, new THREE.Vector3()));
    this.group.updateMatrixWorld();
    return out.applyMatrix4(this.group.matrixWorld);
  }
}
