// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Forces as arrows, where a run stored their components: NAME.force_x, _y, _z (joints, bushings) or NAME.x, .y, .z
// (applied forces), on body 2 at its point, in the axes that the connection names.
import * as THREE from 'three';
import type { PathLine } from './contact_pictures';
import type { Connection, Run } from './motion_data';

interface Arrow {
  name: string;
  group: THREE.Group;
  values: Float64Array[]; // x, y, z over the stored rows
  names: string[];
  on: THREE.Object3D;
  point: THREE.Vector3;
  path: PathLine | null; // its force stands where NAME.place is on this
  place: Float64Array | null;
  axes: THREE.Object3D | null; // null: the world's
  turn: THREE.Quaternion;
}

const forceUnits = ['N'];

export class ForceArrows {
  readonly group = new THREE.Group();
  largest = 0; // [N], over the run
  private readonly arrows: Arrow[] = [];
  private readonly turned = new THREE.Quaternion();

  constructor(private readonly run: Run, connections: Connection[], body: (name?: string) => THREE.Object3D | undefined,
              material: THREE.Material, private readonly length: number, thickness: number, path: (name: string) => PathLine | undefined) {
    for (const connection of connections) {
      const on = body(connection.body_2);
      if (!on || !connection.p_2 || !connection.axes) continue;
      const names = ['force_', ''].map((stem) => ['x', 'y', 'z'].map((c) => `${connection.name}.${stem}${c}`))
        .find((list) => list.every((n) => {
          const j = run.quantityNumber(n);
          return j >= 0 && forceUnits.includes(run.header.quantities[j].unit);
        }));
      // Of a surface the place of the resultant is not known, of a load on a path it is where the place was stored.
      if (!names || connection.surface || (connection.path && run.quantityNumber(`${connection.name}.place`) < 0)) continue;
      const [w, x, y, z] = connection.axes.rotation;
      const group = new THREE.Group();
      // A shaft of length 1 along y, stretched with the force, and a head that keeps its shape.
      const shaft = new THREE.Mesh(new THREE.CylinderGeometry(thickness, thickness, 1, 16).translate(0, 0.5, 0), material);
      const head = new THREE.Mesh(new THREE.ConeGeometry(2.6 * thickness, 7 * thickness, 20), material);
      for (const mesh of [shaft, head]) mesh.renderOrder = 5;
      group.add(shaft, head);
      group.frustumCulled = false;
      this.group.add(group);
      this.arrows.push({ name: connection.name, group, names, values: [], on, point: new THREE.Vector3(...connection.p_2),
                         path: path(connection.name) ?? null, place: null,
                         axes: body(connection.axes.body) ?? null, turn: new THREE.Quaternion(x, y, z, w) });
    }
  }

  get count(): number {
    return this.arrows.length;
  }

  async load(): Promise<void> {
    for (const arrow of this.arrows) {
      arrow.values = await Promise.all(arrow.names.map((n) => this.run.quantity(n)!));
      if (arrow.path) arrow.place = (await this.run.quantity(`${arrow.name}.place`)) ?? null;
      const [x, y, z] = arrow.values;
      for (let i = 0; i < x.length; ++i) this.largest = Math.max(this.largest, Math.hypot(x[i], y[i], z[i]));
    }
  }

  /** Force on body 2 of a connection at a time, in W [N]; null where it was not stored. */
  force(name: string, at: number, part: number): THREE.Vector3 | null {
    const arrow = this.arrows.find((a) => a.name === name);
    return arrow ? this.vector(arrow, at, part) : null;
  }

  private vector(arrow: Arrow, at: number, part: number): THREE.Vector3 {
    const mix = (v: Float64Array) => v[at] + (part > 0 ? part * (v[at + 1] - v[at]) : 0);
    const f = new THREE.Vector3(...arrow.values.map(mix)).applyQuaternion(arrow.turn);
    if (arrow.axes) f.applyQuaternion(arrow.axes.getWorldQuaternion(this.turned));
    return f;
  }

  /** After the bodies are placed: row and fraction of the stored times. */
  setTime(at: number, part: number): void {
    for (const arrow of this.arrows) {
      const f = this.vector(arrow, at, part);
      const place = arrow.place ? arrow.place[at] + (part > 0 ? part * (arrow.place[at + 1] - arrow.place[at]) : 0) : 0;
      const long = this.largest > 0 ? (this.length * f.length()) / this.largest : 0;
      // Forces that would be no longer than a dot are left out.
      arrow.group.visible = long > 0.01 * this.length;
      if (!arrow.group.visible) continue;
      if (arrow.path) arrow.group.position.copy(arrow.path.at(place));
      else arrow.group.position.copy(arrow.point).applyMatrix4(arrow.on.matrixWorld);
      arrow.group.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), f.normalize());
      arrow.group.children[0].scale.set(1, long, 1);
      arrow.group.children[1].position.set(0, long, 0);
    }
  }
}
