// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Section forces on the motion page: which diagram is drawn, the largest values now, and their histories as plots.
import * as THREE from 'three';
import type { Mechanism } from './mechanism';
import { locate } from './motion_data';
import { resultants, type SectionForces } from './section_forces';
import { cssColor, figure, h, unitText } from './ui';

interface Row { body: string; member: number; sections: SectionForces; places: number[]; cells: HTMLElement[] }

export class SectionPanel {
  readonly element: HTMLElement;
  readonly choice: HTMLSelectElement;
  /** Resultant drawn as a diagram, -1 for none. */
  drawn = -1;
  private readonly rows: Row[] = [];
  private readonly largest = resultants.map(() => 0); // over the runs, in size
  private open = false;

  /** size: of the mechanism, for the diagrams' height [m]. */
  constructor(private readonly mechanisms: Mechanism[], private readonly size: number, plot: (name: string) => void,
              redraw: () => void) {
    for (const mechanism of mechanisms) {
      for (const body of mechanism.bodies) {
        if (!body.sections || this.rows.some((r) => r.body === body.name)) continue;
        const { sections } = body;
        sections.header.members.forEach((name, member) => {
          const places = sections.header.member.flatMap((m, p) => (m === member ? [p] : []));
          const cells = resultants.map((r, c) => h('button', { class: 'value', type: 'button',
            title: `Plot ${r.name} of ${name} where it is largest`, onclick: () => plot(this.history(body.name, member, c)) }));
          this.rows.push({ body: body.name, member, sections, places, cells });
        });
      }
      this.findLargest(mechanism);
    }
    this.choice = h('select', { id: 'sections', 'aria-label': 'Section forces', title: 'Diagram of a section force (S)',
                                onchange: () => { this.drawn = Number(this.choice.value); redraw(); } },
      h('option', { value: -1 }, 'No diagram'),
      ...resultants.map((r, c) => h('option', { value: c }, `${r.name} of sections`)));
    this.element = h('div', { class: 'section-forces' },
      h('p', { class: 'hint' }, 'Largest along each member at this time, with its sign; a click plots it.'),
      h('table', { class: 'quantities' },
        h('thead', {}, h('tr', {}, h('th', { scope: 'col' }, 'Member'),
          ...resultants.map((r) => h('th', { scope: 'col', class: 'number' }, r.name, h('small', {}, ` ${unitText(r.unit)}`))))),
        h('tbody', {}, ...this.rows.map((r) => h('tr', {}, h('td', {}, `${r.body}: ${r.sections.header.members[r.member]}`),
          ...r.cells.map((cell) => h('td', { class: 'number' }, cell)))))));
  }

  get present(): boolean {
    return this.rows.length > 0;
  }

  set shown(on: boolean) {
    this.open = on;
  }

  private findLargest(mechanism: Mechanism): void {
    const frames = mechanism.run.frameTime.length;
    for (const body of mechanism.bodies) {
      if (!body.sections || !body.deformed) continue;
      for (let i = 0; i < frames; ++i) {
        const weights = mechanism.weightsAt(body.name, i, 0);
        for (let p = 0; p < body.sections.n; ++p) {
          for (let c = 0; c < 6; ++c) {
            this.largest[c] = Math.max(this.largest[c], Math.abs(body.sections.value(p, c, weights)));
          }
        }
      }
    }
  }

  /** After the bodies are placed: diagrams of the solid run, and the table's numbers. */
  refresh(main: Mechanism): void {
    for (const mechanism of this.mechanisms) {
      for (const body of mechanism.bodies) {
        if (!body.diagram) continue;
        body.diagram.group.visible = mechanism === main && this.drawn >= 0 && this.largest[this.drawn] > 0;
        if (!body.diagram.group.visible) continue;
        body.diagram.color = new THREE.Color(cssColor('--diagram'));
        body.diagram.update(this.drawn, (0.12 * this.size) / this.largest[this.drawn]);
      }
    }
    if (!this.open) return;
    for (const row of this.rows) {
      const weights = main.body(row.body)?.deformed?.weights;
      row.cells.forEach((cell, c) => {
        if (!weights || !main.body(row.body)!.sections) return cell.replaceChildren('');
        let [most, at] = [0, row.places[0]];
        for (const p of row.places) {
          const v = row.sections.value(p, c, weights);
          if (Math.abs(v) > Math.abs(most)) [most, at] = [v, p];
        }
        const small = Math.abs(most) < 1e-6 * this.largest[c]; // round-off of 32-bit shapes
        cell.replaceChildren(small ? '0' : figure(most, 4));
        cell.dataset.at = String(row.sections.along(at));
      });
    }
  }

  /** Adds a resultant's history to every run that has it, at the place where it is largest; returns its name. */
  private history(body: string, member: number, c: number): string {
    const row = this.rows.find((r) => r.body === body && r.member === member)!;
    const runs = this.mechanisms.filter((m) => m.body(body)?.sections);
    let [most, place] = [-1, row.places[0]];
    for (const m of runs) {
      const frames = m.run.frameTime.length;
      for (let i = 0; i < frames; ++i) {
        const weights = m.weightsAt(body, i, 0);
        for (const p of row.places) {
          const v = Math.abs(row.sections.value(p, c, weights));
          if (v > most) [most, place] = [v, p];
        }
      }
    }
    return this.addHistory(body, place, c);
  }

  addHistory(body: string, place: number, c: number): string {
    const found = this.rows.find((r) => r.body === body && r.places.includes(place));
    if (!found) throw new Error(`no section forces of "${body}" at place ${place}`);
    const { sections, member } = found;
    const { name: resultant, unit } = resultants[c];
    const name = `${body}.${sections.header.members[member]}.${resultant} at ${figure(sections.along(place), 4)} m`;
    for (const m of this.mechanisms) {
      if (!m.body(body)?.sections) continue;
      const values = Float64Array.from(m.run.time, (t) => {
        const { at, part } = locate(m.run.frameTime, t);
        return sections.value(place, c, m.weightsAt(body, at, part));
      });
      m.run.addQuantity({ name, unit, doc: 'section force of the beam, from its deformation' }, values);
    }
    return name;
  }
}

/** For scripts: the six resultants of a place now. */
export function forcesAt(mechanism: Mechanism, body: string, place: number): number[] {
  const found = mechanism.body(body);
  if (!found?.sections || !found.deformed) throw new Error(`body "${body}" has no section forces in this run`);
  return resultants.map((_, c) => found.sections!.value(place, c, found.deformed!.weights));
}

