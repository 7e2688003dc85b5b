// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// What the page of parts holds (PAGE.md): distinct parts with their faces, the bodies made of them, the joints between these.
import * as THREE from 'three';

export type Point = [number, number, number];
export interface FaceHeader {
  number: number;
  text: string; // "bore, radius 12 mm, ..."
  kind: string; // plane, cylinder, cone, sphere, other
  point: Point; // in the part [m]: on the axis, or the centroid
  axis: Point | null; // axis, or a plane's normal
  lines: string; // of the part file's [interface.NAME]
}
export interface PartHeader { key: string; name: string; file: string; color: string; faces: FaceHeader[] }
export interface BodyHeader { name: string; part: number; position: Point; rotation: number[]; text: string } // rotation: R_WB row by row
export interface JointHeader {
  name: string;
  type: string;
  lead: number; // of a screw: translation in one turn [m]
  a: number; // bodies
  b: number;
  position: Point; // of its frame in W [m]
  rotation: number[];
  confidence: string;
  doubt: string;
  evidence: string[];
  faces: [number, number][]; // (body, number of the face) that it sits on
  on: [number, number]; // number of the face of A and of B that carries its markers, or 0
}
export interface PartsHeader {
  format: 1;
  page: 'parts';
  title: string;
  created_by: string;
  parts: PartHeader[];
  bodies: BodyHeader[];
  ground: number; // body, or -1: a part alone, no mechanism
  joints: JointHeader[];
  doubts: string[];
  overlaps?: { a: number; b: number; place: Point; text: string }[];
  contacts?: { a: number; b: number; place: Point; text: string; lines: string }[]; // pairs that may touch; lines of the mechanism file
  head: string; // the mechanism file but for the ground and the joints
}

/** A joint as it is decided on. */
export interface Joint extends Omit<JointHeader, 'position' | 'rotation'> {
  accepted: boolean;
  frame: THREE.Matrix4; // in W, where the file has the bodies
  proposed: { type: string; frame: THREE.Matrix4 } | null; // null: made by hand
  redundant: number;
}

export function pose(rotation: number[], position: Point): THREE.Matrix4 {
  const [a, b, c, d, e, f, g, h, i] = rotation;
  return new THREE.Matrix4().set(a, b, c, position[0], d, e, f, position[1], g, h, i, position[2], 0, 0, 0, 1);
}

/** A frame at the point with z along the axis. */
export function frameAlong(point: THREE.Vector3, axis: THREE.Vector3): THREE.Matrix4 {
  const z = axis.clone().normalize();
  const least = [0, 1, 2].reduce((i, k) => (Math.abs(z.getComponent(k)) < Math.abs(z.getComponent(i)) ? k : i), 0);
  const x = new THREE.Vector3().setComponent(least, 1).addScaledVector(z, -z.getComponent(least)).normalize();
  return new THREE.Matrix4().makeBasis(x, z.clone().cross(x), z).setPosition(point);
}

export function decisions(header: PartsHeader): Joint[] {
  return header.joints.map((j) => {
    const frame = pose(j.rotation, j.position);
    return { ...j, accepted: true, frame, proposed: { type: j.type, frame: frame.clone() }, redundant: 0 };
  });
}

/** As TOML writes it; round-off beside 1 is nothing. */
export function number(x: number): string {
  const text = String(Math.abs(x) < 1e-15 ? 0 : x);
  return /[.e]/.test(text) ? text : `${text}.0`;
}
const list = (x: number[]) => `[${x.map(number).join(', ')}]`;
const plain = (text: string) => text.replace(/[^\x20-\x7e]/g, '?');

function poseLines(X: THREE.Matrix4, always: boolean): string {
  const p = new THREE.Vector3().setFromMatrixPosition(X);
  const q = new THREE.Quaternion().setFromRotationMatrix(X);
  const turned = Math.hypot(q.x, q.y, q.z) > 1e-15;
  return (always || p.length() > 0 ? `position = ${list(p.toArray())}\n` : '')
    + (turned ? `quaternion = ${list([q.w, q.x, q.y, q.z])}\n` : '');
}

/** The text of mechanism.toml with the joints that are accepted. */
export function mechanismText(header: PartsHeader, joints: Joint[], ground: number, freedom: number): string {
  const home = header.bodies.map((b) => pose(b.rotation, b.position));
  // What the rigid superelements beside the file have as interfaces: the faces that proposed joints sit on.
  const known = new Set(header.joints.flatMap((j) => [`${header.bodies[j.a].part} ${j.on[0]}`, `${header.bodies[j.b].part} ${j.on[1]}`]));
  let out = `${header.head}\n# degrees of freedom: ${freedom}\n\n[ground.marker.frame]\n${poseLines(home[ground], false)}`
    + `\n[body.${header.bodies[ground].name}.marker.ground]\n\n[joint.to_ground]\ntype = "fixed"\nfrom = "ground.frame"\n`
    + `to = "${header.bodies[ground].name}.ground"\n`;
  for (const j of joints) {
    if (!j.accepted) continue;
    const says = j.proposed ? [`confidence ${j.confidence}${j.doubt ? `: ${j.doubt}` : ''}`, ...j.evidence] : ['made on the page'];
    if (j.proposed && j.type !== j.proposed.type) says.push(`proposed was ${j.proposed.type}`);
    if (j.redundant > 0) says.push(`${j.redundant} of its rows follow from those of the joints before it`);
    out += `\n${says.map((s) => `# ${plain(s)}\n`).join('')}[joint.${j.name}]\ntype = "${j.type}"\n${j.type === 'screw' ? `pitch = ${number(j.lead)}\n` : ''}`
      + `from = "${header.bodies[j.a].name}.${j.name}"\nto = "${header.bodies[j.b].name}.${j.name}"\n`;
    for (const [body, face] of [[j.a, j.on[0]], [j.b, j.on[1]]]) {
      const there = face > 0 && known.has(`${header.bodies[body].part} ${face}`);
      out += `\n[body.${header.bodies[body].name}.marker.${j.name}]\n`
        + (there ? `on = "face${face}"\n` : face > 0 ? `# on = "face${face}" once the part is reduced with that interface\n` : '')
        + poseLines(home[body].clone().invert().multiply(j.frame), there);
    }
  }
  return out;
}

/** The [interface] tables of every part: faces of joints that are accepted, and those that were ticked ("part number"). */
export function interfaceTexts(header: PartsHeader, joints: Joint[], ticked: Set<string>): { part: PartHeader; text: string }[] {
  const wanted = header.parts.map(() => new Set<number>());
  for (const j of joints) {
    if (!j.accepted) continue;
    if (j.on[0]) wanted[header.bodies[j.a].part].add(j.on[0]);
    if (j.on[1]) wanted[header.bodies[j.b].part].add(j.on[1]);
  }
  for (const key of ticked) {
    const [part, face] = key.split(' ').map(Number);
    wanted[part].add(face);
  }
  return header.parts.flatMap((part, i) => {
    // Pieces of one bore have the same lines: one interface.
    const text = part.faces.filter((f) => wanted[i].has(f.number))
      .filter((f, k, all) => all.findIndex((other) => other.lines === f.lines) === k)
      .map((f) => `[interface.face${f.number}]\n# ${plain(f.text)}\n${f.lines}`).join('\n');
    return text ? [{ part, text }] : [];
  });
}
