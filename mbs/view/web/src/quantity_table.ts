// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Every stored quantity of every run with its value at the current time; a click plots it.
import type { Run, RunHeader } from './motion_data';
import { figure, h, icon, unitText } from './ui';

type Quantity = RunHeader['quantities'][number];

export class QuantityTable {
  readonly elements: HTMLElement[];
  private readonly cells = new Map<Quantity, HTMLTableCellElement[]>();
  private isOpen = false;
  private least: Map<string, number>[] = []; // of each run, by unit: what is round-off

  constructor(private readonly runs: Run[], private readonly all: Quantity[], plot: (name: string) => void) {
    const rows = all.map((q) => {
      const cells = runs.map(() => h('td', { class: 'number' }));
      this.cells.set(q, cells);
      return h('tr', { tabindex: 0, title: q.doc || 'Click to plot', onclick: () => plot(q.name),
                       onkeydown: (e: Event) => { if ((e as KeyboardEvent).key === 'Enter') plot(q.name); } },
               h('td', {}, q.name), ...cells, h('td', { class: 'unit' }, unitText(q.unit)));
    });
    const filter = h('input', { type: 'search', placeholder: 'Search quantities', 'aria-label': 'Search quantities', oninput: () => {
      const words = filter.value.toLowerCase();
      for (const row of rows) row.hidden = !row.textContent!.toLowerCase().includes(words);
    } });
    this.elements = [h('label', { class: 'search wide' }, icon('search'), filter),
      h('table', { class: 'quantities' }, h('thead', {}, h('tr', {}, h('th', { scope: 'col' }, 'Quantity'),
        ...runs.map((r) => h('th', { scope: 'col', class: 'number' }, r.header.name)), h('th', { scope: 'col' }, 'Unit'))),
        h('tbody', {}, ...rows))];
  }

  /** Its values are decoded when it is first seen. */
  show(on: boolean, time: number): void {
    this.isOpen = on;
    if (on) void Promise.all(this.runs.flatMap((r) => this.all.map((q) => r.quantity(q.name)))).then(() => this.refresh(time));
  }

  refresh(time: number): void {
    if (!this.isOpen) return;
    if (!this.least.length) {
      const units = [...new Set(this.all.map((q) => q.unit))];
      this.least = this.runs.map((r) => new Map(units.map((unit) => [unit, 1e-14 * r.scaleOf(unit)])));
    }
    for (const [q, cells] of this.cells) {
      this.runs.forEach((r, i) => {
        const v = r.valueAt(q.name, time);
        cells[i].textContent = v === null ? '' : figure(Math.abs(v) < (this.least[i].get(q.unit) ?? 0) ? 0 : v, 5);
      });
    }
  }
}
