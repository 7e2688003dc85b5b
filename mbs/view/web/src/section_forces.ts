// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Section forces of beams: summed from the shapes' own, as displacements are.
import * as THREE from 'three';
import { readF4 } from './data';

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
