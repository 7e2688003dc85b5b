// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// The colour scale beside a picture: on the page, and painted into saved pictures.
import { scaleStops, type ScaleName } from './colormap';
import { cssColor, figure, h } from './ui';

export interface LegendContent {
  title: string; // "|u| [mm]"
  scale: ScaleName;
  low: number;
  high: number; // both in the title's unit
  note: string;
}

export class Legend {
  readonly element: HTMLElement;
  private content: LegendContent | null = null;

  constructor(private readonly isLeft = false) {
    this.element = h('figure', { class: isLeft ? 'legend left' : 'legend', 'aria-label': 'Colour scale', hidden: true });
  }

  /** null hides it. */
  show(content: LegendContent | null): void {
    this.content = content;
    this.element.hidden = !content;
    if (!content) return;
    this.element.replaceChildren(
      h('figcaption', {}, content.title),
      h('div', { class: 'legend-body' },
        h('div', { class: 'legend-bar', style: `--scale: ${scaleStops(content.scale).join(', ')}` }),
        h('ol', {}, ...this.ticks().map((t) => h('li', {}, t)))),
      h('small', {}, content.note));
  }

  /** What it hides of the picture's edge [px]; on small screens it stands below. */
  get covered(): number {
    return this.element.hidden || getComputedStyle(this.element).position === 'static' ? 0 : this.element.offsetWidth + 14;
  }

  private ticks(): string[] {
    const { low, high } = this.content!;
    return [4, 3, 2, 1, 0].map((i) => figure(low + ((high - low) * i) / 4, 3));
  }

  /** In the upper right corner of a picture of this width, or on its left; `scale` pixels for each CSS pixel. */
  paint(g: CanvasRenderingContext2D, width: number, scale: number): void {
    if (!this.content) return;
    const [w, height, bar] = [96 * scale, 168 * scale, 13 * scale];
    const right = this.isLeft ? 172 * scale : width - 22 * scale;
    const [x, y] = [right - w, 44 * scale];
    const gradient = g.createLinearGradient(0, y + height, 0, y);
    const stops = scaleStops(this.content.scale);
    stops.forEach((color, i) => gradient.addColorStop(i / (stops.length - 1), color));
    g.fillStyle = gradient;
    g.fillRect(x, y, bar, height);
    g.fillStyle = cssColor('--ink') || '#000';
    g.textBaseline = 'middle';
    g.font = `600 ${12 * scale}px system-ui, sans-serif`;
    g.textAlign = 'right'; // long titles go to the left, over the scale
    g.fillText(this.content.title, right, y - 16 * scale);
    g.textAlign = 'left';
    g.font = `${12 * scale}px system-ui, sans-serif`;
    this.ticks().forEach((t, i) => g.fillText(t, x + bar + 8 * scale, y + (height * i) / 4));
    g.font = `${11 * scale}px system-ui, sans-serif`;
    g.textAlign = 'right';
    g.fillText(this.content.note, right, y + height + 18 * scale);
    g.textAlign = 'left';
  }
}
