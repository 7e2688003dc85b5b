// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// The pages of the shipped cases, as cases/run makes them, held against what expected.py computes from the same files.
import assert from 'node:assert/strict';
import { existsSync, readFileSync, readdirSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { difference, launch, magenta, open, pages, picture, through } from './browser.mjs';

const files = readdirSync(pages).flatMap((name) => readdirSync(join(pages, name)).filter((f) => f.endsWith('.html'))
  .map((f) => join(name, f)));
const told = (file) => JSON.parse(readFileSync(join(pages, file.replace(/\.html$/, '.expected.json')), 'utf8'));
const distance = (a, b) => Math.hypot(...a.map((x, i) => x - b[i]));

let browser;
before(async () => { browser = await launch(); });
after(() => browser.close());

test('there are pages of the cases, and the engine\'s among them', () => {
  assert.ok(files.length >= 10, files.join(' '));
  for (const page of ['conrod', 'engine']) assert.ok(existsSync(join(pages, 'steam_engine', `${page}.html`)));
});

async function checkModes(page, expected) {
  const header = await page.evaluate(() => ({ sets: [...new Set(flexura.header.modes.map((m) => m.set))], size: flexura.size }));
  // 32-bit vertices.
  assert.ok(Math.abs(header.size / expected.size - 1) < 1e-6, `size ${header.size} ${expected.size}`);
  for (const set of header.sets) {
    const { frequencies, shapes } = expected.sets[set];
    await page.evaluate((name) => flexura.setSet(name), set);
    const rows = await page.locator('.modes tbody tr').evaluateAll((list) => list.map((row) =>
      [Number(row.dataset.mode), Number(row.cells[2].textContent.replace(/\s/g, '').replace(/·10([⁰¹²³⁴⁵⁶⁷⁸⁹]+)$/, (_, e) =>
        `e${[...e].map((c) => '⁰¹²³⁴⁵⁶⁷⁸⁹'.indexOf(c)).join('')}`)), row.cells[3].textContent]));
    const elastic = rows.filter((r) => r[2] !== 'rigid');
    assert.ok(elastic.length > 0 && elastic.length <= frequencies.length, `${set}: ${elastic.length}`);
    elastic.forEach(([number, hz], k) => {
      // Five digits are printed; the two eigensolvers agree far better.
      assert.ok(Math.abs(hz / frequencies[k] - 1) < 0.6e-4, `${set} mode ${number}: ${hz} Hz, ${frequencies[k]} expected`);
    });

    // A click moves the picture ...
    await page.evaluate(() => { flexura.setPlaying(false); });
    const first = await picture(page);
    const [clicked] = elastic[Math.min(2, elastic.length - 1)];
    await page.locator(`.modes tbody tr[data-mode="${clicked}"]`).click();
    await page.waitForFunction((n) => flexura.mode === n, clicked);
    if (elastic.length > 2) assert.ok(difference(first, await picture(page)) > 1000, `${set}: a click changes nothing`);

    // ... and vertices stand where the superelement says, in the page's data and in pixels.
    const amplitude = 0.08;
    for (const { elastic: j, vertices, u } of shapes.filter((s) => s.elastic < elastic.length)) {
      const number = elastic[j][0];
      let sign = 0;
      for (const phase of [0, 2.2]) {
        await page.evaluate(([n, f, p]) => flexura.setMode(n).then(() => { flexura.setAmplitude(f); flexura.setPhase(p); }),
                            [number, amplitude, phase]);
        const scale = amplitude * expected.size * Math.cos(phase);
        for (const [i, v] of vertices.entries()) {
          const rest = expected.positions[v];
          const moved = await page.evaluate((k) => flexura.displacement(k), v);
          sign ||= Math.sign(moved.reduce((s, x, a) => s + x * u[i][a], 0)) * Math.sign(scale);
          const wanted = rest.map((x, a) => x + sign * scale * u[i][a]);
          const found = await page.evaluate((k) => flexura.deformed(k), v);
          // Half a step of 11 bits at the most (large parts), of the shape and of its largest value.
          assert.ok(distance(found, wanted) < 1.5e-3 * amplitude * expected.size, `${set} mode ${number} vertex ${v}: ${found} ${wanted}`);
          if (i > 0) continue;
          await page.evaluate(([k, p]) => { flexura.view('iso'); flexura.setPhase(p); flexura.mark(k); }, [v, phase]);
          const camera = await page.evaluate(() => flexura.camera());
          const image = await picture(page);
          const dot = magenta(image);
          const at = through(camera, wanted, image.width, image.height);
          assert.ok(dot && dot.n > 30, `${set} mode ${number}: the dot is not on the picture`);
          // The dot is a square of whole pixels.
          assert.ok(Math.hypot(dot.x - at.x, dot.y - at.y) < 1.2, `${set} mode ${number}: dot at ${dot.x} ${dot.y}, expected ${at.x} ${at.y}`);
          await page.evaluate(() => flexura.mark(-1));
        }
      }
    }
  }
}

async function checkMotion(page, expected) {
  const { runs, start, end } = await page.evaluate(() => ({ runs: flexura.runs, start: flexura.start, end: flexura.end }));
  assert.deepEqual([...runs].sort(), Object.keys(expected.runs).sort());
  assert.ok((await page.evaluate(() => flexura.plots())).length > 0, 'no plot');
  // expected.py takes deformations from the floating frame; a page starts with the interface that holds the body.
  await page.evaluate(() => flexura.setReference('own'));

  // What falls goes down on the picture, wherever gravity points in W.
  const fall = await page.evaluate(() => { flexura.view('iso'); return JSON.parse(document.getElementById('header').textContent).gravity; });
  if (Math.hypot(...fall) > 0) {
    const iso = await page.evaluate(() => flexura.camera());
    const [from, to] = [[0, 0, 0], fall.map((g) => (1e-3 * g) / Math.hypot(...fall))].map((p) => through(iso, p, 1000, 1000));
    assert.ok(to.y > from.y && Math.abs(to.x - from.x) < 0.2 * (to.y - from.y), `gravity ${fall}: ${JSON.stringify([from, to])}`);
  }

  // The slider moves the picture.
  const slide = (t) => page.evaluate((value) => {
    const input = document.getElementById('time');
    input.value = String(value);
    input.dispatchEvent(new Event('input', { bubbles: true }));
  }, t);
  await slide(start);
  const first = await picture(page);
  // A quarter, a half and three quarters through: a mechanism that comes back to where it was is seen once.
  const seen = [];
  for (const part of [0.25, 0.5, 0.75]) {
    await slide(start + part * (end - start));
    seen.push(difference(first, await picture(page)));
  }
  assert.ok(Math.max(...seen) > 200, `the slider moves nothing: ${seen}`);

  for (const run of runs) {
    const { time, rows, quantities, poses, vertices, sections } = expected.runs[run];
    const stored = await page.evaluate((r) => flexura.times(r), run);
    const row = new Map(time.map((t, i) => [t, i]));
    for (const [name, { values }] of Object.entries(quantities)) {
      const found = await page.evaluate(([r, q]) => flexura.quantity(r, q), [run, name]);
      assert.equal(found.length, stored.length);
      let compared = 0;
      stored.forEach((t, k) => {
        const i = row.get(t);
        if (i === undefined || (k > 0 && stored[k - 1] === t) || stored[k + 1] === t) return; // both sides of an event
        assert.equal(found[k], values[i], `${run} ${name} at ${t}`);
        ++compared;
      });
      assert.ok(compared > 0.5 * Math.min(stored.length, time.length), `${run} ${name}: ${compared} rows compared`);
    }
    const frames = new Set(await page.evaluate((r) => flexura.frameTimes(r), run));
    let compared = 0;
    for (const [k, i] of rows.entries()) {
      if (!frames.has(time[i]) || time[i + 1] === time[i] || time[i - 1] === time[i] || compared > 12) continue;
      ++compared;
      const now = await page.evaluate(([r, t, names]) => {
        flexura.setTime(t);
        return Object.fromEntries(names.map((n) => [n, flexura.pose(r, n)]));
      }, [run, time[i], Object.keys(poses)]);
      for (const [body, list] of Object.entries(poses)) {
        const [p, q] = [list[k].slice(0, 3), list[k].slice(3)];
        // 24 bits.
        assert.ok(distance(now[body].slice(0, 3), p) < 1e-6 * (1 + Math.hypot(...p)), `${run} ${body} at ${time[i]}`);
        assert.ok(Math.abs(Math.abs(now[body].slice(3).reduce((s, x, a) => s + x * q[a], 0)) - 1) < 1e-6, `${run} ${body} turned`);
      }
      for (const [body, { vertex, u, at }] of Object.entries(vertices)) {
        for (const magnify of [1, 20]) {
          const found = await page.evaluate(([r, b, v, m, t]) => {
            flexura.setMagnify(m);
            flexura.setTime(t);
            return flexura.deformed(r, b, v);
          }, [run, body, vertex, magnify, time[i]]);
          // Poses and modal coordinates have 24 bits, shapes 12 to 16: 1e-3 of the drawn displacement is more than both.
          const bound = 1e-6 * (1 + Math.hypot(...at[magnify][k])) + 1e-3 * magnify * Math.hypot(...u[k])
            + 1e-3 * magnify * Math.max(...u.map((x) => Math.hypot(...x)));
          assert.ok(distance(found, at[magnify][k]) < bound, `${run} ${body} x ${magnify} at ${time[i]}: ${found} ${at[magnify][k]}`);
        }
      }
      for (const [body, list] of Object.entries(sections)) {
        const largest = [0, 1, 2, 3, 4, 5].map((c) => Math.max(...list.flat().map((f) => Math.abs(f[c]))));
        const found = await page.evaluate(([r, b, n]) => Array.from({ length: n }, (_, p) => flexura.sectionForces(r, b, p)),
                                          [run, body, list[k].length]);
        // Modal coordinates and section forces of the shapes in 24 bits; terms of one sign lose no digits.
        const force = Math.max(largest[0], largest[1], largest[2]);
        const moment = Math.max(largest[3], largest[4], largest[5]);
        found.forEach((six, p) => six.forEach((x, c) => {
          assert.ok(Math.abs(x - list[k][p][c]) < 1e-4 * (c < 3 ? force : moment) + 1e-9, `${run} ${body} place ${p} resultant ${c}`);
        }));
      }
    }
    assert.ok(compared > 3, `${run}: ${compared} times compared`);

    // A vertex in pixels, once.
    const [body] = Object.keys(vertices);
    const last = rows.findLastIndex((i) => frames.has(time[i]) && time[i - 1] !== time[i] && time[i + 1] !== time[i]);
    if (!body || last < 0) continue;
    const camera = await page.evaluate(([r, b, v, t]) => {
      flexura.setMagnify(20);
      flexura.setTime(t);
      flexura.view('iso');
      flexura.mark(r, b, v);
      return flexura.camera();
    }, [run, body, vertices[body].vertex, time[rows[last]]]);
    const image = await picture(page);
    const dot = magenta(image);
    const at = through(camera, vertices[body].at[20][last], image.width, image.height);
    assert.ok(dot && dot.n > 30, `${run} ${body}: the dot is not on the picture`);
    assert.ok(Math.hypot(dot.x - at.x, dot.y - at.y) < 1.5, `${run} ${body}: dot at ${dot.x} ${dot.y}, expected ${at.x} ${at.y}`);
    await page.evaluate(([r, b]) => flexura.mark(r, b, -1), [run, body]);
  }
}

for (const file of files) {
  test(`cases: ${file}`, async () => {
    const page = await open(browser, file);
    assert.equal(await page.evaluate(() => document.documentElement.dataset.ready), 'true', page.complaints.join('\n'));
    const expected = told(file);
    assert.equal(await page.evaluate(() => flexura.page), expected.page);
    if (expected.page !== 'report') await (expected.page === 'modes' ? checkModes : checkMotion)(page, expected);
    assert.deepEqual(page.complaints, []);
    assert.deepEqual(page.requests.filter((url) => !/^(file|blob|data):/.test(url)), []);
    await page.context().close();
  });
}

test('the engine\'s crank stands at the angle that its plot shows', async () => {
  const page = await open(browser, join('steam_engine', 'engine.html'));
  const { time, angle } = await page.evaluate(async () => ({ time: flexura.times('flexible'), angle: await flexura.quantity('flexible', 'main.angle') }));
  let farthest = 0;
  for (const k of [0, Math.floor(time.length / 3), Math.floor(time.length / 2), time.length - 2]) {
    const q = await page.evaluate((t) => {
      const input = document.getElementById('time');
      input.value = String(t);
      input.dispatchEvent(new Event('input', { bubbles: true }));
      return flexura.pose('flexible', 'crank').slice(3);
    }, time[k]);
    // The turn about the shaft: cos(angle / 2) is the quaternion's first number, up to its sign.
    farthest = Math.max(farthest, Math.abs(angle[k] - angle[0]));
    assert.ok(Math.abs(Math.abs(q[0]) - Math.abs(Math.cos(angle[k] / 2))) < 1e-3, `${time[k]} s: ${q} ${angle[k]}`);
  }
  assert.ok(farthest > 1, `the crank turns by ${farthest} rad only`);
  await page.context().close();
});
