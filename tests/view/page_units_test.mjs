// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// node page_units_test.mjs BUNDLE WEB: functions of the pages' scripts that need no browser.  BUNDLE: the folder of the build with esbuild
// and the packages; exit 77 (skipped) where there is none, as in a release archive.
import assert from 'node:assert/strict';
import { existsSync, mkdtempSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';

const [bundle, web] = process.argv.slice(2).map((path) => resolve(path));
if (!existsSync(join(bundle, 'node_modules/esbuild'))) process.exit(77);
const { buildSync } = createRequire(join(bundle, 'x.js'))('esbuild');
const folder = mkdtempSync(join(tmpdir(), 'flexura-units-'));
process.on('exit', () => rmSync(folder, { recursive: true }));
const outfile = join(folder, 'units.mjs');
buildSync({
  stdin: { resolveDir: join(web, 'src'), contents: `export { gifDelay } from './film'; export { refusal } from './film_dialog'; export { interfaceTexts } from './parts_data';` },
  bundle: true, format: 'esm', outfile, logLevel: 'error', nodePaths: [join(bundle, 'node_modules')],
});
const { gifDelay, refusal, interfaceTexts } = await import(pathToFileURL(outfile).href);

/** Numbers from 0 to 1 of a seed (Park and Miller's generator). */
function random(seed) {
  let state = seed + 1;
  return () => (state = (48271 * state) % 2147483647) / 2147483647;
}

// Delays of a GIF are whole hundredths of a second, and add up to the film's time to half of one, at any speed.
for (let seed = 0; seed < 200; ++seed) {
  const uniform = random(seed);
  const fps = uniform() < 0.5 ? 1 + Math.floor(60 * uniform()) : 1 + 59 * uniform();
  const frames = 1 + Math.floor(500 * uniform());
  let sum = 0;
  for (let i = 0; i < frames; ++i) {
    const delay = gifDelay(i, fps);
    assert.ok(Math.abs(delay / 10 - Math.round(delay / 10)) < 1e-9 && delay >= 10, `${delay}`);
    sum += delay;
  }
  assert.ok(Math.abs(sum - (1000 * frames) / fps) <= 5 + 1e-6, `seed ${seed}: ${sum} ms of ${frames} frames at ${fps}`);
}

// What a film cannot be is refused with the rule.
const good = { width: 640, height: 360, fps: 25, seconds: 6 };
assert.equal(refusal(good), null);
for (const wrong of [{ fps: 0 }, { fps: 61 }, { fps: NaN }, { seconds: 0 }, { seconds: -1 }, { seconds: 241 }, { width: 63 }, { height: 5000 }, { width: NaN }]) {
  assert.match(refusal({ ...good, ...wrong }), /1 to 60|1 to 6000|64 to 4096/, JSON.stringify(wrong));
}

// Pieces of one bore have one table between them, on the page of faces; other faces one each.
for (let seed = 0; seed < 200; ++seed) {
  const uniform = random(seed);
  const faces = Array.from({ length: 2 + Math.floor(8 * uniform()) }, (_, i) => ({ number: i + 1, text: 'bore', lines: `point = [${Math.floor(4 * uniform())}]\n` }));
  const chosen = faces.filter(() => uniform() < 0.6);
  const header = { parts: [{ name: 'p', file: 'p.toml', faces }], bodies: [{ name: 'p', part: 0 }] };
  const found = interfaceTexts(header, [], new Set(chosen.map((f) => `0 ${f.number}`)));
  const tables = found.length ? found[0].text.split('[interface.').slice(1) : [];
  assert.deepEqual(tables.map((t) => t.slice(t.indexOf('point'))).map((t) => t.trim()).sort(), [...new Set(chosen.map((f) => f.lines.trim()))].sort());
}
