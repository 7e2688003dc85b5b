// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// The MAC matrix: how alike two shapes look, |phi_i . phi_j|^2 / (|phi_i|^2 |phi_j|^2) over the vertices drawn.
import { h } from './ui';
import type { ModeRow } from './mode_table';

export function macDialog(mac: number[][], modes: ModeRow[], choose: (i: number, j: number) => void): HTMLDialogElement {
  const n = modes.length;
  const cell = Math.max(5, Math.min(26, Math.floor(560 / Math.max(1, n))));
  const text = h('p', { class: 'mac-text', role: 'status' }, 'Point at a square; click it to see both modes.');
  const canvas = h('canvas', { width: 2 * cell * n, height: 2 * cell * n, role: 'img',
                               'aria-label': `MAC matrix of ${n} modes` });
  canvas.style.width = canvas.style.height = `${cell * n}px`;
  const g = canvas.getContext('2d')!;
  for (let i = 0; i < n; ++i) {
    for (let j = 0; j < n; ++j) {
      g.fillStyle = `rgba(33, 110, 190, ${(0.06 + 0.94 * mac[i][j]).toFixed(3)})`;
      g.fillRect(2 * cell * j + 1, 2 * cell * i + 1, 2 * cell - 2, 2 * cell - 2);
    }
  }
  const at = (e: MouseEvent) => [Math.floor(e.offsetY / cell), Math.floor(e.offsetX / cell)];
  canvas.addEventListener('mousemove', (e) => {
    const [i, j] = at(e);
    if (mac[i]?.[j] === undefined) return;
    const name = (k: number) => (modes[k].set ? `${modes[k].set} ${modes[k].number}` : `mode ${modes[k].number}`);
    text.textContent = `${name(i)} and ${name(j)}: MAC ${mac[i][j].toFixed(3)}`;
  });
  const dialog = h('dialog', { class: 'mac', 'aria-label': 'MAC matrix' }, h('h2', {}, 'MAC matrix'), text,
    h('div', { class: 'mac-box' }, canvas), h('form', { method: 'dialog' }, h('button', { class: 'plain' }, 'Close')));
  canvas.addEventListener('click', (e) => {
    const [i, j] = at(e);
    if (mac[i]?.[j] === undefined) return;
    dialog.close();
    choose(i, j);
  });
  return dialog;
}
