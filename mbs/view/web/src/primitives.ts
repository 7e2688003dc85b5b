// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Cylinders, boxes and the like for rigid bodies, and the glyphs of joints and forces.
import * as THREE from 'three';
import type { Connection, Point, PrimitiveHeader } from './motion_data';

const vertexShader = /* glsl */ `
  uniform float uPush;
  out vec3 vNormal, vPlace;
  void main() {
    vec4 place = modelViewMatrix * vec4(position, 1.0);
    vPlace = place.xyz;
    vNormal = normalMatrix * normal;
    place.xyz *= 1.0 + uPush;
    gl_Position = projectionMatrix * place;
  }`;
const fragmentShader = /* glsl */ `
  precision highp float;
  uniform vec3 uColor;
  uniform float uOpacity;
  in vec3 vNormal, vPlace;
  out vec4 color;
  void main() {
    vec3 n = normalize(vNormal);
    vec3 toEye = normalize(-vPlace);
    if (dot(n, toEye) < 0.0) n = -n;
    vec3 key = normalize(vec3(0.35, 0.55, 0.75));
    vec3 fill = normalize(vec3(-0.7, -0.2, 0.45));
    float light = 0.50 + 0.46 * max(dot(n, key), 0.0) + 0.16 * max(dot(n, fill), 0.0) + 0.06 * n.y;
    float shine = 0.16 * pow(max(dot(n, normalize(key + toEye)), 0.0), 36.0);
    color = vec4(uColor * light + shine, uOpacity);
  }`;

/** Ghosts are drawn a little farther from the eye, at the same place on the screen: where one coincides with the solid
 * body, the solid one is seen. */
export const ghostPush = 0.006;

export function shaded(color: THREE.Color, opacity = 1): THREE.ShaderMaterial {
  return new THREE.ShaderMaterial({
    glslVersion: THREE.GLSL3, vertexShader, fragmentShader, side: THREE.DoubleSide,
    transparent: opacity < 1, depthWrite: opacity >= 1,
    uniforms: { uColor: { value: color.clone() }, uOpacity: { value: opacity }, uPush: { value: 0 } },
  });
}

export function recolor(material: THREE.ShaderMaterial, color: THREE.Color, opacity: number): void {
  (material.uniforms.uColor.value as THREE.Color).copy(color);
  material.uniforms.uOpacity.value = opacity;
  material.transparent = opacity < 1;
  material.depthWrite = opacity >= 1;
  material.uniforms.uPush.value = opacity < 1 ? ghostPush : 0;
}

const up = new THREE.Vector3(0, 1, 0);
const toVector = (p: Point) => new THREE.Vector3(p[0], p[1], p[2]);

export function rod(a: THREE.Vector3, b: THREE.Vector3, radius: number): THREE.BufferGeometry {
  const along = b.clone().sub(a);
  const g = new THREE.CylinderGeometry(radius, radius, along.length(), 20);
  g.applyQuaternion(new THREE.Quaternion().setFromUnitVectors(up, along.clone().normalize()));
  g.translate((a.x + b.x) / 2, (a.y + b.y) / 2, (a.z + b.z) / 2);
  return g;
}

export function primitive(shape: PrimitiveHeader, lineRadius: number): THREE.BufferGeometry[] {
  switch (shape.type) {
    case 'cylinder':
    case 'cone': {
      const g = shape.type === 'cylinder' ? new THREE.CylinderGeometry(shape.radius, shape.radius, shape.length, 48)
        : new THREE.ConeGeometry(shape.radius, shape.length, 48);
      g.applyQuaternion(new THREE.Quaternion().setFromUnitVectors(up, toVector(shape.axis)));
      g.translate(...shape.position);
      return [g];
    }
    case 'sphere':
      return [new THREE.SphereGeometry(shape.radius, 40, 24).translate(...shape.position)];
    case 'box': {
      const [w, x, y, z] = shape.rotation;
      return [new THREE.BoxGeometry(...shape.size).applyQuaternion(new THREE.Quaternion(x, y, z, w))
        .translate(...shape.position)];
    }
    case 'line':
      return shape.points.slice(1).map((p, i) => rod(toVector(shape.points[i]), toVector(p), lineRadius));
  }
}

/** A body without shapes: rods from the middle of its connections to each of them. */
export function stickFigure(points: THREE.Vector3[], radius: number): THREE.BufferGeometry[] {
  if (points.length === 0) return [new THREE.SphereGeometry(2.2 * radius, 24, 16)];
  const all = points.length === 1 ? [...points, new THREE.Vector3()] : points;
  const ends = all.length === 2 ? [[all[0], all[1]]] : (() => {
    const middle = all.reduce((s, p) => s.add(p), new THREE.Vector3()).divideScalar(all.length);
    return all.map((p) => [middle, p]);
  })();
  const rods = ends.filter(([a, b]) => a.distanceTo(b) > 1e-9).map(([a, b]) => rod(a, b, radius));
  return [...rods, ...all.map((p) => new THREE.SphereGeometry(1.5 * radius, 20, 14).translate(p.x, p.y, p.z))];
}

/** The glyph of a joint at its place on body 1; z of the shapes below is the joint's axis. */
export function jointGlyph(connection: Connection, size: number): THREE.BufferGeometry {
  const kind = connection.kind.toLowerCase();
  const g = /revolute|driven_rot|hinge/.test(kind) ? new THREE.TorusGeometry(size, 0.28 * size, 14, 40)
    : /prismatic|slider|translational/.test(kind) ? new THREE.BoxGeometry(0.8 * size, 0.8 * size, 3 * size)
    : /cylindrical|screw/.test(kind) ? new THREE.CylinderGeometry(0.7 * size, 0.7 * size, 3 * size, 28).rotateX(Math.PI / 2)
    : /spherical|ball/.test(kind) ? new THREE.SphereGeometry(0.9 * size, 28, 18)
    : /universal|hooke|cardan/.test(kind) ? new THREE.OctahedronGeometry(1.2 * size)
    : /bearing/.test(kind) ? new THREE.TorusGeometry(1.3 * size, 0.45 * size, 14, 40)
    : kind === 'constraint' ? new THREE.TetrahedronGeometry(0.9 * size)
    : /planar|plane/.test(kind) ? new THREE.BoxGeometry(2.4 * size, 2.4 * size, 0.3 * size)
    : new THREE.BoxGeometry(1.2 * size, 1.2 * size, 1.2 * size);
  const axis = connection.axis_1 ? toVector(connection.axis_1) : new THREE.Vector3(0, 0, 1);
  if (axis.lengthSq() > 0) {
    g.applyQuaternion(new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 0, 1), axis.normalize()));
  }
  return connection.p_1 ? g.translate(...connection.p_1) : g;
}

/** Kinds that are drawn by what they are (contact_pictures.ts), not by a glyph. */
export function hasNoGlyph(connection: Connection): boolean {
  return ['marker', 'path'].includes(connection.kind) || !!connection.surface;
}

export function isLink(connection: Connection): boolean {
  return connection.kind === 'link' && !!connection.p_1 && !!connection.p_2;
}

export function isSpring(connection: Connection): boolean {
  return /spring|damper|bushing|actuator|line_force/.test(connection.kind.toLowerCase()) && !!connection.p_1 && !!connection.p_2;
}

/** A coil of unit length along z, to be stretched between two points. */
export function coil(radius: number): THREE.BufferGeometry {
  const turns = 7;
  const points = [new THREE.Vector3(0, 0, 0)];
  for (let i = 0; i <= 24 * turns; ++i) {
    const angle = (2 * Math.PI * i) / 24;
    points.push(new THREE.Vector3(radius * Math.cos(angle), radius * Math.sin(angle), 0.1 + (0.8 * i) / (24 * turns)));
  }
  points.push(new THREE.Vector3(0, 0, 1));
  return new THREE.BufferGeometry().setFromPoints(points);
}
