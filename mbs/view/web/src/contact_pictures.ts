// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Surfaces that are touched, lines that something travels along, and markers as triads.
import * as THREE from 'three';
import type { Connection, Point, Turn } from './motion_data';

const vector = (p: Point) => new THREE.Vector3(...p);
const turn = ([w, x, y, z]: Turn) => new THREE.Quaternion(x, y, z, w);

/** Materials that follow the theme. */
export class PictureMaterials {
  readonly face = new THREE.MeshBasicMaterial({ transparent: true, opacity: 0.14, depthWrite: false, side: THREE.DoubleSide });
  readonly line = new THREE.LineBasicMaterial({ transparent: true, opacity: 0.75 });
  setColor(color: THREE.Color): void {
    this.face.color.copy(color);
    this.line.color.copy(color);
  }
}

function shell(geometry: THREE.BufferGeometry, materials: PictureMaterials, lines: THREE.BufferGeometry): THREE.Group {
  const group = new THREE.Group();
  const face = new THREE.Mesh(geometry, materials.face);
  face.renderOrder = 2;
  group.add(face, new THREE.LineSegments(lines, materials.line));
  return group;
}

function circle(radius: number, place: (c: number, s: number) => THREE.Vector3): THREE.Vector3[] {
  const points: THREE.Vector3[] = [];
  const n = 64;
  for (let i = 0; i < n; ++i) {
    for (const k of [i, i + 1]) points.push(place(radius * Math.cos((2 * Math.PI * k) / n), radius * Math.sin((2 * Math.PI * k) / n)));
  }
  return points;
}

const ball = (radius: number, materials: PictureMaterials) => shell(new THREE.SphereGeometry(radius, 40, 24), materials,
  new THREE.BufferGeometry().setFromPoints([...circle(radius, (c, s) => new THREE.Vector3(c, s, 0)), ...circle(radius, (c, s) => new THREE.Vector3(0, c, s))]));

/** A plane, a cylinder and a curve go on for ever: a piece of the size of the bodies is drawn. */
export function touchedSurface(connection: Connection, size: number, materials: PictureMaterials): THREE.Group {
  const { kind, radius, points = [], closed, rotation } = connection.surface!;
  let drawn: THREE.Group;
  if (kind === 'plane') {
    const half = 0.25 * size;
    const lines: THREE.Vector3[] = [];
    for (let i = -4; i <= 4; ++i) {
      const at = (half * i) / 4;
      lines.push(new THREE.Vector3(at, -half, 0), new THREE.Vector3(at, half, 0), new THREE.Vector3(-half, at, 0), new THREE.Vector3(half, at, 0));
    }
    drawn = shell(new THREE.PlaneGeometry(2 * half, 2 * half), materials, new THREE.BufferGeometry().setFromPoints(lines));
  } else if (kind === 'sphere') drawn = ball(radius, materials);
  else if (kind === 'cylinder') {
    const half = Math.max(0.15 * size, radius);
    const rings = [-half, half].flatMap((z) => circle(radius, (c, s) => new THREE.Vector3(c, s, z)));
    drawn = shell(new THREE.CylinderGeometry(radius, radius, 2 * half, 64, 1, true).rotateX(Math.PI / 2), materials,
                  new THREE.BufferGeometry().setFromPoints(rings));
  } else {
    const half = 0.04 * size;
    const row = closed ? [...points, points[0]] : points;
    const corners: THREE.Vector3[] = [];
    const lines: THREE.Vector3[] = [];
    row.slice(1).forEach((next, i) => {
      const [a, b] = [row[i], next].map((p) => [vector(p).setZ(-half), vector(p).setZ(half)]);
      corners.push(a[0], b[0], b[1], a[0], b[1], a[1]);
      lines.push(a[0], b[0], a[1], b[1]);
    });
    drawn = shell(new THREE.BufferGeometry().setFromPoints(corners), materials, new THREE.BufferGeometry().setFromPoints(lines));
  }
  drawn.quaternion.copy(turn(rotation));
  if (connection.p_1) drawn.position.copy(vector(connection.p_1));
  drawn.name = connection.name;
  return drawn;
}

/** The sphere about p_2 that touches, or null. */
export function touchingSphere(connection: Connection, materials: PictureMaterials): THREE.Group | null {
  const { touching } = connection.surface!;
  if (!(touching > 0) || !connection.p_2) return null;
  const drawn = ball(touching, materials);
  drawn.position.copy(vector(connection.p_2));
  return drawn;
}

const axisColors = ['#d9383a', '#2f9e44', '#2f6fd9']; // x, y, z, as in the corner of the picture

/** x, y and z of a marker; drawn over what it sits in. */
export function triad(connection: Connection, length: number): THREE.LineSegments {
  const points: THREE.Vector3[] = [];
  const colors: number[] = [];
  axisColors.forEach((name, i) => {
    points.push(new THREE.Vector3(), new THREE.Vector3().setComponent(i, length));
    const color = new THREE.Color(name);
    colors.push(...color.toArray(), ...color.toArray());
  });
  const geometry = new THREE.BufferGeometry().setFromPoints(points);
  geometry.setAttribute('color', new THREE.Float32BufferAttribute(colors, 3));
  const drawn = new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ vertexColors: true, depthTest: false }));
  drawn.renderOrder = 6;
  drawn.name = connection.name;
  if (connection.p_1) drawn.position.copy(vector(connection.p_1));
  if (connection.rotation) drawn.quaternion.copy(turn(connection.rotation));
  return drawn;
}

/** Where on a path, in W: straight between its markers, wherever their bodies are. */
export class PathLine {
  readonly line: THREE.Line;
  constructor(private readonly stops: { on: THREE.Object3D; p: THREE.Vector3; place: number }[], materials: PictureMaterials) {
    this.line = new THREE.Line(new THREE.BufferGeometry().setFromPoints(stops.map((s) => s.p)), materials.line);
    this.line.frustumCulled = false;
  }
  update(): void {
    const places = this.line.geometry.getAttribute('position') as THREE.BufferAttribute;
    this.stops.forEach((s, i) => {
      const p = s.p.clone().applyMatrix4(s.on.matrixWorld);
      places.setXYZ(i, p.x, p.y, p.z);
    });
    places.needsUpdate = true;
  }
  at(place: number): THREE.Vector3 {
    const { stops } = this;
    const last = stops.length - 1;
    const i = Math.max(0, Math.min(last - 1, stops.findIndex((_, k) => k === last || stops[k + 1].place >= place)));
    const [a, b] = [stops[i], stops[i + 1]];
    const part = (place - a.place) / (b.place - a.place);
    return a.p.clone().applyMatrix4(a.on.matrixWorld).lerp(b.p.clone().applyMatrix4(b.on.matrixWorld), part);
  }
}
