// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Section forces of beams: summed from the shapes' own, as displacements are, and drawn as diagrams along the members.
import * as THREE from 'three';
import { readF4 } from './data';
import type { DeformedBody } from './deformed_body';

export interface SectionsHeader {
  members: string[];
  member: number[]; // of each place
  positions: number[][]; // [m], in the body's frame
  axes: number[][]; // R_BS row by row
}

/** What acts on the section that looks along +x of its member; the diagram stands out along `side` of the axes. */
export const resultants = [
  { name: 'N', unit: 'N', side: 2 }, { name: 'V_y', unit: 'N', side: 1 }, { name: 'V_z', unit: 'N', side: 2 },
  { name: 'T', unit: 'N*m', side: 2 }, { name: 'M_y', unit: 'N*m', side: 2 }, { name: 'M_z', unit: 'N*m', side: 1 },
];

export class SectionForces {
  readonly n: number; // places
  private readonly shapes: (Float32Array | undefined)[] = [];
  private readonly loading = new Map<number, Promise<Float32Array>>(); // several runs share the shapes

  constructor(readonly header: SectionsHeader, private readonly key: string) {
    this.n = header.member.length;
  }

  async load(first: number, count: number): Promise<void> {
    await Promise.all(Array.from({ length: count }, async (_, j) => {
      const shape = first + j;
      if (!this.loading.has(shape)) this.loading.set(shape, readF4(`${this.key}/section/${shape}`));
      this.shapes[shape] = await this.loading.get(shape)!;
    }));
  }

  /** Resultant c at place p for weights of the shapes. */
  value(p: number, c: number, weights: ArrayLike<number>): number {
    let sum = 0;
    for (let j = 0; j < this.shapes.length; ++j) {
      const s = this.shapes[j];
      if (s && weights[j]) sum += weights[j] * s[6 * p + c];
    }
    return sum;
  }

  position(p: number, out = new THREE.Vector3()): THREE.Vector3 {
    return out.fromArray(this.header.positions[p]);
  }

  /** Distance of a place from the first one of its member [m]. */
  along(p: number): number {
    const first = this.header.member.indexOf(this.header.member[p]);
    return this.position(p).distanceTo(this.position(first));
  }
}

/** The diagram of one resultant on one body: a ribbon beside each member, as high as the force is large. */
export class SectionDiagram {
  readonly group = new THREE.Group();
  private readonly ribbon: THREE.Mesh;
  private readonly line: THREE.LineSegments;
  private readonly nearest: Int32Array; // vertex of the surface beside each place: it moves with the deformation

  constructor(private readonly body: DeformedBody, private readonly forces: SectionForces) {
    const { n } = forces;
    const { surface } = body;
    this.nearest = new Int32Array(n).fill(-1);
    const v = new THREE.Vector3();
    for (let p = 0; p < n; ++p) {
      const at = forces.position(p);
      let least = Infinity;
      for (let i = 0; i < surface.header.vertices; ++i) {
        const d = surface.position(i, v).distanceToSquared(at);
        if (d < least) [least, this.nearest[p]] = [d, i];
      }
    }
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(6 * n), 3));
    const faces: number[] = [];
    const lines: number[] = [];
    for (let p = 0; p < n; ++p) {
      lines.push(2 * p, 2 * p + 1);
      if (p + 1 === n || forces.header.member[p + 1] !== forces.header.member[p]) continue;
      faces.push(2 * p, 2 * p + 1, 2 * p + 3, 2 * p, 2 * p + 3, 2 * p + 2);
      lines.push(2 * p + 1, 2 * p + 3);
    }
    geometry.setIndex(faces);
    const outline = new THREE.BufferGeometry();
    outline.setAttribute('position', geometry.getAttribute('position'));
    outline.setIndex(lines);
    this.ribbon = new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({ side: THREE.DoubleSide, transparent: true, opacity: 0.35,
                                                                         depthWrite: false }));
    this.line = new THREE.LineSegments(outline, new THREE.LineBasicMaterial());
    for (const part of [this.ribbon, this.line]) {
      part.frustumCulled = false;
      part.renderOrder = 3;
    }
    this.group.add(this.ribbon, this.line);
    this.group.visible = false;
  }

  set color(color: THREE.Color) {
    (this.ribbon.material as THREE.MeshBasicMaterial).color.copy(color);
    (this.line.material as THREE.LineBasicMaterial).color.copy(color);
  }

  /** Draws resultant c with `height` metres for each newton (or newton metre). */
  update(c: number, height: number): void {
    const position = this.ribbon.geometry.getAttribute('position') as THREE.BufferAttribute;
    const u = new THREE.Vector3();
    const { axes } = this.forces.header;
    for (let p = 0; p < this.forces.n; ++p) {
      const foot = this.body.drawnOffset(this.nearest[p], u)
        .add(this.forces.position(p));
      const h = height * this.forces.value(p, c, this.body.weights);
      const { side } = resultants[c];
      position.setXYZ(2 * p, foot.x, foot.y, foot.z);
      position.setXYZ(2 * p + 1, foot.x + h * axes[p][side], foot.y + h * axes[p][3 + side], foot.z + h * axes[p][6 + side]);
    }
    position.needsUpdate = true;
  }
}
