// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// What a report page gains by its script: light and dark, sorting, values under the pointer, numbers and CSV.  The page
// reads and prints without it.
import './theme.css';
import './report.css';
import { download, figure, h, iconButton, themeButton } from './ui';

interface Curve { name: string; x: (number | null)[]; y: (number | null)[]; labels: string[] }
interface PlotData { title: string; x: string; y: string; curves: Curve[] }

const fileName = (text: string) => `${text.trim().replace(/[^\w.-]+/g, '_') || 'table'}.csv`;
const quoted = (text: string) => `"${text.replace(/"/g, '""')}"`;

function csvButton(name: string, text: () => string): HTMLElement {
  return h('div', { class: 'card-buttons' }, iconButton('table', `Save ${name || 'this table'} as CSV`,
                                                        () => download(fileName(name), text(), 'text/csv')));
}

// --- tables ----------------------------------------------------------------------------------------------------------
function sortable(table: HTMLTableElement): void {
  const body = table.tBodies[0];
  const rows = [...body.rows];
  const heads = [...table.tHead!.rows[0].cells] as HTMLTableCellElement[];
  const key = (row: HTMLTableRowElement, c: number): number | string => {
    const cell = row.cells[c];
    return cell.dataset.value !== undefined ? Number(cell.dataset.value) : cell.textContent!.trim();
  };
  heads.forEach((head, c) => {
    head.setAttribute('aria-sort', 'none');
    const button = h('button', { type: 'button', title: 'Sort by this column' }, ...head.childNodes as unknown as Node[]);
    head.replaceChildren(button);
    button.addEventListener('click', () => {
      const up = head.getAttribute('aria-sort') !== 'ascending';
      for (const other of heads) other.setAttribute('aria-sort', 'none');
      head.setAttribute('aria-sort', up ? 'ascending' : 'descending');
      body.replaceChildren(...[...rows].sort((a, b) => {
        const [p, q] = [key(a, c), key(b, c)];
        // Numbers come before words.
        const order = typeof p === 'number' && typeof q === 'number' ? p - q
          : typeof p === 'number' ? -1 : typeof q === 'number' ? 1 : p.localeCompare(q);
        return up ? order : -order;
      }));
    });
  });
  table.closest('.card')?.append(csvButton(table.caption?.textContent ?? '', () => {
    const lines = [heads.map((cell) => quoted(cell.textContent!)).join(',')];
    for (const row of body.rows) {
      lines.push([...row.cells].map((cell) => cell.dataset.value ?? quoted(cell.textContent!)).join(','));
    }
    return lines.join('\n') + '\n';
  }));
}

// --- plots -----------------------------------------------------------------------------------------------------------
function plotCsv(data: PlotData): string {
  const longest = Math.max(0, ...data.curves.map((c) => c.x.length));
  const lines = [data.curves.flatMap((c) => [quoted(`${c.name}: ${data.x}`), quoted(`${c.name}: ${data.y}`)]).join(',')];
  for (let i = 0; i < longest; ++i) {
    lines.push(data.curves.flatMap((c) => (i < c.x.length ? [c.x[i] ?? '', c.y[i] ?? ''] : ['', ''])).join(','));
  }
  return lines.join('\n') + '\n';
}

/** Values at the pointer: of each curve the point whose x is nearest. */
function followPointer(card: HTMLElement, svg: SVGSVGElement, data: PlotData): void {
  const frame = svg.dataset.frame!.split(' ').map(Number);
  const [low, high, kind] = svg.dataset.x!.split(' ');
  const log = kind === 'log';
  const map = (v: number) => (log ? Math.log10(v) : v);
  const toX = (v: number) => frame[0] + ((map(v) - map(Number(low))) / (map(Number(high)) - map(Number(low)))) * (frame[2] - frame[0]);
  const line = svg.querySelector<SVGElement>('.pointer')!;
  const tip = h('div', { class: 'tip', hidden: true });
  card.append(tip);
  svg.addEventListener('pointermove', (e) => {
    const at = new DOMPoint(e.clientX, e.clientY).matrixTransform(svg.getScreenCTM()!.inverse());
    if (at.x < frame[0] - 4 || at.x > frame[2] + 4) return hide();
    let place = NaN;
    const found = data.curves.map((curve) => {
      let best = -1;
      let least = Infinity;
      curve.x.forEach((x, i) => {
        if (x === null || curve.y[i] === null || (log && x <= 0)) return;
        const miss = Math.abs(toX(x) - at.x);
        if (miss < least) [least, best] = [miss, i];
      });
      if (best >= 0 && !(Math.abs(place - at.x) < least)) place = toX(curve.x[best]!);
      return { curve, best, least };
    });
    const near = found.filter((f) => f.best >= 0 && f.least < 40);
    if (!near.length) return hide();
    line.setAttribute('transform', `translate(${place.toFixed(1)} 0)`);
    line.style.visibility = 'visible';
    tip.textContent = near.map(({ curve, best }) =>
      `${[curve.labels[best], curve.name].filter((s) => s).join(' · ')}: ${figure(curve.x[best]!, 4)}, ${figure(curve.y[best]!, 4)}`).join('\n');
    tip.hidden = false;
    const box = card.getBoundingClientRect();
    tip.style.left = `${Math.min(e.clientX - box.left + 14, box.width - tip.offsetWidth - 6)}px`;
    tip.style.top = `${e.clientY - box.top + 14}px`;
  });
  svg.addEventListener('pointerleave', hide);
  function hide(): void {
    tip.hidden = true;
    line.style.visibility = 'hidden';
  }
}

function numbersTable(data: PlotData): HTMLElement {
  const details = h('details', { class: 'numbers' }, h('summary', {}, 'Numbers'));
  details.addEventListener('toggle', () => {
    if (details.childElementCount > 1) return;
    const rows: HTMLElement[] = [];
    for (const curve of data.curves) {
      curve.x.forEach((x, i) => rows.push(h('tr', {}, h('td', {}, [curve.name, curve.labels[i]].filter((s) => s).join(' · ')),
        h('td', { class: 'number' }, x === null ? '–' : figure(x, 6)),
        h('td', { class: 'number' }, curve.y[i] === null ? '–' : figure(curve.y[i]!, 6)))));
    }
    details.append(h('div', { class: 'table-box', tabindex: 0 }, h('table', {}, h('thead', {}, h('tr', {}, h('th', { scope: 'col' }, 'Curve'),
      h('th', { scope: 'col', class: 'number' }, data.x), h('th', { scope: 'col', class: 'number' }, data.y))), h('tbody', {}, ...rows))));
  });
  return details;
}

// --- the page --------------------------------------------------------------------------------------------------------
function start(): void {
  const buttons = document.querySelector('.bar-buttons')!;
  buttons.append(themeButton(() => {}));
  for (const table of document.querySelectorAll<HTMLTableElement>('table.data')) sortable(table);
  const plots: PlotData[] = [];
  for (const element of document.querySelectorAll('.plot-data')) {
    const data = JSON.parse(element.textContent!) as PlotData;
    const card = element.closest<HTMLElement>('.plot-card')!;
    plots.push(data);
    followPointer(card, card.querySelector('svg.report-plot')!, data);
    card.append(numbersTable(data), csvButton(data.title, () => plotCsv(data)));
  }
  // The entry of the section in view is marked in the contents.
  const links = [...document.querySelectorAll<HTMLAnchorElement>('nav a')];
  const mark = () => {
    const sections = links.map((a) => document.querySelector(a.getAttribute('href')!)!.getBoundingClientRect().top);
    const here = Math.max(0, sections.filter((top) => top < 140).length - 1);
    links.forEach((a, i) => {
      a.classList.toggle('here', i === here);
      if (i === here) a.setAttribute('aria-current', 'true');
      else a.removeAttribute('aria-current');
    });
  };
  addEventListener('scroll', mark, { passive: true });
  if (links.length) mark();
  (window as unknown as { flexura: unknown }).flexura = { page: 'report', title: document.title, plots };
  document.documentElement.dataset.ready = 'true';
}

start();
