// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// The largest displacement and stress of all stored times and vertices, as the writer found them: how large, where, when.
import type { Mechanism } from './mechanism';
import type { Peak } from './motion_data';
import { figure, h, lengthText, lengthUnit, stressUnit } from './ui';

/** A peak with the body it is of; run: number of the mechanism. */
export interface PlacedPeak extends Peak { run: number; body: string }

export function most(peaks: PlacedPeak[]): PlacedPeak | null {
  return peaks.reduce<PlacedPeak | null>((best, p) => (p.value > (best?.value ?? 0) ? p : best), null);
}

const kinds = [
  { field: 1, name: 'Displacement', of: (m: Mechanism) => m.displacements },
  { field: 5, name: 'Von Mises stress', of: (m: Mechanism) => m.stresses },
];

/** Facts for the head of the page and a table; `show` is called with the peak that is clicked and the field it is of. */
export class LargestValues {
  readonly facts: [HTMLElement, HTMLElement][] = [];
  readonly element = h('section', { class: 'card largest', 'aria-label': 'Largest values' });
  private marked: PlacedPeak | null = null;

  constructor(private readonly mechanisms: Mechanism[], private readonly fromWhere: () => string,
              private readonly show: (peak: PlacedPeak, field: number) => void) {
    this.refresh();
  }

  private all(kind: (typeof kinds)[number]): PlacedPeak[] {
    return this.mechanisms.flatMap((m, run) => kind.of(m).filter((p) => p.value > 0).map((p) => ({ ...p, run })));
  }

  private text(field: number, value: number): string {
    if (field === 1) return lengthText(value, 4);
    const { factor, unit } = stressUnit(value);
    return `${figure(value * factor, 4)} ${unit}`;
  }

  /** "(1.5, 0, −3) mm": in the undeformed body. */
  private place(p: PlacedPeak): string {
    const { surface } = this.mechanisms[p.run].body(p.body)!.deformed!;
    const { factor, unit } = lengthUnit(surface.size);
    return `(${surface.position(p.vertex).toArray().map((x) => figure(Math.abs(x) < 1e-6 * surface.size ? 0 : x * factor, 4)).join(', ')}) ${unit}`;
  }

  private button(p: PlacedPeak, field: number, text: string): HTMLElement {
    const name = this.mechanisms[p.run].run.header.name;
    return h('button', { class: 'value', type: 'button', 'data-peak': field, title: `${field === 1 ? `|u| ${this.fromWhere()}` : 'von Mises'}, ${p.body} of ${name}, vertex ${p.vertex} at ${this.place(p)}: a click shows it`,
                         onclick: () => {
      this.clear();
      this.marked = p;
      this.mechanisms[p.run].body(p.body)!.deformed!.mark(p.vertex);
      this.show(p, field);
    } }, text);
  }

  /** Takes the dot away. */
  clear(): void {
    if (this.marked) this.mechanisms[this.marked.run].body(this.marked.body)!.deformed!.mark(-1);
    this.marked = null;
  }

  refresh(): void {
    this.facts.length = 0;
    const rows: HTMLElement[] = [];
    for (const kind of kinds) {
      const peaks = this.all(kind);
      const first = most(peaks);
      if (first) {
        this.facts.push([h('dt', {}, kind.field === 1 ? 'Largest |u|' : 'Largest stress'),
                         h('dd', {}, this.button(first, kind.field, `${this.text(kind.field, first.value)} at ${figure(first.time, 4)} s`))]);
      }
      for (const p of peaks) {
        rows.push(h('tr', {}, h('td', {}, kind.name), h('td', {}, this.mechanisms[p.run].run.header.name), h('td', {}, p.body),
                    h('td', { class: 'number' }, this.button(p, kind.field, this.text(kind.field, p.value))),
                    h('td', { class: 'number' }, `${figure(p.time, 4)} s`), h('td', {}, this.place(p))));
      }
    }
    this.element.hidden = rows.length === 0;
    // Colours are sums of shapes; the results' own stress holds what loads and accelerations inside a body add.
    const beside = this.all(kinds[1]).filter((p) => p.drawn !== undefined && Math.abs(p.drawn - p.value) > 0.01 * p.value);
    const left = beside.length === 0 ? '' : ` Colours show the stress of the shapes alone, without what accelerations and loads inside the body add: ${beside.map((p) => `${this.text(5, p.drawn!)} in place of ${this.text(5, p.value)} (${p.body})`).join(', ')}.`;
    this.element.replaceChildren(h('header', {}, h('h2', {}, 'Largest values')),
      h('p', { class: 'hint' }, `Of all stored times and all vertices of the surface; displacement ${this.fromWhere()}. A click shows the place and the time.${left}`),
      h('div', {}, h('table', { class: 'quantities' }, h('thead', {}, h('tr', {}, ...['Of', 'Run', 'Body', 'Largest', 'Time', 'Place in the body']
        .map((c) => h('th', { scope: 'col', class: ['Largest', 'Time'].includes(c) ? 'number' : undefined }, c)))), h('tbody', {}, ...rows))));
  }
}
