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
    if (t.length) list.push(['time', `${figure(t[0], 4)} – ${figure(t[t.length - 1], 4)} s, ${run.header.rows_stored} times stored`]);
    rows(run.header.summary as Json, '', list);
    return h('section', { class: 'card' },
      h('header', {}, h('h3', {}, run.header.name),
        h('span', { class: run.header.complete ? 'chip good' : 'chip bad' },
          icon(run.header.complete ? 'check' : 'warning'), run.header.complete ? 'complete' : 'stopped early')),
      ...warningsOf(run).map((w) => h('p', { class: 'warning' }, icon('warning'), w)),
      h('dl', { class: 'pairs' }, ...list.map(([k, v]) => h('div', {}, h('dt', {}, k), h('dd', {}, v)))),
      estimates(run));
  }));
}
