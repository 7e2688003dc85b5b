// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// The pressures of surfaces in contact, where a run stored them at every node (NAME.pressure_at_VERTEX): coloured over the faces of
// the body that touches, and seen through what it touches.
import * as THREE from 'three';
import { scaleColor } from './colormap';
import type { DeformedBody } from './deformed_body';
import type { Connection, Run } from './motion_data';

interface Patch {
  name: string;
  on: DeformedBody;
  vertices: number[];
  quantities: string[];
  values: Float64Array[]; // of each vertex over the stored rows
  mesh: THREE.Mesh;
}

export class ContactPressures {
  readonly group = new THREE.Group();
  largest = 0; // [Pa], over the run
  range = 0; // [Pa], at the end of the colours
  private readonly patches: Patch[] = [];

  constructor(private readonly run: Run, connections: Connection[], body: (name?: string) => DeformedBody | null | undefined) {
    for (const { name, body_2 } of connections) {
      const on = body(body_2);
      if (!on) continue;
      const stem = `${name}.pressure_at_`;
      const quantities = run.header.quantities.map((q) => q.name).filter((n) => n.startsWith(stem));
      if (!quantities.length) continue;
      const vertices = quantities.map((n) => Number(n.slice(stem.length)));
      const place = new Map(vertices.map((v, i) => [v, i]));
      const { triangles } = on.surface;
      const index: number[] = [];
      for (let t = 0; t < triangles.length; t += 3) {
        const corners = [0, 1, 2].map((k) => place.get(triangles[t + k]));
        if (corners.every((c) => c !== undefined)) index.push(...(corners as number[]));
      }
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(3 * vertices.length), 3));
      geometry.setAttribute('color', new THREE.BufferAttribute(new Float32Array(4 * vertices.length), 4));
      geometry.setIndex(index);
      // What touches hides the place: the pressure is drawn over it.
      const mesh = new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({
        vertexColors: true, transparent: true, depthTest: false, depthWrite: false, side: THREE.DoubleSide }));
      mesh.frustumCulled = false;
      mesh.renderOrder = 3;
      this.group.add(mesh);
      this.patches.push({ name, on, vertices, quantities, values: [], mesh });
    }
  }

  get count(): number {
    return this.patches.length;
  }

  async load(): Promise<void> {
    for (const patch of this.patches) {
      patch.values = await Promise.all(patch.quantities.map((n) => this.run.quantity(n)!));
      for (const values of patch.values) for (const p of values) this.largest = Math.max(this.largest, p);
    }
    this.range = this.largest;
  }

  private at(values: Float64Array, row: number, part: number): number {
    return values[row] + (part > 0 ? part * (values[row + 1] - values[row]) : 0);
  }

  /** Pressure [Pa] at a vertex of what touches; null where it was not stored. */
  pressure(name: string, vertex: number, row: number, part: number): number | null {
    const patch = this.patches.find((p) => p.name === name);
    const i = patch ? patch.vertices.indexOf(vertex) : -1;
    return patch && i >= 0 ? this.at(patch.values[i], row, part) : null;
  }

  /** After the bodies are placed: row and fraction of the stored times. */
  setTime(row: number, part: number): void {
    if (!this.group.visible || !(this.range > 0)) return;
    const place = new THREE.Vector3();
    for (const { on, vertices, values, mesh } of this.patches) {
      const position = mesh.geometry.getAttribute('position') as THREE.BufferAttribute;
      const color = mesh.geometry.getAttribute('color') as THREE.BufferAttribute;
      let touches = false;
      vertices.forEach((_, i) => {
        const p = this.at(values[i], row, part);
        touches ||= p > 0;
        const [r, g, b] = scaleColor('pressure', p / this.range);
        color.setXYZW(i, r, g, b, p > 0 ? 1 : 0);
      });
      mesh.visible = touches;
      if (!touches) continue;
      vertices.forEach((v, i) => {
        on.drawn(v, place);
        position.setXYZ(i, place.x, place.y, place.z);
      });
      position.needsUpdate = color.needsUpdate = true;
    }
  }
}
