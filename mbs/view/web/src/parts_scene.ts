// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Bodies of the page of parts in the scene: their faces, which one is under the pointer, numbers where a face is seen, joints as glyphs.
import * as THREE from 'three';
import { readF4, readI4 } from './data';
import { jointGlyph, recolor, shaded } from './primitives';
import type { Joint, PartsHeader } from './parts_data';
import type { Stage } from './stage';
import { cssColor, h } from './ui';

interface DrawnPart { faces: THREE.BufferGeometry; edges: THREE.BufferGeometry; first: Map<number, [number, number]>; box: THREE.Box3 }
interface DrawnBody { group: THREE.Group; material: THREE.ShaderMaterial; lines: THREE.LineBasicMaterial; ids: THREE.Mesh; box: THREE.Box3 }
export interface Picked { body: number; face: number; joint: number } // -1 where there is none; faces by number

const idMaterial = () => new THREE.ShaderMaterial({
  glslVersion: THREE.GLSL3, side: THREE.DoubleSide, uniforms: { uFirst: { value: 0 } },
  vertexShader: `in float face; out float vFace;
    void main() { vFace = face; gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0); }`,
  fragmentShader: `precision highp float; uniform float uFirst; in float vFace; out vec4 color;
    void main() {
      float id = uFirst + floor(vFace + 0.5) + 1.0;
      color = vec4(mod(id, 256.0), mod(floor(id / 256.0), 256.0), floor(id / 65536.0), 255.0) / 255.0;
    }`,
});

/** A part's geometry: corners are split between faces, so that edges stay sharp. */
async function readPart(key: string, n_faces: number): Promise<DrawnPart> {
  const [vertices, triangles, face, edges] = await Promise.all([
    readF4(`${key}/vertices`), readI4(`${key}/triangles`), readI4(`${key}/face`), readI4(`${key}/edges`)]);
  const order = Array.from(face.keys()).sort((s, t) => face[s] - face[t]);
  const corner = new Map<number, number>();
  const position: number[] = [];
  const faceOf: number[] = [];
  const index: number[] = [];
  const first = new Map<number, [number, number]>();
  for (const t of order) {
    const range = first.get(face[t]) ?? [index.length, 0];
    for (let k = 0; k < 3; ++k) {
      const v = triangles[3 * t + k];
      const name = v * n_faces + face[t];
      let at = corner.get(name);
      if (at === undefined) {
        corner.set(name, (at = faceOf.length));
        position.push(vertices[3 * v], vertices[3 * v + 1], vertices[3 * v + 2]);
        faceOf.push(face[t]);
      }
      index.push(at);
    }
    first.set(face[t], [range[0], range[1] + 3]);
  }
  const faces = new THREE.BufferGeometry();
  faces.setAttribute('position', new THREE.Float32BufferAttribute(position, 3));
  faces.setAttribute('face', new THREE.Float32BufferAttribute(faceOf, 1));
  faces.setIndex(index);
  faces.computeVertexNormals();
  faces.computeBoundingBox();
  const lines = new THREE.BufferGeometry();
  lines.setAttribute('position', new THREE.BufferAttribute(vertices, 3));
  lines.setIndex(Array.from(edges));
  return { faces, edges: lines, first, box: faces.boundingBox! };
}

export class PartsScene {
  readonly group = new THREE.Group();
  readonly bodies: DrawnBody[] = [];
  private readonly ids = new THREE.Scene();
  private readonly firstId: number[] = [];
  private readonly glyphs: { mesh: THREE.Mesh; id: THREE.Mesh; material: THREE.ShaderMaterial; accepted: boolean; isFixed: boolean }[] = [];
  private jointsShown = true;
  private chosen = -1;
  private readonly marked: THREE.Mesh[] = [];
  private readonly numbers = h('div', { class: 'numbers', 'aria-hidden': 'true' });
  private timer = 0;
  private glyphSize = 1;
  readonly box = new THREE.Box3();
  /** Of these bodies every face that is seen has its number. */
  numbered: (body: number) => boolean = () => false;
  faded: (body: number) => boolean = () => false;
  hidden: (body: number) => boolean = () => false;
  private readonly ball = new THREE.Mesh(new THREE.SphereGeometry(1, 24, 16), shaded(new THREE.Color()));

  static async read(header: PartsHeader, stage: Stage): Promise<PartsScene> {
    const parts = await Promise.all(header.parts.map((p) => readPart(p.key, p.faces.length)));
    return new PartsScene(header, stage, parts);
  }

  private constructor(private readonly header: PartsHeader, private readonly stage: Stage, private readonly parts: DrawnPart[]) {
    let id = 0;
    header.bodies.forEach((body) => {
      const part = parts[body.part];
      const material = shaded(new THREE.Color());
      const lines = new THREE.LineBasicMaterial();
      const group = new THREE.Group();
      group.matrixAutoUpdate = false;
      group.add(new THREE.Mesh(part.faces, material), new THREE.LineSegments(part.edges, lines));
      const ids = new THREE.Mesh(part.faces, idMaterial());
      ids.matrixAutoUpdate = false;
      (ids.material as THREE.ShaderMaterial).uniforms.uFirst.value = id;
      this.firstId.push(id);
      id += header.parts[body.part].faces.length;
      this.ids.add(ids);
      this.group.add(group);
      this.bodies.push({ group, material, lines, ids, box: part.box });
    });
    this.firstId.push(id);
    this.ids.background = null;
    stage.scene.add(this.group);
    stage.element.append(this.numbers);
    stage.controls.addEventListener('change', () => this.numberLater());
    new ResizeObserver(() => this.numberLater()).observe(stage.element);
  }

  place(poses: THREE.Matrix4[]): void {
    this.box.makeEmpty();
    this.bodies.forEach((body, i) => {
      for (const object of [body.group, body.ids]) {
        object.matrix.copy(poses[i]);
        object.updateMatrixWorld(true);
      }
      this.box.union(body.box.clone().applyMatrix4(poses[i]));
    });
    this.numberLater();
    this.stage.draw();
  }

  /** One glyph for each joint that is not fixed, at its frame in body A. */
  setJoints(joints: Joint[], home: THREE.Matrix4[], size: number): void {
    this.glyphSize = 0.018 * size;
    for (const g of this.glyphs) {
      g.mesh.removeFromParent();
      g.id.removeFromParent();
      g.mesh.geometry.dispose();
    }
    this.glyphs.length = 0;
    joints.forEach((joint, i) => {
      const X = home[joint.a].clone().invert().multiply(joint.frame);
      const geometry = jointGlyph({ kind: joint.type, name: joint.name } as never, this.glyphSize * (joint.type === 'fixed' ? 0.5 : 1)).applyMatrix4(X);
      const face = new Float32Array(geometry.getAttribute('position').count);
      geometry.setAttribute('face', new THREE.BufferAttribute(face, 1));
      const material = shaded(new THREE.Color(), 0.85);
      material.depthTest = false;
      const mesh = new THREE.Mesh(geometry, material);
      mesh.renderOrder = 4;
      const pick = idMaterial();
      pick.depthTest = false;
      pick.uniforms.uFirst.value = this.firstId.at(-1)! + i;
      const id = new THREE.Mesh(geometry, pick);
      id.renderOrder = 4;
      this.bodies[joint.a].group.add(mesh);
      this.bodies[joint.a].ids.add(id);
      this.glyphs.push({ mesh, id, material, accepted: joint.accepted, isFixed: joint.type === 'fixed' });
    });
    this.look(this.chosen);
  }

  set showJoints(on: boolean) {
    this.jointsShown = on;
    this.look(this.chosen);
  }

  /** Colours of the theme; the chosen joint stands out. */
  look(chosen: number): void {
    this.chosen = chosen;
    this.bodies.forEach((body, i) => {
      const own = this.header.parts[this.header.bodies[i].part].color;
      const color = new THREE.Color(own || cssColor(`--body${i % 7}`));
      recolor(body.material, color, this.faded(i) ? 0.16 : 1);
      body.group.visible = !this.hidden(i);
      body.lines.color.set(cssColor('--edge'));
      body.lines.transparent = true;
      body.lines.opacity = this.faded(i) ? 0.25 : 1;
    });
    this.glyphs.forEach((g, i) => {
      recolor(g.material, new THREE.Color(cssColor(i === chosen ? '--interface' : '--glyph')), i === chosen ? 1 : 0.8);
      g.material.depthTest = false;
      // Fixed joints move nothing: only the chosen one is drawn.
      g.mesh.visible = g.id.visible = this.jointsShown && g.accepted && (!g.isFixed || i === chosen);
      g.mesh.renderOrder = i === chosen ? 6 : 4;
    });
    this.marked.forEach((m) => recolor(m.material as THREE.ShaderMaterial, new THREE.Color(cssColor(m.userData.color as string)), 1));
    this.stage.draw();
  }

  /** A ball at this place of the world, seen through everything. */
  point(p: THREE.Vector3 | null): void {
    this.ball.visible = p !== null;
    const material = this.ball.material as THREE.ShaderMaterial;
    recolor(material, new THREE.Color(cssColor('--bad')), 1);
    material.depthTest = false;
    this.ball.renderOrder = 8;
    this.ball.scale.setScalar(0.5 * this.glyphSize);
    if (p) this.ball.position.copy(p);
    this.group.add(this.ball);
  }

  /** Paints these faces: (body, number, colour of the theme). */
  mark(faces: [number, number, string][]): void {
    // Their geometries hold the part's own buffers, which disposing would delete.
    for (const m of this.marked) m.removeFromParent();
    this.marked.length = 0;
    for (const [body, face, color] of faces) {
      const part = this.parts[this.header.bodies[body].part];
      const range = part.first.get(this.header.parts[this.header.bodies[body].part].faces.findIndex((f) => f.number === face));
      if (!range) continue;
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute('position', part.faces.getAttribute('position'));
      geometry.setAttribute('normal', part.faces.getAttribute('normal'));
      geometry.setIndex(part.faces.getIndex());
      geometry.setDrawRange(range[0], range[1]);
      const material = shaded(new THREE.Color(cssColor(color)));
      material.polygonOffset = true;
      // Faces that lie on one another do not flicker.
      material.polygonOffsetFactor = material.polygonOffsetUnits = color === '--accent' ? -4 : -2;
      const mesh = new THREE.Mesh(geometry, material);
      mesh.userData.color = color;
      mesh.renderOrder = 2;
      this.bodies[body].group.add(mesh);
      this.marked.push(mesh);
    }
    this.stage.draw();
  }

  private picture(joints: boolean): { width: number; height: number; id(x: number, y: number): number } {
    this.bodies.forEach((b, i) => { b.ids.visible = !this.hidden(i) && (joints || !this.faded(i)); });
    for (const g of this.glyphs) g.id.visible = joints && g.mesh.visible;
    const { width, height, data } = this.stage.offscreen(this.ids);
    return { width, height, id: (x, y) => {
      const at = 4 * ((height - 1 - y) * width + x);
      return data[at] + 256 * data[at + 1] + 65536 * data[at + 2] - 1;
    } };
  }

  private meaning(id: number): Picked {
    if (id < 0) return { body: -1, face: -1, joint: -1 };
    const bodies = this.firstId.at(-1)!;
    if (id >= bodies) return { body: -1, face: -1, joint: id - bodies };
    let body = 0;
    while (this.firstId[body + 1] <= id) ++body;
    return { body, face: this.header.parts[this.header.bodies[body].part].faces[id - this.firstId[body]].number, joint: -1 };
  }

  /** What is under this place of the canvas [CSS px]. */
  pick(x: number, y: number): Picked {
    const image = this.picture(true);
    return this.meaning(x >= 0 && y >= 0 && x < image.width && y < image.height ? image.id(Math.floor(x), Math.floor(y)) : -1);
  }

  /** Numbers are placed when the camera rests: on the middle of what is seen of a face. */
  numberLater(): void {
    clearTimeout(this.timer);
    this.numbers.classList.add('moving');
    this.timer = window.setTimeout(() => this.number(), 120);
  }

  number(): void {
    this.numbers.replaceChildren();
    this.numbers.classList.remove('moving');
    if (!this.bodies.some((_, i) => this.numbered(i))) return;
    const image = this.picture(false);
    const seen = new Map<number, { n: number; x: number; y: number; miss: number; at: [number, number] }>();
    const visit = (see: (id: number, x: number, y: number) => void) => {
      for (let y = 0; y < image.height; ++y) for (let x = 0; x < image.width; ++x) {
        const id = image.id(x, y);
        if (id >= 0) see(id, x, y);
      }
    };
    visit((id, x, y) => {
      let s = seen.get(id);
      if (!s) seen.set(id, (s = { n: 0, x: 0, y: 0, miss: Infinity, at: [0, 0] }));
      ++s.n;
      s.x += x;
      s.y += y;
    });
    visit((id, x, y) => {
      const s = seen.get(id)!;
      const miss = Math.hypot(x - s.x / s.n, y - s.y / s.n);
      if (miss < s.miss) {
        s.miss = miss;
        s.at = [x, y];
      }
    });
    // Large faces first; a number that would cover another one is left out until the camera comes closer.
    const taken: [number, number][] = [];
    for (const [id, s] of [...seen].sort((a, b) => b[1].n - a[1].n)) {
      const what = this.meaning(id);
      if (s.n < 30 || what.body < 0 || !this.numbered(what.body)) continue;
      if (taken.some(([x, y]) => Math.abs(x - s.at[0]) < 24 && Math.abs(y - s.at[1]) < 17)) continue;
      taken.push(s.at);
      const tag = h('span', {}, String(what.face));
      tag.style.transform = `translate(calc(${s.at[0]}px - 50%), calc(${s.at[1]}px - 50%))`;
      this.numbers.append(tag);
    }
  }

  /** The numbers as they stand now, for pictures and tests. */
  shownNumbers(): { face: number; x: number; y: number }[] {
    return [...this.numbers.children].map((e) => {
      const [x, y] = (e as HTMLElement).style.transform.match(/-?[\d.]+(?=px)/g)!.map(Number);
      return { face: Number(e.textContent), x, y };
    });
  }
}
