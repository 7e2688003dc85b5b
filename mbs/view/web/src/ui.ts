// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Small helpers for the pages' controls: elements, icons, numbers with units, theme, downloads.

type Child = Node | string | null | undefined | false;
type Props = Record<string, unknown>;

/** An element: h('button', { class: 'x', onclick: f, 'aria-label': 'Play' }, 'text', child). */
export function h<K extends keyof HTMLElementTagNameMap>(tag: K, props: Props = {}, ...children: Child[]):
    HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [key, value] of Object.entries(props)) {
    if (value === undefined || value === null || value === false) continue;
    if (key.startsWith('on')) element.addEventListener(key.slice(2), value as EventListener);
    else if (key === 'value') (element as unknown as HTMLInputElement).value = String(value);
    else if (key === 'checked') (element as unknown as HTMLInputElement).checked = Boolean(value);
    else element.setAttribute(key, value === true ? '' : String(value));
  }
  for (const child of children) if (child) element.append(child);
  return element;
}

const paths = {
  play: '<path d="M7 4.5v15l12-7.5z" fill="currentColor" stroke="none"/>',
  pause: '<path d="M7 5h3.5v14H7zM13.5 5H17v14h-3.5z" fill="currentColor" stroke="none"/>',
  camera: '<path d="M4 8h3l1.5-2.5h7L17 8h3v11H4z"/><circle cx="12" cy="13" r="3.5"/>',
  film: '<rect x="3.5" y="5.5" width="17" height="13" rx="2"/><path d="M8 5.5v13M16 5.5v13M3.5 12h17"/>',
  sun: '<circle cx="12" cy="12" r="4"/><path d="M12 2.5v3M12 18.5v3M2.5 12h3M18.5 12h3M5.3 5.3l2.1 2.1M16.6 16.6l2.1 2.1M5.3 18.7l2.1-2.1M16.6 7.4l2.1-2.1"/>',
  moon: '<path d="M19.5 14.5A8 8 0 0 1 9.5 4.5a8 8 0 1 0 10 10z"/>',
  keyboard: '<rect x="2.5" y="6" width="19" height="12" rx="2"/><path d="M6 10h.01M9 10h.01M12 10h.01M15 10h.01M18 10h.01M7 14.5h10"/>',
  fit: '<path d="M4 9V4h5M20 9V4h-5M4 15v5h5M20 15v5h-5"/>',
  search: '<circle cx="10.5" cy="10.5" r="6"/><path d="M15 15l5.5 5.5"/>',
  table: '<path d="M12 4v11M7.5 11l4.5 4.5 4.5-4.5M4 20h16"/>',
  copy: '<rect x="8.5" y="8.5" width="11" height="11" rx="2"/><path d="M15.5 8.5v-2a2 2 0 0 0-2-2h-7a2 2 0 0 0-2 2v7a2 2 0 0 0 2 2h2"/>',
  split: '<rect x="3.5" y="5" width="17" height="14" rx="2"/><path d="M12 5v14"/>',
  grid: '<path d="M4 4h16v16H4zM4 9.3h16M4 14.6h16M9.3 4v16M14.6 4v16"/>',
  cut: '<path d="M4 17l9-13 7 4-9 13z"/><path d="M2 12h20" stroke-dasharray="3 2.5"/>',
  warning: '<path d="M12 4 2.8 19.5h18.4z"/><path d="M12 10v4.5M12 17.2v.1"/>',
  check: '<path d="M4.5 12.5l5 5 10-11"/>',
  back: '<path d="M7 5v14M19 5.5v13L9.5 12z"/>',
};
export type IconName = keyof typeof paths;

export function icon(name: IconName): SVGElement {
  const box = document.createElement('span');
  box.innerHTML = `<svg viewBox="0 0 24 24" width="18" height="18" aria-hidden="true" fill="none" stroke="currentColor"
    stroke-width="1.7" stroke-linecap="round" stroke-linejoin="round">${paths[name]}</svg>`;
  return box.firstChild as SVGElement;
}

export function iconButton(name: IconName, label: string, onclick: () => void, props: Props = {}): HTMLButtonElement {
  return h('button', { class: 'icon', type: 'button', title: label, 'aria-label': label, onclick, ...props },
           icon(name));
}

/** A two-state button; the label says what it shows. */
export function toggle(label: string, on: boolean, change: (on: boolean) => void, props: Props = {}):
    HTMLButtonElement & { set(on: boolean): void } {
  const button = h('button', { class: 'toggle', type: 'button', 'aria-pressed': String(on), ...props }, label) as
    HTMLButtonElement & { set(on: boolean): void };
  button.set = (value) => {
    button.setAttribute('aria-pressed', String(value));
    change(value);
  };
  button.addEventListener('click', () => button.set(button.getAttribute('aria-pressed') !== 'true'));
  return button;
}

/** A slider with a label and its value in words. */
export function slider(label: string, options: { min: number; max: number; step: number; value: number;
    text: (v: number) => string; change: (v: number) => void; id?: string }):
    { element: HTMLElement; set(v: number): void; get(): number; refresh(): void } {
  const output = h('output', {});
  const input = h('input', { type: 'range', min: options.min, max: options.max, step: options.step,
                             id: options.id, 'aria-label': label });
  input.value = String(options.value);
  const show = () => {
    output.textContent = options.text(Number(input.value));
    input.setAttribute('aria-valuetext', output.textContent);
    const part = (Number(input.value) - options.min) / (options.max - options.min || 1);
    input.style.setProperty('--part', `${100 * part}%`);
  };
  input.addEventListener('input', () => {
    show();
    options.change(Number(input.value));
  });
  show();
  return {
    element: h('label', { class: 'slider' }, h('span', { class: 'slider-name' }, label), input, output),
    set(v) {
      input.value = String(v);
      show();
      options.change(Number(input.value));
    },
    get: () => Number(input.value),
    refresh: show,
  };
}

/** Digits an engineer reads: n significant ones, thin spaces between thousands, powers of ten beyond. */
export function figure(value: number, digits = 4): string {
  if (!Number.isFinite(value)) return String(value);
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (size >= 1e6 || size < 1e-3) {
    const [mantissa, exponent] = value.toExponential(digits - 1).split('e');
    const trimmed = mantissa.includes('.') ? mantissa.replace(/\.?0+$/, '') : mantissa;
    const raised = Number(exponent).toString().replace(/./g, (c) => '⁰¹²³⁴⁵⁶⁷⁸⁹'['0123456789'.indexOf(c)] ?? '⁻');
    return `${trimmed.replace('-', '−')}·10${raised}`;
  }
  const decimals = Math.max(0, digits - 1 - Math.floor(Math.log10(size)));
  const [whole, rest] = value.toFixed(decimals).split('.');
  const grouped = whole.length > 4 ? whole.replace(/\B(?=(\d{3})+$)/g, ' ') : whole;
  return (rest ? `${grouped}.${rest}` : grouped).replace('-', '−');
}

/** The same without trailing zeros, for axes. */
export function tick(value: number): string {
  return figure(value, 5).replace(/(\.\d*?)0+(?=$|·)/, '$1').replace(/\.$/, '');
}

/** "kg*m^2" as it is printed: kg·m². */
export function unitText(unit: string): string {
  return unit.replace(/\*/g, '·').replace(/\^2/g, '²').replace(/\^3/g, '³');
}

/** A length with the unit that suits `of` (default the value itself). */
export function lengthUnit(of: number): { factor: number; unit: string } {
  const size = Math.abs(of);
  if (size >= 1) return { factor: 1, unit: 'm' };
  if (size >= 1e-4 || size === 0) return { factor: 1e3, unit: 'mm' };
  return { factor: 1e6, unit: 'µm' };
}
/** "12.3 kN". */
export function forceText(value: number, digits = 3): string {
  const size = Math.abs(value);
  const [factor, unit] = size >= 1e6 ? [1e-6, 'MN'] : size >= 1e3 ? [1e-3, 'kN'] : size >= 1 || size === 0 ? [1, 'N'] : [1e3, 'mN'];
  return `${figure(value * factor, digits)} ${unit}`;
}
/** The same for a stress. */
export function stressUnit(of: number): { factor: number; unit: string } {
  const size = Math.abs(of);
  if (size >= 1e9) return { factor: 1e-9, unit: 'GPa' };
  if (size >= 1e4) return { factor: 1e-6, unit: 'MPa' };
  return { factor: 1, unit: 'Pa' };
}
export function lengthText(value: number, digits = 3): string {
  const { factor, unit } = lengthUnit(value);
  return `${figure(value * factor, digits)} ${unit}`;
}

export function isDark(): boolean {
  const set = document.documentElement.dataset.theme;
  return set ? set === 'dark' : matchMedia('(prefers-color-scheme: dark)').matches;
}

/** The button that switches between light and dark; `changed` is also called when the system switches. */
export function themeButton(changed: () => void): HTMLButtonElement {
  const button = iconButton('sun', 'Light or dark (T)', () => {
    document.documentElement.dataset.theme = isDark() ? 'light' : 'dark';
    refresh();
  });
  const refresh = () => {
    button.replaceChildren(icon(isDark() ? 'sun' : 'moon'));
    changed();
  };
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', refresh);
  // On paper plots and pictures are light; before anything else listens.
  let onScreen: string | undefined;
  addEventListener('beforeprint', () => {
    onScreen = document.documentElement.dataset.theme;
    document.documentElement.dataset.theme = 'light';
    refresh();
  }, true);
  addEventListener('afterprint', () => {
    if (onScreen === undefined) delete document.documentElement.dataset.theme;
    else document.documentElement.dataset.theme = onScreen;
    refresh();
  });
  button.replaceChildren(icon(isDark() ? 'sun' : 'moon'));
  return button;
}

export function cssColor(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

export function download(name: string, content: Blob | string, type = 'text/plain'): void {
  const blob = typeof content === 'string' ? new Blob([content], { type }) : content;
  const url = URL.createObjectURL(blob);
  h('a', { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}

/** A short message at the foot of the page, read out by screen readers. */
export function say(text: string): void {
  let box = document.querySelector<HTMLElement>('.toast');
  if (!box) document.body.append((box = h('div', { class: 'toast', role: 'status' })));
  box.textContent = text;
  box.classList.add('shown');
  clearTimeout(Number(box.dataset.timer));
  box.dataset.timer = String(setTimeout(() => box.classList.remove('shown'), 2600));
}

export interface Shortcut { keys: string[]; text: string; run: (event: KeyboardEvent) => void }

/** Keyboard control: shortcuts work unless a text field has the focus; the dialog lists them. */
export function shortcuts(list: Shortcut[]): HTMLButtonElement {
  const rows = list.map((s) => h('tr', {}, h('td', {}, ...s.keys.map((k) => h('kbd', {}, keyName(k)))),
                                 h('td', {}, s.text)));
  const dialog = h('dialog', { class: 'help', 'aria-label': 'Keyboard' }, h('h2', {}, 'Keyboard'),
                   h('table', {}, h('tbody', {}, ...rows)),
                   h('p', {}, 'Drag to turn, drag with the right button to move, wheel to come closer.'),
                   h('form', { method: 'dialog' }, h('button', { class: 'plain' }, 'Close')));
  document.body.append(dialog);
  document.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || dialog.open) return;
    const target = event.target as HTMLElement;
    if (target.matches('input:not([type=range]):not([type=checkbox]), select, textarea')) return;
    if (target.matches('input[type=range]') && event.key.startsWith('Arrow')) return;
    if (target.matches('button, summary, [role=option]') && (event.key === ' ' || event.key === 'Enter')) return;
    const hit = list.find((s) => s.keys.includes(event.key));
    if (!hit) return;
    event.preventDefault();
    hit.run(event);
  });
  return iconButton('keyboard', 'Keyboard (?)', () => dialog.showModal(), { id: 'keyboard' });
}

function keyName(key: string): string {
  return { ' ': 'Space', ArrowUp: '↑', ArrowDown: '↓', ArrowLeft: '←', ArrowRight: '→' }[key] ?? key;
}

export function factList(facts: [string, string][]): HTMLElement {
  return h('dl', { class: 'facts' }, ...facts.map(([name, value]) => h('div', {}, h('dt', {}, name), h('dd', {}, value))));
}

/** The header bar of every page. */
export function topBar(title: string, facts: [string, string][] | HTMLElement, ...buttons: HTMLElement[]): HTMLElement {
  const mark = h('span', { class: 'brand' });
  mark.innerHTML = `<svg viewBox="0 0 32 32" width="26" height="26" aria-hidden="true"><rect width="32" height="32" rx="8"
    fill="var(--accent)"/><path d="M6 21c5 0 6-11 11-11s5 7 9 7" fill="none" stroke="#fff" stroke-width="2.6"
    stroke-linecap="round"/><circle cx="6" cy="21" r="2.4" fill="#fff"/><circle cx="26" cy="17" r="2.4" fill="#fff"/></svg>
    <span>Flexura</span>`;
  return h('header', { class: 'bar' }, mark, h('h1', {}, title),
           Array.isArray(facts) ? factList(facts) : facts,
           h('div', { class: 'bar-buttons' }, ...buttons));
}
