// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// One run of the mechanism in the scene: bodies at their poses, flexible ones deformed, glyphs on them.
import * as THREE from 'three';
import { ForceArrows } from './arrows';
import { ContactPressures } from './contact_pressure';
import { DeformedBody } from './deformed_body';
import { locate, type MotionHeader, type Peak, type Run } from './motion_data';
import { SectionDiagram } from './section_diagram';
import type { SectionForces } from './section_forces';
import { PathLine, PictureMaterials, touchedSurface, touchingSphere, triad } from './contact_pictures';
import { coil, hasNoGlyph, isLink, isSpring, jointGlyph, primitive, recolor, shaded, stickFigure } from './primitives';
import type { Surface } from './surface';
import { cssColor } from './ui';

interface DrawnBody {
  name: string;
  number: number; // in the run, -1 for one that the run does not store (ground)
  group: THREE.Group;
  kind: string;
  solids: { material: THREE.ShaderMaterial; color?: string }[];
  deformed: DeformedBody | null;
  sections: SectionForces | null; // of a flexible beam
  diagram: SectionDiagram | null;
  box: THREE.Box3; // undeformed, in the body's frame
}

interface Spring { line: THREE.Line; from: DrawnBody; to: DrawnBody; p: THREE.Vector3; q: THREE.Vector3 }

export class Mechanism {
  readonly group = new THREE.Group();
  readonly bodies: DrawnBody[] = [];
  readonly glyphs: THREE.Object3D[] = [];
  readonly arrows: ForceArrows;
  readonly pressures: ContactPressures;
  private readonly arrowMaterial = shaded(new THREE.Color());
  private readonly springs: Spring[] = [];
  /** Surfaces that are touched and the spheres that touch them; paths. */
  readonly contacts: THREE.Object3D[] = [];
  readonly markers: THREE.Object3D[] = [];
  private readonly paths: PathLine[] = [];
  private readonly pictureMaterials = new PictureMaterials();
  private contactsShown = true;
  private markersShown = false;
  private pressuresShown = true;
  private readonly glyphMaterial = shaded(new THREE.Color());
  private readonly springMaterial = new THREE.LineBasicMaterial();
  private magnify_ = 1;
  private ghost = false;
  private jointsShown = true;
  private reference = 'held';
  /** Of each flexible body: the largest displacement from the reference, and stress. */
  displacements: (Peak & { body: string })[] = [];
  stresses: (Peak & { body: string })[] = [];

  /** [m] */
  get largestDeflection(): number {
    return Math.max(0, ...this.displacements.map((p) => p.value));
  }

  /** [Pa] */
  get largestStress(): number {
    return Math.max(0, ...this.stresses.map((p) => p.value));
  }

  constructor(readonly run: Run, header: MotionHeader, surfaces: Surface[], scale: THREE.Texture, glyphSize: number) {
    const connections = header.connections ?? [];
    for (const body of header.bodies) {
      const number = run.header.bodies.findIndex((b) => b.name === body.name);
      const group = new THREE.Group();
      const box = new THREE.Box3();
      const surface = number >= 0 ? run.header.bodies[number].surface : null;
      let deformed: DeformedBody | null = null;
      let sections: SectionForces | null = null;
      if (surface !== null) {
        deformed = new DeformedBody(surfaces[surface], scale);
        deformed.outline.visible = false;
        box.union(surfaces[surface].box);
        if (run.header.bodies[number].n_shapes > 0) sections = surfaces[surface].sections;
        group.add(deformed.group);
      }
      const points = connections.filter((c) => c.kind !== 'marker' && !c.surface && !c.path).flatMap((c) => [
        ...(c.body_1 === body.name && c.p_1 ? [new THREE.Vector3(...c.p_1)] : []),
        ...(c.body_2 === body.name && c.p_2 ? [new THREE.Vector3(...c.p_2)] : [])]);
      // The colour of the body, and those of shapes with one of their own.
      const solids: DrawnBody['solids'] = [];
      const add = (geometries: THREE.BufferGeometry[], color?: string) => {
        let solid = solids.find((s) => s.color === color);
        if (!solid) solids.push((solid = { material: shaded(new THREE.Color()), color }));
        for (const geometry of geometries) {
          geometry.computeBoundingBox();
          box.union(geometry.boundingBox!);
          group.add(new THREE.Mesh(geometry, solid.material));
        }
      };
      for (const shape of body.shapes) add(primitive(shape, 0.35 * glyphSize), shape.color);
      if (!body.shapes.length && !deformed && body.kind !== 'ground') add(stickFigure(points, 0.5 * glyphSize));
      for (const p of points) box.expandByPoint(p);
      const diagram = deformed && sections ? new SectionDiagram(deformed, sections) : null;
      if (diagram) group.add(diagram.group);
      this.bodies.push({ name: body.name, kind: body.kind, number, group, solids, deformed, sections, diagram, box });
      this.group.add(group);
    }
    const at = (name?: string) => this.bodies.find((b) => b.name === name);
    const pathOf = new Map<string, PathLine>();
    for (const connection of connections) {
      const from = at(connection.body_1);
      const to = at(connection.body_2);
      if (connection.kind === 'marker' && from) {
        const drawn = triad(connection, 3 * glyphSize);
        from.group.add(drawn);
        this.markers.push(drawn);
      }
      if (connection.surface && connection.surface.kind !== 'body' && from) {
        const drawn = touchedSurface(connection, glyphSize / 0.014, this.pictureMaterials);
        from.group.add(drawn);
        this.contacts.push(drawn);
        const sphere = touchingSphere(connection, this.pictureMaterials);
        if (sphere && to) {
          to.group.add(sphere);
          this.contacts.push(sphere);
        }
      }
      if (connection.path?.every((stop) => at(stop.body))) {
        const path = new PathLine(connection.path.map((s) => ({ on: at(s.body)!.group, p: new THREE.Vector3(...s.p), place: s.place })), this.pictureMaterials);
        this.paths.push(path);
        pathOf.set(connection.name, path);
        this.group.add(path.line);
        this.contacts.push(path.line);
      }
      if (hasNoGlyph(connection)) continue;
      if ((isSpring(connection) || isLink(connection)) && from && to) {
        const shape = isLink(connection) ? new THREE.BufferGeometry().setFromPoints([new THREE.Vector3(), new THREE.Vector3(0, 0, 1)])
          : coil(0.7 * glyphSize);
        const line = new THREE.Line(shape, this.springMaterial);
        line.frustumCulled = false;
        this.springs.push({ line, from, to, p: new THREE.Vector3(...connection.p_1!),
                            q: new THREE.Vector3(...connection.p_2!) });
        this.group.add(line);
        this.glyphs.push(line);
      } else if (from && connection.p_1) {
        const glyph = new THREE.Mesh(jointGlyph(connection, glyphSize), this.glyphMaterial);
        glyph.name = connection.name;
        glyph.renderOrder = 4;
        from.group.add(glyph);
        this.glyphs.push(glyph);
      }
    }
    this.arrows = new ForceArrows(run, connections, (name) => at(name)?.group, this.arrowMaterial, 16 * glyphSize, 0.3 * glyphSize,
                                  (name) => pathOf.get(name));
    this.pressures = new ContactPressures(run, connections, (name) => at(name)?.deformed);
    this.showContacts = true;
    this.showMarkers = false;
    this.group.add(this.arrows.group, this.pressures.group);
  }

  async loadShapes(): Promise<void> {
    await Promise.all([this.arrows.load(), this.pressures.load()]);
    await Promise.all(this.bodies.flatMap((b) => {
      if (!b.deformed || b.number < 0) return [];
      const { first_shape, n_shapes } = this.run.header.bodies[b.number];
      return [...Array.from({ length: n_shapes }, (_, j) => b.deformed!.surface.load(first_shape + j)),
              b.sections?.load(first_shape, n_shapes)];
    }));
    this.setReference(this.reference);
  }

  /**
   * Where deformation is taken from: 'held' (the interface at which a joint to the ground holds the body, else its
   * floating frame), 'own' (the floating frame), 'interface:NAME' (of the bodies that have it); or the whole
   * displacement since the start, seen from 'ground' or 'body:NAME'.
   */
  setReference(choice: string): void {
    this.reference = choice;
    this.displacements = [];
    this.stresses = [];
    for (const body of this.bodies) {
      if (!body.deformed || body.number < 0) continue;
      const { frames, held_by, first_shape, largest } = this.run.header.bodies[body.number];
      const named = choice.startsWith('interface:') ? (frames ?? []).find((f) => f.name === choice.slice(10)) : undefined;
      const held = choice !== 'own' && typeof held_by === 'number' ? frames?.[held_by] : undefined;
      const frame = named ?? held;
      body.deformed.reference = frame ? { frame, first: first_shape } : null;
      if (!largest) continue;
      // A body that the run does not store stands still.
      const from = choice === 'ground' || choice.startsWith('body:') ? largest.displacement[choice] ?? largest.displacement.ground
        : largest.displacement[frame ? `interface:${frame.name}` : 'own'];
      this.displacements.push({ ...from, body: body.name });
      if (largest.stress && body.deformed.surface.stress) this.stresses.push({ ...largest.stress, body: body.name });
    }
  }

  /** The pose of a body at a frame and a fraction of the way to the next. */
  private poseAt(number: number, frame: number, part: number): THREE.Matrix4 {
    const frames = this.run.frameTime.length;
    const { pose } = this.run.motion[number];
    const next = part === 0 ? frame : frame + 1;
    const mix = (c: number) => pose[c * frames + frame] + part * (pose[c * frames + next] - pose[c * frames + frame]);
    const q = (row: number) => new THREE.Quaternion(pose[4 * frames + row], pose[5 * frames + row],
                                                    pose[6 * frames + row], pose[3 * frames + row]).normalize();
    const turned = part > 0 ? q(frame).slerp(q(next), part) : q(frame); // slerp takes the shorter way round
    return new THREE.Matrix4().compose(new THREE.Vector3(mix(0), mix(1), mix(2)), turned, new THREE.Vector3(1, 1, 1));
  }

  /** Seen from the ground or another body, where that is the reference. */
  private see(body: DrawnBody, frame: number, part: number): void {
    const other = this.reference.startsWith('body:') ? this.body(this.reference.slice(5)) : undefined;
    if (this.reference !== 'ground' && !other) {
      body.deformed!.see(null);
      return;
    }
    const from = (at: number, p: number) => (other && other.number >= 0 ? this.poseAt(other.number, at, p).invert() : new THREE.Matrix4())
      .multiply(this.poseAt(body.number, at, p));
    body.deformed!.see({ now: from(frame, part), then: from(0, 0) });
  }

  /** Weights of the shapes of a flexible body at a frame and a fraction of the way to the next. */
  weightsAt(name: string, frame: number, part: number): Float32Array {
    const body = this.body(name)!;
    const weights = new Float32Array(body.deformed!.weights.length);
    const { modal } = this.run.motion[body.number];
    if (modal) this.mixModal(body, modal, frame, part, weights);
    return weights;
  }

  private mixModal(body: DrawnBody, modal: Float32Array, frame: number, part: number, out: Float32Array): void {
    const frames = this.run.frameTime.length;
    const next = part === 0 ? frame : frame + 1;
    const { first_shape, n_shapes } = this.run.header.bodies[body.number];
    for (let j = 0; j < n_shapes; ++j) {
      const a = modal[j * frames + frame];
      out[first_shape + j] = a + part * (modal[j * frames + next] - a);
    }
  }

  set magnify(value: number) {
    this.magnify_ = value;
    for (const body of this.bodies) if (body.deformed) body.deformed.magnify = value;
  }
  get magnify(): number {
    return this.magnify_;
  }

  setTime(t: number): void {
    const { at, part } = locate(this.run.frameTime, t);
    const frames = this.run.frameTime.length;
    for (const body of this.bodies) {
      if (body.number < 0 || !frames) continue;
      const { modal } = this.run.motion[body.number];
      this.poseAt(body.number, at, part).decompose(body.group.position, body.group.quaternion, new THREE.Vector3());
      if (body.deformed && modal) {
        this.see(body, at, part);
        this.mixModal(body, modal, at, part, body.deformed.weights);
        body.deformed.update();
      }
    }
    this.group.updateMatrixWorld(true);
    for (const path of this.paths) path.update();
    if (this.run.time.length) {
      const row = locate(this.run.time, t);
      this.arrows.setTime(row.at, row.part);
      this.pressures.setTime(row.at, row.part);
    }
    for (const s of this.springs) {
      const a = s.p.clone().applyMatrix4(s.from.group.matrixWorld);
      const b = s.q.clone().applyMatrix4(s.to.group.matrixWorld);
      const along = b.clone().sub(a);
      s.line.position.copy(a);
      s.line.scale.set(1, 1, Math.max(1e-9, along.length()));
      if (along.lengthSq() > 0) {
        s.line.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), along.normalize());
      }
    }
  }

  /** Where all bodies are at a time. */
  box(t: number, out = new THREE.Box3()): THREE.Box3 {
    this.setTime(t);
    const b = new THREE.Box3();
    for (const body of this.bodies) {
      if (!body.box.isEmpty()) out.union(b.copy(body.box).applyMatrix4(body.group.matrixWorld));
    }
    return out;
  }

  /** Where what they touch is, at the time that was set last. */
  boxOfContacts(out: THREE.Box3): void {
    for (const drawn of this.contacts) if (drawn.name) out.expandByObject(drawn);
  }

  body(name: string): DrawnBody | undefined {
    return this.bodies.find((b) => b.name === name);
  }

  /** Joints and springs; a ghost, which shows where bodies are, has none. */
  set showJoints(on: boolean) {
    this.jointsShown = on;
    for (const glyph of this.glyphs) glyph.visible = on && !this.ghost;
  }

  set showContacts(on: boolean) {
    this.contactsShown = on;
    for (const drawn of this.contacts) drawn.visible = on && !this.ghost;
  }
  set showPressures(on: boolean) {
    this.pressuresShown = on;
    this.pressures.group.visible = on && !this.ghost;
  }
  set showMarkers(on: boolean) {
    this.markersShown = on;
    for (const drawn of this.markers) drawn.visible = on && !this.ghost;
  }

  /** Solid in the bodies' colours, or a ghost in the run's colour. */
  setLook(ghost: THREE.Color | null): void {
    this.ghost = ghost !== null;
    this.showJoints = this.jointsShown;
    this.showContacts = this.contactsShown;
    this.showMarkers = this.markersShown;
    this.pressures.group.visible = this.pressuresShown && !this.ghost;
    this.pictureMaterials.setColor(new THREE.Color(cssColor('--glyph')));
    this.bodies.forEach((body, i) => {
      // The ground is the same in every run.
      if (ghost && body.kind === 'ground') {
        body.group.visible = false;
        return;
      }
      body.group.visible = true;
      const own = new THREE.Color(cssColor(body.kind === 'ground' ? '--ground-body' : `--body${i % 7}`));
      const color = ghost ?? own;
      const opacity = ghost ? 0.3 : 1;
      for (const s of body.solids) recolor(s.material, ghost ?? (s.color ? new THREE.Color(s.color) : own), opacity);
      body.deformed?.setLook({ color, accent: color, edge: ghost ?? new THREE.Color(cssColor('--edge')),
                               outline: new THREE.Color(cssColor('--outline')), opacity });
    });
    // Joints sit inside bodies: they are drawn over them.
    recolor(this.glyphMaterial, ghost ?? new THREE.Color(cssColor('--glyph')), ghost ? 0.25 : 0.85);
    this.glyphMaterial.depthTest = false;
    this.springMaterial.color.set(cssColor('--glyph'));
    recolor(this.arrowMaterial, ghost ?? new THREE.Color(cssColor('--force')), ghost ? 0.35 : 1);
    this.arrowMaterial.depthTest = false;
  }
}
