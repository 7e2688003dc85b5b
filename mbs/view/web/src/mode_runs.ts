// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Modes of a mechanism: each run is one period of one mode, shown one at a time, chosen from a list.
import type { RunHeader } from './motion_data';
import { figure, h } from './ui';

interface ModeSummary { frequency_hz: number; damping: number; moves_most: string }

export const modeOf = (run: RunHeader): ModeSummary | null =>
  (run.summary as { mode?: ModeSummary } | null)?.mode ?? null;

/** The list; `choose` is called with the number of the run. */
export function modeList(runs: RunHeader[], choose: (run: number) => void): { element: HTMLElement; mark: (run: number) => void } {
  // Beside the highest frequency, what is 1e-6 of it is round-off of a rigid motion.
  const highest = Math.max(...runs.map((run) => modeOf(run)!.frequency_hz));
  const hz = (f: number) => figure(Math.abs(f) < 1e-6 * highest ? 0 : f, 5);
  const rows = runs.map((run, i) => {
    const mode = modeOf(run)!;
    return h('tr', { tabindex: 0, title: 'Show this mode', onclick: () => choose(i),
                     onkeydown: (e: Event) => { if ((e as KeyboardEvent).key === 'Enter') choose(i); } },
             h('td', { class: 'number' }, String(i + 1)), h('td', { class: 'number' }, hz(mode.frequency_hz)),
             h('td', { class: 'number' }, figure(100 * mode.damping, 3)), h('td', {}, mode.moves_most));
  });
  const element = h('table', { class: 'quantities modes-of-runs' },
    h('thead', {}, h('tr', {}, h('th', { scope: 'col', class: 'number' }, 'Mode'), h('th', { scope: 'col', class: 'number' }, 'Frequency [Hz]'),
      h('th', { scope: 'col', class: 'number' }, 'Damping [%]'), h('th', { scope: 'col' }, 'Moves most'))),
    h('tbody', {}, ...rows));
  const mark = (run: number) => rows.forEach((row, i) => row.setAttribute('aria-selected', String(i === run)));
  return { element, mark };
}
