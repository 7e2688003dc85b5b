// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// The list of modes: sorted by any column, searched by number, kind or frequency range; modes struck out for the part
// file or for a body of a mechanism file.
import { download, figure, h, icon, iconButton, say } from './ui';

export interface ModeRow {
  set: string; // modes are shown one set at a time
  number: number;
  kind: string;
  detail: string; // more of it, for the caption
  frequency: number; // [Hz]; NaN, as the next two, where it has none: a constraint mode
  damping: number; // ratio
  effective_mass: number[]; // along x, y, z [kg], about x, y, z [kg m^2]
  can_strike: boolean; // strike_modes of the part file means it by its number
}

interface Column {
  name: string;
  title: string;
  value: (m: ModeRow) => number | string;
  text: (m: ModeRow) => string;
  heat?: number;
}

export class ModeTable {
  readonly element: HTMLElement;
  readonly struckLine: HTMLElement;
  private readonly body = h('tbody', {});
  private readonly search: HTMLInputElement;
  private readonly rows: HTMLTableRowElement[];
  private readonly count = h('span', { class: 'count', role: 'status' });
  private readonly columns: Column[];
  private shown: number[] = [];
  private selected = -1;
  private sort = { column: 0, up: true };
  private readonly out = new Set<number>();
  private readonly heads: HTMLTableCellElement[];
  private readonly sets: string[];
  private readonly setButtons: HTMLButtonElement[];
  set: string;

  /** whole: the body's mass (three times) and moments of inertia about its centre. */
  constructor(private readonly modes: ModeRow[], whole: number[], choose: (mode: number) => void) {
    const effective = ['x', 'y', 'z', 'rx', 'ry', 'rz'].map((name, i): Column => ({
      name, heat: i, value: (m) => m.effective_mass[i], text: (m) => percent(m.effective_mass[i] / whole[i]),
      title: i < 3 ? `Effective mass along ${name}, percent of the body's` :
        `Effective moment of inertia about ${name[1]}, percent of the body's`,
    }));
    this.columns = [
      { name: 'No', title: 'Number', value: (m) => m.number, text: (m) => String(m.number) },
      { name: 'Hz', title: 'Frequency [Hz]', value: (m) => m.frequency, text: (m) => known(m.frequency, 5) },
      { name: 'Kind', title: 'Kind', value: (m) => m.kind, text: (m) => m.kind },
      { name: 'ζ %', title: 'Damping ratio [%]', value: (m) => m.damping, text: (m) => known(100 * m.damping, 3) },
      ...effective,
    ];
    this.rows = modes.map((m, i) => {
      const keep = m.frequency > 0 && h('input', { type: 'checkbox', checked: true, 'aria-label': `Keep mode ${m.number}`,
                                title: 'Keep this mode', onchange: (e: Event) => this.strike(i, !(e.target as HTMLInputElement).checked),
                                onclick: (e: Event) => e.stopPropagation() });
      const cells = this.columns.map((c) => {
        const cell = h('td', { class: c.name === 'Kind' ? 'kind' : 'number' }, c.text(m));
        if (c.heat !== undefined) {
          const part = Math.min(1, Math.abs(c.value(m) as number) / whole[c.heat]);
          if (part > 0.005) cell.style.setProperty('--heat', `${Math.round(55 * Math.sqrt(part))}%`);
          else cell.classList.add('none');
          if (!Number.isNaN(part)) cell.title = `${c.title}: ${figure(m.effective_mass[c.heat], 4)} ${c.heat < 3 ? 'kg' : 'kg m²'}`;
        }
        return cell;
      });
      return h('tr', { tabindex: -1, 'aria-selected': 'false', 'data-mode': m.number, onclick: () => choose(i),
                       onkeydown: (e: Event) => {
                         if ((e as KeyboardEvent).key === 'Enter') choose(i);
                       } }, h('td', { class: 'keep' }, keep), ...cells);
    });
    this.heads = this.columns.map((c, i) => h('th', { scope: 'col', 'aria-sort': 'none', title: c.title },
      h('button', { type: 'button', onclick: () => this.sortBy(i) }, c.name)));
    this.search = h('input', { type: 'search', id: 'search', placeholder: 'no, kind, 100..500 Hz',
                               'aria-label': 'Search the modes', oninput: () => this.filter() });
    this.element = h('div', { class: 'modes' },
      h('div', { class: 'panel-head' }, h('h2', {}, 'Modes'), this.count,
        h('label', { class: 'search' }, icon('search'), this.search),
        iconButton('table', 'Save this list as CSV', () => download('modes.csv', this.csv(), 'text/csv'))),
      h('div', { class: 'table-box' }, h('table', { role: 'grid', 'aria-label': 'Modes' },
        h('thead', {}, h('tr', { class: 'over' }, h('td', { colspan: 5 }),
                         h('th', { colspan: 3, scope: 'colgroup' }, 'effective mass %'),
                         h('th', { colspan: 3, scope: 'colgroup' }, 'inertia %')),
          h('tr', {}, h('th', { scope: 'col', class: 'keep', title: 'Kept modes' }, '✓'), ...this.heads)), this.body)));
    this.sets = [...new Set(modes.map((m) => m.set))];
    this.set = this.sets[0] ?? '';
    this.setButtons = this.sets.map((name) => h('button', { type: 'button', role: 'tab', onclick: () => this.showSet(name) },
                                                name || 'modes'));
    if (this.sets.length > 1) {
      this.element.querySelector('.panel-head')!.after(
        h('div', { class: 'tabs sets', role: 'tablist', 'aria-label': 'Sets of modes' }, ...this.setButtons));
    }
    this.struckLine = h('div', { class: 'struck' });
    this.refreshStruck();
    this.filter();
  }

  focusSearch(): void {
    this.search.focus();
    this.search.select();
  }

  showSet(name: string): void {
    this.set = name;
    this.refreshStruck();
    this.filter();
  }

  select(mode: number): void {
    if (this.modes[mode] && this.modes[mode].set !== this.set) this.showSet(this.modes[mode].set);
    this.rows[this.selected]?.setAttribute('aria-selected', 'false');
    this.rows.forEach((r) => (r.tabIndex = -1));
    this.selected = mode;
    const row = this.rows[mode];
    if (!row) return;
    row.setAttribute('aria-selected', 'true');
    row.tabIndex = 0;
    // Only the list scrolls, never the page under the reader.
    const box = this.body.closest<HTMLElement>('.table-box');
    const head = this.body.previousElementSibling as HTMLElement | null;
    if (!box?.clientHeight) return;
    const above = row.offsetTop - (head?.offsetHeight ?? 0) - box.scrollTop;
    const below = row.offsetTop + row.offsetHeight - box.scrollTop - box.clientHeight;
    if (above < 0) box.scrollTop += above;
    else if (below > 0) box.scrollTop += below;
  }

  /** The mode `by` rows further in the list as it is shown; -1 at its ends. */
  neighbour(by: number): number {
    const at = this.shown.indexOf(this.selected);
    return this.shown[at < 0 ? 0 : at + by] ?? -1;
  }

  /** Modes of the free body that the part file strikes out, by their numbers. */
  struck(): number[] {
    return [...this.out].filter((i) => this.modes[i].can_strike).sort((a, b) => a - b).map((i) => this.modes[i].number);
  }

  /** Modes of the set shown that are left, numbered as `modes` of a body means them: without rigid motions. */
  private kept(): number[] {
    const elastic = [...this.modes.keys()].filter((i) => this.modes[i].set === this.set && this.modes[i].frequency > 0);
    return elastic.flatMap((i, k) => (this.out.has(i) ? [] : [k + 1]));
  }

  private strike(mode: number, out: boolean): void {
    if (out) this.out.add(mode);
    else this.out.delete(mode);
    this.rows[mode].classList.toggle('out', out);
    this.refreshStruck();
  }

  private refreshStruck(): void {
    const lines: [string, string][] = [];
    const struck = this.struck();
    if (struck.length) lines.push([`strike_modes = [${struck.join(', ')}]`, 'Copy this line for [modes] of the part file']);
    const kept = this.kept();
    if (kept.length && [...this.out].some((i) => this.modes[i].set === this.set))
      lines.push([`modes = "${ranges(kept)}"`, 'Copy this line for a body of a mechanism file whose eigenmodes these are']);
    if (!lines.length) {
      this.struckLine.replaceChildren(h('span', { class: 'hint' }, kept.length
        ? 'Untick modes to strike them out of the part (those of the free body) or of a mechanism.' : ''));
      return;
    }
    this.struckLine.replaceChildren(...lines.map(([line, title]) => h('div', { title }, h('code', {}, line),
      iconButton('copy', title, () => {
        navigator.clipboard.writeText(line).then(() => say('Copied'), () => say('Select the line and copy it'));
      }))));
  }

  private sortBy(column: number): void {
    this.sort = { column, up: this.sort.column === column ? !this.sort.up : column < 3 };
    this.filter();
  }

  private filter(): void {
    const words = this.search.value.trim().toLowerCase();
    const range = /^\s*([\d.e+]*)\s*\.\.\s*([\d.e+]*)\s*(hz)?\s*$/.exec(words);
    const fits = (m: ModeRow) => {
      if (m.set !== this.set) return false;
      if (!words) return true;
      if (range) {
        return m.frequency >= (range[1] ? Number(range[1]) : -Infinity)
          && m.frequency <= (range[2] ? Number(range[2]) : Infinity);
      }
      return String(m.number) === words || m.kind.toLowerCase().includes(words)
        || figure(m.frequency, 5).replace(/\s/g, '').startsWith(words);
    };
    const { value } = this.columns[this.sort.column];
    const sign = this.sort.up ? 1 : -1;
    this.shown = this.modes.map((_, i) => i).filter((i) => fits(this.modes[i])).sort((i, j) => {
      const a = value(this.modes[i]);
      const b = value(this.modes[j]);
      return (typeof a === 'string' ? a.localeCompare(String(b)) : a - (b as number)) * sign || i - j;
    });
    this.heads.forEach((head, i) => head.setAttribute('aria-sort', i !== this.sort.column ? 'none'
      : this.sort.up ? 'ascending' : 'descending'));
    this.body.replaceChildren(...this.shown.map((i) => this.rows[i]));
    const all = this.modes.filter((m) => m.set === this.set).length;
    this.count.textContent = this.shown.length === all ? `${all}` : `${this.shown.length} of ${all}`;
    this.setButtons.forEach((b, i) => b.setAttribute('aria-selected', String(this.sets[i] === this.set)));
  }

  private csv(): string {
    const lines = this.shown.map((i) => {
      const m = this.modes[i];
      return [`"${m.set}"`, m.number, `"${m.kind}"`, ...[m.frequency, m.damping, ...m.effective_mass].map((x) => (Number.isNaN(x) ? '' : x))].join(',');
    });
    return ['set,number,kind,frequency [Hz],damping ratio,m_x [kg],m_y [kg],m_z [kg],J_x [kg m^2],J_y [kg m^2],J_z [kg m^2]',
            ...lines, ''].join('\n');
  }
}

/** A part of the whole in percent, in little room. */
function percent(part: number): string {
  const p = 100 * part;
  if (!Number.isFinite(p)) return '';
  return p < 0.005 ? '0' : p < 9.995 ? p.toFixed(2) : p.toFixed(1);
}

/** A number, or nothing where there is none. */
function known(value: number, digits: number): string {
  return Number.isNaN(value) ? '' : figure(value, digits);
}

/** 1, 2, 3, 7 as "1-3, 7". */
function ranges(numbers: number[]): string {
  const runs: [number, number][] = [];
  for (const n of numbers) {
    const last = runs[runs.length - 1];
    if (last && last[1] === n - 1) last[1] = n;
    else runs.push([n, n]);
  }
  return runs.map(([a, b]) => (a === b ? `${a}` : `${a}-${b}`)).join(', ');
}
