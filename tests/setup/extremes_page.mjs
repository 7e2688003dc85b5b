#!/usr/bin/env node
// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// extremes_page.mjs LOG PAGE.json [PAGE.md [COMMIT]]: gathers the Markdown tables that the tests at the extremes printed
// (ctest --verbose > LOG) into the JSON of a report, with an overview of each axis and a plot beside each table of
// figures; "flexura report PAGE.json" makes the page.  PAGE.md is the same as a document: the tables, with the day, the
// commit they were measured at, and what broke its bound.
import { readFileSync, renameSync, writeFileSync } from 'node:fs';

const [log, page, document, commit] = process.argv.slice(2);
if (!page) {
  console.error('usage: extremes_page.mjs LOG PAGE.json [PAGE.md [COMMIT]]');
  process.exit(2);
}

// ---- The log: lines of tests that ran side by side are told apart by their number. ---------------------------------
const tests = new Map();
for (const line of readFileSync(log, 'utf8').split(/\r?\n/)) {
  const found = /^(\d+): ?(.*)$/.exec(line);
  if (!found) continue; // what ctest itself says
  if (/^\[|^Note: |^Running main|^\d+\/\d+ |^Test /.test(found[2])) continue; // what GoogleTest says
  if (!tests.has(found[1])) tests.set(found[1], []);
  tests.get(found[1]).push(found[2]);
}

const plain = (text) => text.trim().replace(/\*\*|`/g, '');
const cells = (line) => line.split('|').slice(1, -1).map(plain);
const isNumber = (text) => /^[-+]?\d+(\.\d*)?([eE][-+]?\d+)?$/.test(text);
const longForm = ['extreme', 'value', 'what is measured', 'measured', 'bound'];

// Sections {title, text, tables: [{columns, rows}]} in the order in which they were printed.
const sections = [];
for (const lines of tests.values()) {
  let section = null, table = null;
  const begin = (title) => sections.push((section = { title, text: [], tables: [] }));
  for (const line of lines) {
    if (/^#+ /.test(line)) {
      begin(plain(line.replace(/^#+ /, '')));
      table = null;
    } else if (/^\|[-:| ]+\|$/.test(line)) {
      continue;
    } else if (line.startsWith('|')) {
      const row = cells(line);
      if (!table) {
        // The solver's tests print the rows of one long table without its head.
        const headless = row.length === longForm.length && isNumber(row[3]);
        if (!section) begin(headless ? 'Solver' : 'Table');
        section.tables.push((table = { columns: headless ? longForm : row, rows: headless ? [row] : [] }));
      } else if (row.length === table.columns.length && row.join() !== table.rows.at(-1)?.join()) {
        table.rows.push(row); // a row that broke its bound is printed again with the failure
      }
    } else if (section && /[A-Za-z]/.test(line) && section.tables.length === 0) {
      section.text.push(plain(line));
    }
  }
}
// Tests of one program that each printed a few headless rows belong together.
const merged = [];
for (const section of sections.filter((s) => s.tables.some((t) => t.rows.length > 0))) {
  const same = section.title === 'Solver' && merged.find((s) => s.title === 'Solver');
  if (same) same.tables[0].rows.push(...section.tables[0].rows);
  else merged.push(section);
}
if (merged.length === 0) {
  console.error('error: no table in the log: did the tests at the extremes run with --verbose?');
  process.exit(1);
}

// ---- Plots. --------------------------------------------------------------------------------------------------------
const isWide = (values) => values.every((v) => v > 0) && Math.max(...values) > 30 * Math.min(...values);
function plotOf(title, xName, yName, curves) {
  const kept = curves
    .map((c) => ({ ...c, points: c.points.filter(([x, y]) => isNumber(x) && isNumber(y)).map(([x, y]) => [+x, +y]) }))
    .filter((c) => c.points.length >= 3);
  if (kept.length === 0) return null;
  const all = kept.flatMap((c) => c.points), xs = all.map((p) => p[0]);
  const logX = isWide(xs.filter((x) => x !== 0)) && xs.every((x) => x >= 0);
  const logY = all.some((p) => p[1] > 0) && all.every((p) => p[1] >= 0);
  return {
    plot: {
      title,
      x: { name: xName, unit: '', logarithmic: logX },
      y: { name: yName, unit: '', logarithmic: logY },
      curves: kept.map((c) => {
        // A logarithm knows no zero.
        const points = c.points.filter((p) => (!logX || p[0] > 0) && (!logY || p[1] > 0)).sort((a, b) => a[0] - b[0]);
        return { name: c.name, x: points.map((p) => p[0]), y: points.map((p) => p[1]), style: 'line and points' };
      }).filter((c) => c.x.length >= 2),
    },
  };
}

const skipped = /^(steps|bound|the program says)$/i;
function plotsOf(table) {
  if (table.columns.join() === longForm.join()) {
    const groups = new Map();
    for (const [extreme, value, what, measured] of table.rows) {
      const key = `${extreme}: ${what}`;
      if (!groups.has(key)) groups.set(key, []);
      groups.get(key).push([value, measured]);
    }
    return [...groups].map(([key, points]) => plotOf(key, 'value', 'measured', [{ name: key, points }])).filter(Boolean);
  }
  const curves = table.columns.slice(1).map((name, k) => ({ name, points: table.rows.map((r) => [r[0], r[k + 1]]) }))
    .filter((c) => !skipped.test(c.name));
  const plot = plotOf('', table.columns[0], curves.length === 1 ? curves[0].name : 'measured', curves);
  return plot && plot.plot.curves.length > 0 ? [plot] : [];
}

// ---- The overview: for each axis of the program where it holds, warns and refuses. ---------------------------------
const good = 1e-2;
const overview = { title: 'Each axis', columns: [], rows: [] };
overview.columns = ['axis', `error below ${good} from`, 'to', 'errors there', 'warns', 'refuses'].map((name) => ({ name }));
for (const { title, tables } of merged)
  for (const { columns, rows } of tables) {
    const says = columns.indexOf('the program says');
    if (says < 0) continue;
    const holds = rows.filter((r) => isNumber(r[1]) && Math.abs(+r[1]) < good);
    const words = (kind) => {
      const at = rows.filter((r) => r[says].startsWith(kind));
      if (at.length === 0) return '';
      return `${at.map((r) => r[0]).join(', ')} (${at[0][says].replace(/^[a-z]+: /, '')})`;
    };
    const errors = holds.map((r) => Math.abs(+r[1]));
    overview.rows.push([title, holds.length ? holds[0][0] : '-', holds.length ? holds[holds.length - 1][0] : '-',
      errors.length ? `${Math.min(...errors).toExponential(1)} to ${Math.max(...errors).toExponential(1)}` : '-',
      [words('warning: '), words('note: ')].filter(Boolean).join('; '), words('error: ')]);
  }

// Tables of mechanisms by methods at random places of a range that is held: one line each.
const held = { title: 'Ranges held at random places', columns: ['range', 'mechanisms', 'methods', 'worst error', 'bound'].map((name) => ({ name })), rows: [] };
for (const { title, text, tables } of merged)
  for (const { columns, rows } of tables) {
    if (columns[0] !== 'mechanism') continue;
    const cells = rows.flatMap((r) => r.slice(1)).filter(isNumber).map(Number);
    const bound = /the bound is (\S+)\.$/.exec(text.join(' '))?.[1] ?? '';
    held.rows.push([title, `${rows.length}`, columns.slice(1).join(', '), Math.max(...cells).toExponential(1), bound]);
  }

const report = {
  title: 'Flexura at the extremes',
  summary: 'What the tests at the extremes measured: how far results hold and to what accuracy, where the program warns and where it refuses.',
  sections: [],
};
if (overview.rows.length > 0) report.sections.push({ title: 'Overview', blocks: [{ table: overview }] });
if (held.rows.length > 0) report.sections.push({ title: held.title, blocks: [{ table: held }] });
for (const { title, text, tables } of merged) {
  const blocks = text.length > 0 ? [{ text: text.join(' ') }] : [];
  for (const table of tables) {
    if (table.rows.length === 0) continue;
    blocks.push(...plotsOf(table));
    blocks.push({
      table: {
        columns: table.columns.map((name) => ({ name })),
        rows: table.rows.map((r) => r.map((cell) => (isNumber(cell) ? +cell : cell))),
      },
    });
  }
  report.sections.push({ title, blocks });
}
function write(path, text) {
  writeFileSync(`${path}.part`, text);
  renameSync(`${path}.part`, path);
}
write(page, JSON.stringify(report, null, 1) + '\n');

// ---- The document. -------------------------------------------------------------------------------------------------
function markdown() {
  const line = (cells) => `| ${cells.map((cell) => `${cell}`.replace(/\|/g, '\\|')).join(' | ')} |`;
  const tableOf = (names, rows) => [line(names), line(names.map(() => '---')), ...rows.map(line), ''];
  const out = [
    '# Flexura at the extremes', '',
    `${report.summary} Made by \`tests/run extremes\` on ${new Date().toISOString().slice(0, 10)}` +
      `${commit ? ` at commit ${commit}` : ''}; every figure with a bound is held to it by its test.`, '',
  ];
  const broken = [];
  const body = [];
  if (overview.rows.length > 0) body.push('## Overview', '', ...tableOf(overview.columns.map((c) => c.name), overview.rows));
  if (held.rows.length > 0) body.push(`## ${held.title}`, '', ...tableOf(held.columns.map((c) => c.name), held.rows));
  for (const { title, text, tables } of merged) {
    body.push(`## ${title}`, '');
    if (text.length > 0) body.push(text.join(' '), '');
    for (const { columns, rows } of tables) {
      if (rows.length === 0) continue;
      const measured = columns.indexOf('measured'), bound = columns.indexOf('bound');
      body.push(...tableOf(columns, rows.map((row) => {
        if (measured < 0 || bound < 0 || +row[measured] < +row[bound]) return row;
        broken.push(row);
        return row.map((cell, k) => (k === measured ? `**${cell}**` : cell));
      })));
    }
  }
  if (broken.length > 0)
    out.push(`${broken.length} of the figures broke ${broken.length > 1 ? 'their bounds' : 'its bound'} (in bold below): ` +
      `${broken.map((row) => row.slice(0, 3).join(', ')).join('; ')}.`, '');
  return [...out, ...body].join('\n');
}
if (document) write(document, markdown());
