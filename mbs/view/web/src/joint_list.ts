// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// The list of joints of an assembly: what was proposed on which evidence, to be accepted, changed, deleted, and moved by its coordinates.
import { coordinatesOf, jointTypes, type Coordinate } from './joint_motion';
import type { Joint, PartsHeader } from './parts_data';
import { h, icon, lengthText, say, slider } from './ui';

export interface JointActions {
  choose(joint: number): void;
  change(joint: Joint, change: { type?: string; accepted?: boolean; name?: string; lead?: number }): void;
  /** To this coordinate [rad, m]; false where the mechanism does not go as far. */
  drive(joint: Joint, which: Coordinate, value: number): boolean;
  coordinate(joint: Joint, which: Coordinate): number;
  reset(): void;
  flip(joint: Joint): void;
  align(joint: Joint, body: number, face: number): void;
  remove(joint: Joint): void;
  ground(body: number): void;
  /** At a pair that overlaps, those that may touch after them. */
  look(pair: number): void;
}

const words: Record<Coordinate, string> = { angle: 'Turn', slide: 'Slide', x: 'Along x', y: 'Along y' };

export class JointList {
  readonly element = h('div', { class: 'joints' });

  constructor(private readonly header: PartsHeader, private readonly act: JointActions, private readonly size: number) {}

  reveal(): void {
    this.element.querySelector('.joint.chosen')?.scrollIntoView({ block: 'nearest' });
  }

  show(joints: Joint[], chosen: number, ground: number, freedom: number): void {
    const names = this.header.bodies.map((b) => b.name);
    const stands = h('select', { id: 'ground', 'aria-label': 'Body on the ground', onchange: () => this.act.ground(Number(stands.value)) },
                     ...names.map((n, i) => h('option', { value: i }, n)));
    stands.value = String(ground);
    const redundant = joints.reduce((n, j) => n + (j.accepted ? j.redundant : 0), 0);
    this.element.replaceChildren(
      h('div', { class: 'freedom' }, h('label', {}, 'On the ground ', stands),
        h('span', {}, `${freedom} ${freedom === 1 ? 'degree' : 'degrees'} of freedom${redundant ? `, ${redundant} redundant ${redundant === 1 ? 'row' : 'rows'}` : ''}`)),
      // What moves first: the fixed ones are many and seldom doubted.
      ...[...joints.keys()].sort((i, k) => Number(joints[i].type === 'fixed') - Number(joints[k].type === 'fixed'))
        .map((i) => this.card(joints[i], i, i === chosen)),
      ...(joints.length ? [] : [h('p', { class: 'hint' }, 'No joint is proposed. Click a face of one part and a face of another to make one.')]),
      ...(this.header.doubts.length ? [h('details', { class: 'warnings', open: true },
        h('summary', {}, icon('warning'), `${this.header.doubts.length} to be looked at`), ...this.header.doubts.map((d) => h('p', {}, d)))] : []),
      ...(this.header.overlaps?.length ? [h('details', { class: 'warnings', open: true },
        h('summary', {}, icon('warning'), `${this.header.overlaps.length} ${this.header.overlaps.length === 1 ? 'pair of parts overlaps' : 'pairs of parts overlap'}`),
        ...this.header.overlaps.map((o, i) => h('p', {}, h('button', { type: 'button', class: 'overlap', onclick: () => this.act.look(i) }, o.text))))] : []),
      ...(this.header.contacts?.length ? [h('details', { class: 'warnings' },
        h('summary', {}, `${this.header.contacts.length} ${this.header.contacts.length === 1 ? 'pair of bodies' : 'pairs of bodies'} may touch`),
        ...this.header.contacts.map((c, i) => h('p', {}, h('button', { type: 'button', class: 'overlap',
          onclick: () => this.act.look((this.header.overlaps?.length ?? 0) + i) }, c.text))))] : []));
  }

  private card(j: Joint, i: number, chosen: boolean): HTMLElement {
    const accept = h('input', { type: 'checkbox', checked: j.accepted, 'aria-label': `Accept ${j.name}`, title: 'Accepted',
                                onchange: () => this.act.change(j, { accepted: accept.checked }) });
    const type = h('select', { 'aria-label': `Type of ${j.name}`, onchange: () => this.act.change(j, { type: type.value }) },
                   ...jointTypes.map((t) => h('option', { value: t }, t)));
    type.value = j.type;
    const sure = j.proposed ? j.confidence : 'by hand';
    return h('section', { class: `joint${j.accepted ? '' : ' out'}${chosen ? ' chosen' : ''}`, 'data-joint': j.name },
      h('header', {}, accept,
        h('button', { type: 'button', class: 'name', 'aria-expanded': String(chosen), onclick: () => this.act.choose(chosen ? -1 : i) }, j.name),
        h('span', { class: `sure ${sure.replace(' ', '-')}`, title: j.doubt || `confidence ${sure}` }, sure), type),
      chosen ? this.detail(j) : null);
  }

  private detail(j: Joint): HTMLElement {
    const names = this.header.bodies.map((b) => b.name);
    const movers = j.accepted ? coordinatesOf(j.type).map((which) => this.mover(j, which)) : [];
    const seats = j.faces.filter(([body, face]) => this.header.parts[this.header.bodies[body].part].faces.find((f) => f.number === face)?.axis);
    const align = h('select', { 'aria-label': `Axis of ${j.name}`, onchange: () => {
      const [body, face] = seats[Number(align.value)] ?? [];
      if (body !== undefined) this.act.align(j, body, face);
    } }, h('option', { value: '' }, 'Axis of a face ...'),
      ...seats.map(([body, face], k) => h('option', { value: k }, `face ${face} of ${names[body]}`)));
    return h('div', { class: 'detail' },
      ...movers,
      j.type === 'screw' ? this.leadOf(j) : null,
      h('p', {}, `Between ${names[j.a]} and ${names[j.b]}${j.redundant ? `; ${j.redundant} of its rows follow from those of the joints before it` : ''}.`),
      j.doubt ? h('p', { class: 'doubt' }, j.doubt) : null,
      j.evidence.length ? h('ul', {}, ...j.evidence.map((e) => h('li', {}, e.replaceAll('^2', '²')))) : null,
      h('div', { class: 'group' },
        seats.length && j.type !== 'fixed' ? align : null,
        j.type !== 'fixed' && j.type !== 'spherical' ? h('button', { class: 'plain', type: 'button', onclick: () => this.act.flip(j) }, 'Turn the axis round') : null,
        h('button', { class: 'plain', type: 'button', onclick: () => this.act.remove(j) }, 'Delete')));
  }

  private leadOf(j: Joint): HTMLElement {
    const lead = h('input', { type: 'number', step: 'any', value: String(Number((1e3 * j.lead).toPrecision(9))), 'aria-label': `Lead of ${j.name} in mm`,
                              onchange: () => this.act.change(j, { lead: Number(lead.value) / 1e3 || j.lead }) });
    return h('label', { class: 'lead' }, 'Lead ', lead, ' mm a turn, negative: left-hand');
  }

  private mover(j: Joint, which: Coordinate): HTMLElement {
    const isAngle = which === 'angle';
    const degrees = 180 / Math.PI;
    const now = this.act.coordinate(j, which);
    const s = slider(words[which], {
      min: isAngle ? -180 : -this.size / 2, max: isAngle ? 180 : this.size / 2, step: isAngle ? 0.5 : this.size / 2000,
      value: isAngle ? now * degrees : now, id: `drive-${which}`,
      text: (v) => (isAngle ? `${v.toFixed(1)}°` : lengthText(v)),
      change: (v) => {
        if (this.act.drive(j, which, isAngle ? v / degrees : v)) return;
        // The slider stays where the mechanism does.
        const reached = this.act.coordinate(j, which);
        say('It goes no further this way');
        const input = s.element.querySelector('input')!;
        input.value = String(isAngle ? reached * degrees : reached);
        s.refresh();
      },
    });
    return s.element;
  }
}
