// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Linked plots of stored quantities: one cursor, one zoom, the current time marked in all of them.
import uPlot from 'uplot';
import type { Run } from './motion_data';
import { spectrum } from './spectrum';
import { cssColor, figure, h, tick, unitText } from './ui';

interface Curve { run: Run; name: string; unit: string; dash: number[]; width: number }

const plotHeight = 172; // [px]
const paperWidth = 690; // [px], of A4 between its margins
const dashes = [[], [7, 4], [2, 3], [9, 3, 2, 3]];

/** The same dashes for a line of the legend. */
function dashed(dash: number[]): string {
  let at = 0;
  const stops = dash.map((length, i) => `${i % 2 ? 'transparent' : 'var(--color)'} ${at}px ${at += length}px`);
  return stops.length ? `--dash: repeating-linear-gradient(90deg, ${stops.join(', ')})` : '';
}

/** What is smaller than this part of the largest value in a plot is round-off or left by the solver, and written as 0. */
const roundOff = 1e-9;

/** A run's values less those of the first run at the same times, linear between its rows; only where both have values. */
export function differences(time: ArrayLike<number>, values: ArrayLike<number>, first: Run, name: string): Float64Array {
  return Float64Array.from({ length: time.length }, (_, i) => {
    const t = time[i];
    if (t < first.time[0] || t > first.time[first.time.length - 1]) return NaN;
    return values[i] - (first.valueAt(name, t) ?? NaN);
  });
}

/** The range of an axis: a little room, and for what is constant up to round-off a range of its own size. */
function roomy(_: uPlot, low: number, high: number): [number, number] {
  const size = Math.max(Math.abs(low), Math.abs(high));
  if (!(high - low > 1e-8 * size)) return size > 0 ? [(low + high - size) / 2, (low + high + size) / 2] : [-1, 1];
  const room = 0.06 * (high - low);
  return [low - room, high + room];
}

/** Dotted lines at the orders of a speed that lie in view, the finest that leave room for their numbers. */
function drawOrders(u: uPlot, turns: number): void {
  const { ctx, bbox } = u;
  const ratio = devicePixelRatio;
  const { min, max } = u.scales.x;
  const perPixel = (max! - min!) / (bbox.width / ratio);
  const step = [0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500].find((s) => s * turns > 24 * perPixel);
  if (!step) return;
  ctx.save();
  ctx.strokeStyle = ctx.fillStyle = cssColor('--muted');
  ctx.font = `${10 * ratio}px system-ui, sans-serif`;
  ctx.textAlign = 'center';
  ctx.setLineDash([ratio, 3 * ratio]);
  for (let order = Math.max(step, Math.ceil(min! / turns / step) * step); order * turns <= max!; order += step) {
    const x = u.valToPos(order * turns, 'x', true);
    ctx.beginPath();
    ctx.moveTo(x, bbox.top + 12 * ratio);
    ctx.lineTo(x, bbox.top + bbox.height);
    ctx.stroke();
    ctx.fillText(tick(order), x, bbox.top + 9 * ratio);
  }
  ctx.restore();
}

/** "energy.kinetic, energy.strain" as "energy: kinetic, strain". */
function together(names: string[]): string {
  const stems = new Set(names.map((n) => n.slice(0, n.lastIndexOf('.') + 1)));
  const [stem] = stems;
  return names.length > 1 && stems.size === 1 && stem ? `${stem.slice(0, -1)}: ${names.map((n) => n.slice(stem.length)).join(', ')}` : names.join(', ');
}

export class PlotCard {
  readonly element: HTMLElement;
  readonly curves: Curve[] = [];
  private readonly units: string[];
  private plot: uPlot | null = null;
  private readonly place = h('div', { class: 'plot' });
  private readonly values = h('dl', { class: 'plot-values' });
  private readonly playhead = h('i', { class: 'playhead' });
  private readonly orders: HTMLSelectElement;
  private spectral = false;
  private speed = ''; // whose orders a spectrum shows
  private differing = false;
  private largest = new Map<string, number>(); // by unit
  private time = 0;
  private cursor: number | null = null;

  constructor(readonly names: string[], runs: Run[], private readonly deck: PlotDeck) {
    // Runs that agree would hide each other: later ones are thinner, and dashed where dashes do not tell names apart.
    runs.forEach((run, r) => {
      names.forEach((name, i) => {
        const j = run.quantityNumber(name);
        const dash = dashes[(names.length > 1 ? i : Math.min(r, 1)) % dashes.length];
        const width = 1.6 + 1.8 * Math.max(0, Math.min(3, runs.length - 1) - r);
        if (j >= 0) this.curves.push({ run, name, unit: run.header.quantities[j].unit, dash, width });
      });
    });
    this.units = [...new Set(this.curves.map((c) => c.unit))];
    const unit = this.units.map((u) => `[${unitText(u) || '–'}]`).join(' ');
    const doc = this.curves.map((c) => c.run.header.quantities[c.run.quantityNumber(c.name)].doc).find((d) => d) ?? '';
    const spectrumButton = h('button', { class: 'toggle small', type: 'button', 'aria-pressed': 'false',
      title: 'Amplitude spectrum', onclick: () => {
        this.spectral = !this.spectral;
        spectrumButton.setAttribute('aria-pressed', String(this.spectral));
        this.orders.hidden = !this.spectral || !speeds.length;
        void this.draw();
      } }, 'Spectrum');
    // Angular velocities of the runs: their orders are marked in spectra.
    const speeds = [...new Set(runs.flatMap((r) => r.header.quantities.filter((q) => q.unit === 'rad/s').map((q) => q.name)))];
    this.orders = h('select', { class: 'small', 'aria-label': 'Orders of', title: 'Marks the orders of a speed, its mean over the run',
      hidden: true, onchange: () => { this.speed = this.orders.value; void this.draw(); } },
      h('option', { value: '' }, 'no orders'), ...speeds.map((name) => h('option', { value: name }, `orders of ${name}`)));
    const differenceButton = h('button', { class: 'toggle small', type: 'button', 'aria-pressed': 'false',
      title: `Less the run ${runs[0]?.header.name ?? ''}`, onclick: () => {
        this.differing = !this.differing;
        differenceButton.setAttribute('aria-pressed', String(this.differing));
        void this.draw();
      } }, 'Difference');
    this.element = h('article', { class: 'card', 'aria-label': `Plot of ${names.join(', ')}` },
      h('header', {}, h('h2', { title: doc }, together(names)), h('span', { class: 'unit' }, unit),
        ...(new Set(this.curves.map((c) => c.run)).size > 1 ? [differenceButton] : []), this.orders, spectrumButton,
        h('button', { class: 'icon small', type: 'button', 'aria-label': `Remove ${names.join(', ')}`, title: 'Remove',
                      onclick: () => this.deck.remove(this) }, '×')),
      this.place, this.values);
  }

  visible(): Curve[] {
    const first = this.curves[0]?.run;
    return this.curves.filter((c) => this.deck.shown(c.run) && !(this.differing && c.run === first));
  }

  /** What is plotted of a curve over time: its values, or those less the first run's. */
  private async plottedValues(c: Curve): Promise<Float64Array> {
    const values = (await c.run.quantity(c.name))!;
    if (!this.differing) return values;
    const first = this.curves.find((other) => other.name === c.name)!.run;
    if (!(await first.quantity(c.name))) return values.map(() => NaN);
    return differences(c.run.time, values, first, c.name);
  }

  async draw(): Promise<void> {
    const curves = this.visible();
    const tables = await Promise.all(curves.map(async (c): Promise<uPlot.AlignedData> => {
      const v = await this.plottedValues(c);
      if (!this.spectral) return [c.run.time as unknown as number[], v as unknown as number[]];
      const s = spectrum(c.run.time, v);
      return [s.frequency, s.amplitude];
    }));
    this.largest = new Map();
    curves.forEach(({ unit }, i) => {
      let size = this.largest.get(unit) ?? 0;
      for (const v of tables[i][1]) if (Math.abs(v ?? 0) > size) size = Math.abs(v!);
      this.largest.set(unit, size);
    });
    // Six decades below the highest line; what is lower, or zero, has no place on the logarithmic axis.
    const low = (unit: string) => 10 ** (Math.ceil(Math.log10(this.largest.get(unit)!)) - 6);
    const isLogarithmic = (unit: string) => this.spectral && this.largest.get(unit)! > 0;
    curves.forEach(({ unit }, i) => {
      if (isLogarithmic(unit)) tables[i][1] = Array.from(tables[i][1], (v) => (v !== null && v! >= low(unit) ? v : null));
    });
    const turns = this.spectral && this.speed ? await this.turnsPerSecond(curves) : 0;
    // A unit, an axis: the first at the left, the second at the right.
    const units = [...new Set(curves.map((c) => c.unit))];
    const scaleOf = (unit: string) => (unit === units[0] ? 'y' : 'y2');

    this.plot?.destroy();
    this.plot = null;
    if (!curves.length || !this.place.isConnected) return;
    const same = tables.every((t) => t[0] === tables[0][0]);
    const data = same ? [tables[0][0], ...tables.map((t) => t[1])] as uPlot.AlignedData : uPlot.join(tables);
    const axis = { stroke: cssColor('--muted'), grid: { stroke: cssColor('--line'), width: 1 },
                   ticks: { stroke: cssColor('--line'), width: 1, size: 4 }, font: '11px system-ui, sans-serif' };
    this.plot = new uPlot({
      width: this.width, height: plotHeight, padding: [8, units.length > 1 ? 0 : 16, 0, 0],
      legend: { show: false },
      scales: { x: { time: false }, ...Object.fromEntries(units.map((unit) => [scaleOf(unit), isLogarithmic(unit)
        ? { distr: 3 as const, range: [low(unit), 1e6 * low(unit)] as [number, number] } : { range: roomy }])) },
      axes: [
        { ...axis, size: 24, gap: 3, values: (_, v) => v.map((x) => tick(x)), label: this.spectral ? 'frequency [Hz]' : 'time [s]',
          labelSize: 15, labelGap: 0, labelFont: '11px system-ui, sans-serif' },
        ...units.map((unit, i) => ({ ...axis, scale: scaleOf(unit), side: (i === 0 ? 3 : 1) as uPlot.Axis.Side, size: 62, gap: 4,
          ...(i > 0 ? { grid: { show: false } } : {}), values: (_: uPlot, v: (number | null)[]) => v.map((x) => (x === null ? '' : tick(x))),
          ...(units.length > 1 ? { label: `[${unitText(unit) || '–'}]`, labelSize: 15, labelGap: 0, labelFont: '11px system-ui, sans-serif' } : {}) })),
      ],
      cursor: { sync: this.spectral ? undefined : { key: 'time', setSeries: false, scales: ['x', null] },
                drag: { x: true, y: false }, points: { size: 6 } },
      series: [{}, ...curves.map((c) => ({
        label: `${c.run.header.name}: ${c.name}`, scale: scaleOf(c.unit), stroke: cssColor(`--run${c.run.number % 6}`), width: c.width,
        dash: c.dash, spanGaps: true, points: { show: false },
      }))],
      hooks: {
        draw: turns > 0 ? [(u: uPlot) => drawOrders(u, turns)] : [],
        setCursor: [(u: uPlot) => {
          this.cursor = !this.spectral && u.cursor.left !== undefined && u.cursor.left >= 0
            ? u.posToVal(u.cursor.left, 'x') : null;
          this.showValues();
        }],
        setScale: [(u: uPlot, key: string) => {
          if (key === 'x' && !this.spectral) this.deck.zoomed(this, u.scales.x.min!, u.scales.x.max!);
          this.setTime(this.time);
        }],
      },
    }, data, this.place);
    if (!this.spectral) {
      this.plot.over.append(this.playhead);
      let pressed = 0;
      this.plot.over.addEventListener('mousedown', (e) => { pressed = e.clientX; });
      this.plot.over.addEventListener('click', (e) => {
        if (Math.abs(e.clientX - pressed) < 3) this.deck.pick(this.plot!.posToVal(e.offsetX, 'x'));
      });
    }
    this.setTime(this.time);
  }

  /** The mean of the chosen speed's size over the run, in turns per second. */
  private async turnsPerSecond(curves: Curve[]): Promise<number> {
    for (const { run } of curves) {
      const v = await run.quantity(this.speed);
      if (v?.length) return v.reduce((sum, x) => sum + Math.abs(x), 0) / v.length / (2 * Math.PI);
    }
    return 0;
  }

  private get width(): number {
    return this.deck.isPrinting ? paperWidth : this.place.clientWidth || 400;
  }

  resize(): void {
    this.plot?.setSize({ width: this.width, height: plotHeight });
    this.setTime(this.time);
  }

  zoom(min: number, max: number): void {
    if (this.plot && !this.spectral) this.plot.setScale('x', { min, max });
  }

  setTime(t: number): void {
    this.time = t;
    if (this.plot && !this.spectral) {
      const x = this.plot.valToPos(t, 'x');
      this.playhead.style.transform = `translateX(${x.toFixed(1)}px)`;
      this.playhead.hidden = !(x >= 0 && x <= this.plot.over.clientWidth);
    }
    this.showValues();
  }

  private showValues(): void {
    const t = this.cursor ?? this.time;
    const rows = this.visible().map((c) => {
      const value = c.run.valueAt(c.name, t);
      const base = this.differing ? this.curves.find((other) => other.name === c.name)!.run.valueAt(c.name, t) : 0;
      const v = value === null || base === null ? null : value - base;
      const mark = h('i', { style: `--color: var(--run${c.run.number % 6}); --width: ${Math.max(2, c.width)}px;${dashed(c.dash)}` });
      const several = new Set(this.curves.map((other) => other.run)).size > 1;
      const label = this.names.length === 1 ? c.run.header.name : several ? `${c.run.header.name}: ${c.name}` : c.name;
      const unit = this.units.length > 1 ? ` ${unitText(c.unit)}` : '';
      const isNothing = v !== null && !this.spectral && Math.abs(v) < roundOff * (this.largest.get(c.unit) ?? 0);
      return h('div', {}, h('dt', {}, mark, h('span', {}, label)), h('dd', {}, v === null ? '…' : `${figure(isNothing ? 0 : v, 5)}${unit}`));
    });
    this.values.replaceChildren(...rows);
  }

  /** The curves as they are shown: of the zoomed range, or the spectra. */
  async shown(): Promise<{ run: string; x: string; head: string; abscissa: number[]; values: number[] }[]> {
    const { min, max } = this.plot?.scales.x ?? {};
    return Promise.all(this.visible().map(async (c) => {
      const v = await this.plottedValues(c);
      const s = this.spectral ? spectrum(c.run.time, v) : { frequency: [...c.run.time], amplitude: [...v] };
      const inside = s.frequency.flatMap((x, i) => (x >= (min ?? -Infinity) && x <= (max ?? Infinity) ? [i] : []));
      return { run: c.run.header.name, x: this.spectral ? 'frequency [Hz]' : 'time [s]',
               head: `${this.spectral ? 'amplitude of ' : ''}${this.differing ? 'difference of ' : ''}${c.name} [${c.unit}]`,
               abscissa: inside.map((i) => s.frequency[i]), values: inside.map((i) => s.amplitude[i]) };
    }));
  }

  /** What is plotted, for scripts. */
  async plotted(): Promise<{ run: string; name: string; unit: string; time: Float64Array; values: Float64Array }[]> {
    return Promise.all(this.visible().map(async (c) => ({
      run: c.run.header.name, name: c.name, unit: c.unit, time: c.run.time, values: await this.plottedValues(c),
    })));
  }
}

export class PlotDeck {
  readonly element = h('div', { class: 'deck' });
  readonly cards: PlotCard[] = [];
  isPrinting = false;
  private zooming = false;
  private time = 0;

  constructor(private readonly runs: Run[], readonly shown: (run: Run) => boolean,
              readonly pick: (t: number) => void) {
    new ResizeObserver(() => this.cards.forEach((c) => c.resize())).observe(this.element);
    // Before the theme changes, which draws all plots anew.
    addEventListener('beforeprint', () => { this.isPrinting = true; }, true);
    addEventListener('afterprint', () => { this.isPrinting = false; }, true);
  }

  /** A plot has two axes: quantities in more units come into several. */
  async add(names: string[]): Promise<void> {
    const unitOf = (name: string) => this.runs.flatMap((r) => r.header.quantities.filter((q) => q.name === name))[0]?.unit;
    const units = [...new Set(names.map(unitOf))];
    for (let i = 0; i < units.length; i += 2) await this.addCard(names.filter((n) => units.slice(i, i + 2).includes(unitOf(n))));
  }

  private async addCard(names: string[]): Promise<void> {
    const card = new PlotCard(names, this.runs, this);
    if (!card.curves.length) return;
    this.cards.push(card);
    this.element.append(card.element);
    card.setTime(this.time);
    await card.draw();
    card.setTime(this.time);
  }

  remove(card: PlotCard): void {
    this.cards.splice(this.cards.indexOf(card), 1);
    card.element.remove();
  }

  redraw(): void {
    for (const card of this.cards) void card.draw();
  }

  setTime(t: number): void {
    this.time = t;
    for (const card of this.cards) card.setTime(t);
  }

  zoomed(source: PlotCard, min: number, max: number): void {
    if (this.zooming) return;
    this.zooming = true;
    for (const card of this.cards) if (card !== source) card.zoom(min, max);
    this.zooming = false;
  }

  /** The curves shown, as columns: those of a run over the same times (or frequencies) share the first one. */
  async csv(): Promise<string> {
    const columns: { head: string; values: ArrayLike<number> }[] = [];
    const groups = new Map<string, { head: string; values: number[] }[]>();
    for (const c of (await Promise.all(this.cards.map((card) => card.shown()))).flat()) {
      const key = `${c.run}: ${c.x} ${c.abscissa[0]} ${c.abscissa.at(-1)} ${c.abscissa.length}`;
      const group = groups.get(key) ?? [{ head: `${c.run}: ${c.x}`, values: c.abscissa }];
      groups.set(key, [...group, { head: `${c.run}: ${c.head}`, values: c.values }]);
    }
    for (const group of groups.values()) columns.push(...group);
    const rows = Math.max(0, ...columns.map((c) => c.values.length));
    const lines = [columns.map((c) => `"${c.head.replace(/"/g, '""')}"`).join(',')];
    for (let i = 0; i < rows; ++i) lines.push(columns.map((c) => (i < c.values.length ? String(c.values[i]) : '')).join(','));
    return lines.join('\n') + '\n';
  }
}
