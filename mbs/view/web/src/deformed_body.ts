// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// A body as it is drawn: faces, edges and outline of a surface, moved and coloured on the graphics card.
import * as THREE from 'three';
import { ghostPush } from './primitives';
import { lineFragment, lineVertex, surfaceFragment, surfaceVertex } from './shaders';
import type { InterfaceFrame } from './motion_data';
import type { Surface } from './surface';

export interface Look {
  color: THREE.Color;
  accent: THREE.Color;
  edge: THREE.Color;
  outline: THREE.Color;
  opacity: number;
}

/** The frame of an interface; its modal coordinates are the weights from `first` on. */
export interface Reference { frame: InterfaceFrame; first: number }

/** One drawn body: a surface with its own weights; several may share the surface's shapes. */
export class DeformedBody {
  readonly group = new THREE.Group();
  readonly weights: Float32Array;
  readonly mesh: THREE.Mesh;
  readonly edges: THREE.LineSegments;
  readonly outline: THREE.LineSegments;
  readonly marker: THREE.Points;
  private readonly table: THREE.DataTexture;
  private reference_: Reference | null = null;
  /** Where deformation is seen from instead, at this time and at the start; null: from the reference. */
  private seen: { now: THREE.Matrix4; then: THREE.Matrix4 } | null = null;
  private readonly shared: Record<string, THREE.IUniform>;

  /** `given`: a number for each vertex of the surface, coloured as field 6. */
  constructor(readonly surface: Surface, scale: THREE.Texture, given: Float32Array | null = null) {
    const n = Math.max(1, surface.header.shapes.length);
    this.weights = new Float32Array(surface.header.shapes.length);
    this.table = new THREE.DataTexture(new Float32Array(4 * n), n, 1, THREE.RGBAFormat, THREE.FloatType);
    this.shared = {
      uShapes: { value: surface.texture }, uWeights: { value: this.table }, uCount: { value: 0 },
      uStress: { value: surface.stress ?? surface.texture }, uStressLayers: { value: surface.stressLayers },
      uMagnify: { value: 1 }, uRange: { value: new THREE.Vector2(0, 1) }, uScale: { value: scale },
      uCut: { value: new THREE.Vector4(0, 0, 0, 0) },
      uShift: { value: new THREE.Vector3() }, uTurn: { value: new THREE.Vector3() },
      uPivot: { value: new THREE.Vector3() }, uSeen: { value: 0 },
      uNow: { value: new THREE.Matrix4() }, uThen: { value: new THREE.Matrix4() },
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
    const number = new Float32Array(drawn);
    if (given) for (let i = 0; i < drawn; ++i) number[i] = given[surface.source[i]];
    faces.setAttribute('given', new THREE.BufferAttribute(number, 1));
    faces.setIndex(new THREE.BufferAttribute(surface.index, 1));
    this.mesh = new THREE.Mesh(faces, new THREE.ShaderMaterial({
      glslVersion: THREE.GLSL3, vertexShader: surfaceVertex, fragmentShader: surfaceFragment,
      side: THREE.DoubleSide,
      uniforms: uniforms({
        uColor: new THREE.Color(), uAccent: new THREE.Color(), uOpacity: 1, uPaint: 1, uField: 0, uPush: 0,
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
    outline.uniforms.uShift = { value: new THREE.Vector3() };
    outline.uniforms.uTurn = { value: new THREE.Vector3() };
    this.outline = new THREE.LineSegments(lines, outline);
    const point = new THREE.BufferGeometry();
    point.setAttribute('position', new THREE.BufferAttribute(new Float32Array(3), 3));
    point.setAttribute('vertex', new THREE.BufferAttribute(new Float32Array(1), 1));
    const dot = lineMaterial({ uPoint: 9 });
    dot.depthTest = false;
    this.marker = new THREE.Points(point, dot);
    this.marker.visible = false;
    this.marker.renderOrder = 8; // over glyphs, arrows and triads
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
    const motion = this.motionOf(this.weights);
    (this.shared.uShift.value as THREE.Vector3).set(motion[0], motion[1], motion[2]);
    (this.shared.uTurn.value as THREE.Vector3).set(motion[3], motion[4], motion[5]);
  }

  /** The frame from which deformation counts, for colours and for what is magnified; null: the body's own. */
  set reference(value: Reference | null) {
    this.reference_ = value;
    (this.shared.uPivot.value as THREE.Vector3).fromArray(value?.frame.point ?? [0, 0, 0]);
    this.update();
  }

  /** Colours by the way from `then` to `now` of the body's frame, both seen from another body; null: by deformation. */
  see(from: { now: THREE.Matrix4; then: THREE.Matrix4 } | null): void {
    this.seen = from;
    this.shared.uSeen.value = from ? 1 : 0;
    if (!from) return;
    (this.shared.uNow.value as THREE.Matrix4).copy(from.now);
    (this.shared.uThen.value as THREE.Matrix4).copy(from.then);
  }

  /** Displacement [m] and rotation [rad] of the reference, in the body's frame. */
  private motionOf(weights: ArrayLike<number>): number[] {
    const motion = [0, 0, 0, 0, 0, 0];
    this.reference_?.frame.motion.forEach((column, j) => {
      const w = weights[this.reference_!.first + j];
      for (let k = 0; k < 6; ++k) motion[k] += w * column[k];
    });
    return motion;
  }

  /** What moves a vertex with the reference. */
  private carried(vertex: number, weights: ArrayLike<number>): THREE.Vector3 {
    const motion = this.motionOf(weights);
    const arm = this.surface.position(vertex, new THREE.Vector3());
    if (this.reference_) arm.sub(new THREE.Vector3(...this.reference_.frame.point));
    return new THREE.Vector3(motion[3], motion[4], motion[5]).cross(arm)
      .add(new THREE.Vector3(motion[0], motion[1], motion[2]));
  }

  /** The displacement that is coloured [m], from the page's own data. */
  shown(vertex: number, weights: ArrayLike<number> = this.weights, out = new THREE.Vector3()): THREE.Vector3 {
    this.surface.displacement(vertex, weights, out);
    if (!this.seen) return out.sub(this.carried(vertex, weights));
    const place = this.surface.position(vertex, new THREE.Vector3());
    return out.add(place).applyMatrix4(this.seen.now).sub(place.applyMatrix4(this.seen.then));
  }

  /** From the undeformed to the drawn place of a vertex [m], in the body's frame. */
  drawnOffset(vertex: number, out = new THREE.Vector3()): THREE.Vector3 {
    const carried = this.carried(vertex, this.weights);
    return this.surface.displacement(vertex, this.weights, out).sub(carried).multiplyScalar(this.magnify).add(carried);
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

  /** What is coloured: 0 nothing, 1 magnitude, 2..4 a component [m], 5 von Mises stress [Pa], 6 what was given; between the
   *  two values. */
  setField(field: number, low: number, high: number): void {
    this.uniform(this.mesh, 'uField').value = field;
    (this.shared.uRange.value as THREE.Vector2).set(low, high);
    // A body without faces (a beam) shows the colours on its lines.
    if (this.surface.index.length === 0) this.uniform(this.edges, 'uField').value = field === 6 ? 0 : field;
  }

  setLook(look: Look): void {
    (this.uniform(this.mesh, 'uColor').value as THREE.Color).copy(look.color);
    (this.uniform(this.mesh, 'uAccent').value as THREE.Color).copy(look.accent);
    this.uniform(this.mesh, 'uOpacity').value = look.opacity;
    const material = this.mesh.material as THREE.ShaderMaterial;
    material.transparent = look.opacity < 1;
    material.depthWrite = look.opacity >= 1;
    material.uniforms.uPush.value = look.opacity < 1 ? ghostPush : 0;
    this.uniform(this.edges, 'uPull').value = look.opacity < 1 ? -ghostPush : 0.0015;
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
    this.drawnOffset(vertex, out);
    out.add(this.surface.position(vertex, new THREE.Vector3()));
    this.group.updateMatrixWorld();
    return out.applyMatrix4(this.group.matrixWorld);
  }
}
