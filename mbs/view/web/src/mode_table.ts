// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// The list of modes: sorted by any column, searched by number, kind or frequency range, modes struck out for the part
// file.
import { download, figure, h, icon, iconButton, say } from './ui';

export interface ModeRow {
  number: number;
  kind: string;
  frequency: number; // [Hz]
  damping: number; // ratio
  effective_mass: number[]; // along x, y, z [kg], about x, y, z [kg m^2]
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

  constructor(private readonly modes: ModeRow[], choose: (mode: number) => void) {
    const effective = ['x', 'y', 'z', 'rx', 'ry', 'rz'].map((name, i): Column => ({
      name, heat: i, value: (m) => m.effective_mass[i] ?? 0, text: (m) => short(m.effective_mass[i] ?? 0),
      title: i < 3 ? `Effective mass along ${name} [kg]` : `Effective mass about ${name[1]} [kg m²]`,
    }));
    this.columns = [
      { name: 'No', title: 'Number', value: (m) => m.number, text: (m) => String(m.number) },
      { name: 'Hz', title: 'Frequency [Hz]', value: (m) => m.frequency, text: (m) => figure(m.frequency, 5) },
      { name: 'Kind', title: 'Kind', value: (m) => m.kind, text: (m) => m.kind },
      { name: 'ζ %', title: 'Damping ratio [%]', value: (m) => m.damping, text: (m) => figure(100 * m.damping, 3) },
      ...effective,
    ];
    const most = effective.map((c) => Math.max(1e-300, ...modes.map((m) => Math.abs(c.value(m) as number))));
    this.rows = modes.map((m, i) => {
      const keep = h('input', { type: 'checkbox', checked: true, 'aria-label': `Keep mode ${m.number}`,
                                title: 'Keep this mode', onchange: () => this.strike(i, !keep.checked),
                                onclick: (e: Event) => e.stopPropagation() });
      const cells = this.columns.map((c) => {
        const cell = h('td', { class: c.name === 'Kind' ? 'kind' : 'number' }, c.text(m));
        if (c.heat !== undefined) {
          const part = Math.abs(c.value(m) as number) / most[c.heat];
          if (part > 0.005) cell.style.setProperty('--heat', `${Math.round(60 * part)}%`);
          cell.title = `${c.title}: ${figure(m.effective_mass[c.heat] ?? 0, 4)}`;
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
    this.search = h('input', { type: 'search', id: 'search', placeholder: 'number, kind or 100..500 Hz',
                               'aria-label': 'Search the modes', oninput: () => this.filter() });
    this.element = h('div', { class: 'modes' },
      h('div', { class: 'panel-head' }, h('h2', {}, 'Modes'), this.count,
        h('label', { class: 'search' }, icon('search'), this.search),
        iconButton('table', 'Save this list as CSV', () => download('modes.csv', this.csv(), 'text/csv'))),
      h('div', { class: 'table-box' }, h('table', { role: 'grid', 'aria-label': 'Modes' },
        h('thead', {}, h('tr', { class: 'over' }, h('td', { colspan: 5 }),
                         h('th', { colspan: 3, scope: 'colgroup' }, 'effective mass [kg]'),
                         h('th', { colspan: 3, scope: 'colgroup' }, '[kg m²]')),
          h('tr', {}, h('th', { scope: 'col', class: 'keep', title: 'Kept modes' }, '✓'), ...this.heads)), this.body)));
    this.struckLine = h('div', { class: 'struck' });
    this.refreshStruck();
    this.filter();
  }

  focusSearch(): void {
    this.search.focus();
    this.search.select();
  }

  select(mode: number): void {
    this.rows[this.selected]?.setAttribute('aria-selected', 'false');
    this.rows.forEach((r) => (r.tabIndex = -1));
    this.selected = mode;
    const row = this.rows[mode];
    if (!row) return;
    row.setAttribute('aria-selected', 'true');
    row.tabIndex = 0;
    row.scrollIntoView({ block: 'nearest' });
  }

  /** The mode `by` rows further in the list as it is shown; -1 at its ends. */
  neighbour(by: number): number {
    const at = this.shown.indexOf(this.selected);
    return this.shown[at < 0 ? 0 : at + by] ?? -1;
  }

  struck(): number[] {
    return [...this.out].sort((a, b) => a - b).map((i) => this.modes[i].number);
  }

  private strike(mode: number, out: boolean): void {
    if (out) this.out.add(mode);
    else this.out.delete(mode);
    this.rows[mode].classList.toggle('out', out);
    this.refreshStruck();
  }

  private refreshStruck(): void {
    const struck = this.struck();
    if (!struck.length) {
      this.struckLine.replaceChildren(h('span', { class: 'hint' }, 'Untick modes to strike them out.'));
      return;
    }
    const line = `strike_modes = [${struck.join(', ')}]`;
    this.struckLine.replaceChildren(h('code', {}, line), iconButton('copy', 'Copy this line for the part file', () => {
      navigator.clipboard.writeText(line).then(() => say('Copied'), () => say('Select the line and copy it'));
    }));
  }

  private sortBy(column: number): void {
    this.sort = { column, up: this.sort.column === column ? !this.sort.up : column < 3 };
    this.filter();
  }

  private filter(): void {
    const words = this.search.value.trim().toLowerCase();
    const range = /^\s*([\d.e+]*)\s*\.\.\s*([\d.e+]*)\s*(hz)?\s*$/.exec(words);
    const fits = (m: ModeRow) => {
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
    this.count.textContent = this.shown.length === this.modes.length ? `${this.modes.length}`
      : `${this.shown.length} of ${this.modes.length}`;
  }

  private csv(): string {
    const lines = this.shown.map((i) => {
      const m = this.modes[i];
      return [m.number, `"${m.kind}"`, m.frequency, m.damping, ...m.effective_mass].join(',');
    });
    return ['number,kind,frequency [Hz],damping ratio,m_x [kg],m_y [kg],m_z [kg],J_x [kg m^2],J_y [kg m^2],J_z [kg m^2]',
            ...lines, ''].join('\n');
  }
}

/** Three digits in little room. */
function short(value: number): string {
  const size = Math.abs(value);
  if (size < 1e-12) return '0';
  if (size >= 0.01 && size < 9999.5) return value.toPrecision(3).replace(/e.*/, '');
  return value.toExponential(0).replace('e-', 'e−').replace('e+', 'e');
}
