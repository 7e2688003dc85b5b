// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Section forces of beams, drawn as diagrams along the members.
import * as THREE from 'three';
import type { DeformedBody } from './deformed_body';
import { resultants, type SectionForces } from './section_forces';

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
