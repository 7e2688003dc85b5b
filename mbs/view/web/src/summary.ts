// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// How the runs ended: completeness, warnings, energy balance, and whatever else the summary holds.
import type { Run } from './motion_data';
import { figure, h, icon } from './ui';

type Json = string | number | boolean | null | Json[] | { [key: string]: Json };

function rows(value: Json, prefix: string, out: [string, string][]): void {
  if (value === null || prefix === 'warnings' || prefix === 'estimate.outputs') return;
  if (Array.isArray(value)) {
    if (!value.length) return;
    if (value.every((v) => typeof v !== 'object')) out.push([prefix, value.map(text).join(', ')]);
    else value.forEach((v, i) => rows(v, `${prefix} ${i + 1}`, out));
  } else if (typeof value === 'object') {
    for (const [key, v] of Object.entries(value)) rows(v, prefix ? `${prefix}.${key}` : key, out);
  } else out.push([prefix, text(value)]);
}

/** What readers look for, in their order, with a unit; whatever else the summary holds follows behind a line to open. */
const known: [string, string, string][] = [
  ['relative_energy_error', 'energy error', 'of the energy moved'], ['energy_error', 'energy balance', 'J'],
  ['largest_energy_error', 'largest imbalance', 'J'], ['work_in', 'work done on it', 'J'], ['dissipated', 'energy dissipated', 'J'],
  ['peak_position_drift', 'largest drift of positions', ''], ['peak_velocity_drift', 'largest drift of velocities', ''],
  ['estimate.error', 'estimated error', 'of the worst output’s rms'], ['method', 'integrator', ''], ['tolerance', 'tolerance', ''],
  ['steps', 'steps', ''], ['wall_time', 'computing time', 's'], ['real_time_factor', 'computing per simulated time', ''],
  ['switches', 'switches', ''], ['redundant_constraints', 'redundant constraints', ''],
];

function told(list: [string, string][]): { first: [string, string][]; more: [string, string][] } {
  const all = new Map(list);
  const first: [string, string][] = [];
  for (const [key, name, unit] of known) {
    const value = all.get(key);
    if (value === undefined) continue;
    all.delete(key);
    first.push([name, unit ? `${value} ${unit}` : value]);
  }
  const more = [...all].map(([key, value]): [string, string] => [key.replaceAll('_', ' ').replaceAll('.', ' · '), value]);
  // Summaries of other programs, with names of their own, are not hidden.
  return first.length ? { first, more } : { first: more, more: [] };
}

const pairs = (list: [string, string][]) =>
  h('dl', { class: 'pairs' }, ...list.map(([k, v]) => h('div', {}, h('dt', {}, k), h('dd', {}, v))));

function text(value: Json): string {
  return typeof value === 'number' ? (Number.isInteger(value) ? String(value) : figure(value, 5)) : String(value);
}

export function warningsOf(run: Run): string[] {
  const list: string[] = [];
  const summary = run.header.summary as { warnings?: Json } | null;
  if (!run.header.complete) {
    list.push(`Run "${run.header.name}" stopped early${run.header.stopped_because ? `: ${run.header.stopped_because}` : ''}`);
  }
  if (Array.isArray(summary?.warnings)) list.push(...summary.warnings.map((w) => `${run.header.name}: ${text(w)}`));
  if (run.header.rows < run.header.rows_stored) {
    list.push(`${run.header.name}: plots show ${run.header.rows} of ${run.header.rows_stored} stored times`);
  }
  return list;
}

interface Estimate { max: number; rms: number; final: number; size_max: number }

/** What dropped modes and the integrator cost in every output, behind a line to open. */
function estimates(run: Run): HTMLElement | null {
  const { estimate } = (run.header.summary ?? {}) as { estimate?: { outputs?: Record<string, Estimate> } };
  const outputs = Object.entries(estimate?.outputs ?? {});
  if (!outputs.length) return null;
  const columns: [string, keyof Estimate][] = [['largest', 'max'], ['rms', 'rms'], ['at the end', 'final'], ['of', 'size_max']];
  return h('details', { class: 'estimates' }, h('summary', {}, `Estimated errors of ${outputs.length} outputs`),
    h('table', {}, h('thead', {}, h('tr', {}, ...['output', ...columns.map(([name]) => name)].map((c) => h('th', { scope: 'col' }, c)))),
      h('tbody', {}, ...outputs.map(([name, e]) => h('tr', {}, h('th', { scope: 'row' }, name),
        ...columns.map(([, key]) => h('td', {}, figure(e[key], 3))))))));
}

export function summaryPanel(runs: Run[]): HTMLElement {
  return h('div', { class: 'summary' }, ...runs.map((run) => {
    const list: [string, string][] = [];
    const t = run.time;
    rows(run.header.summary as Json, '', list);
    const { first, more } = told(list);
    if (t.length) first.unshift(['time', `${figure(t[0], 4)} – ${figure(t[t.length - 1], 4)} s, ${run.header.rows_stored} times stored`]);
    return h('section', { class: 'card' },
      h('header', {}, h('h2', {}, run.header.name),
        h('span', { class: run.header.complete ? 'chip good' : 'chip bad' },
          icon(run.header.complete ? 'check' : 'warning'), run.header.complete ? 'complete' : 'stopped early')),
      ...warningsOf(run).map((w) => h('p', { class: 'warning' }, icon('warning'), w)),
      pairs(first), estimates(run),
      more.length ? h('details', { class: 'estimates' }, h('summary', {}, `${more.length} more figures`), pairs(more)) : null);
  }));
}
