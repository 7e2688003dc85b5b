// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Every kind of page that the programs write (every_page.sh) and pages of the documentation's site, in both themes, at 1400 and at
// 700 pixels: axe-core finds no violation of accessibility, nothing is wider than the window, the page complains of nothing.
// With $FLEXURA_SCREENSHOTS their pictures go into that folder, to be looked at (the script "screenshots").
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { existsSync, mkdirSync, readFileSync, readdirSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { launch, pages } from './browser.mjs';

const axe = readFileSync(join('node_modules', 'axe-core', 'axe.min.js'), 'utf8');
const site = process.env.FLEXURA_SITE;
const pictures = process.env.FLEXURA_SCREENSHOTS;
const kinds = ['faces', 'assembly', 'modes_solid', 'modes_beams', 'modes_suspension', 'modes_engine', 'motion_engine', 'motion_ball', 'motion_suspension',
  'motion_cantilever', 'open', 'report_superelement', 'report_reduction', 'study'];
const ofSite = ['index.html', 'docs/start/install.html', 'docs/tutorials/bracket/index.html', 'docs/howto/parts.html', 'docs/reference/commands.html',
  'docs/reference/messages.html', 'cases/MECHANISM_FILE.html', 'docs/theory/floating_frame.html', 'docs/verification/references.html',
  'cases/bicycle/index.html'];

let browser;
before(async () => {
  browser = await launch();
  if (pictures) mkdirSync(pictures, { recursive: true });
});
after(() => browser.close());

async function check(file, name, isOurs) {
  const faults = [];
  for (const scheme of ['light', 'dark']) {
    for (const width of [1400, 700]) {
      const context = await browser.newContext({ viewport: { width, height: 900 }, colorScheme: scheme, reducedMotion: 'reduce' });
      const page = await context.newPage();
      const place = `${name}, ${scheme}, ${width} px`;
      page.on('console', (m) => { if (['error', 'warning'].includes(m.type())) faults.push(`${place}: complains: ${m.text()}`); });
      page.on('pageerror', (e) => faults.push(`${place}: ${e.message}`));
      await page.goto(pathToFileURL(file).href);
      if (isOurs) await page.waitForFunction(() => document.documentElement.dataset.ready, null, { timeout: 120_000 });
      await page.waitForTimeout(300); // plots are drawn in the next frame
      if (pictures) await page.screenshot({ path: join(pictures, `${name}.${scheme}.${width}.png`), fullPage: isOurs });
      const wider = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
      if (wider > 0) faults.push(`${place}: wider than the window by ${wider} px`);
      // The same page in another window has the same elements: axe's rules are asked where contrast or layout differ.
      await page.evaluate(axe);
      const { violations } = await page.evaluate(() => axe.run(document, { resultTypes: ['violations'], preload: false }));
      for (const v of violations) {
        faults.push(`${place}: ${v.id} (${v.impact}): ${v.help}: ${v.nodes.slice(0, 3).map((n) => n.target.join(' ')).join('; ')}`);
      }
      await context.close();
    }
  }
  assert.equal(faults.length, 0, `\n${faults.join('\n')}`);
}

test('there is a page of every kind', () => {
  const there = readdirSync(pages).filter((f) => f.endsWith('.html')).map((f) => f.replace(/\.html$/, ''));
  for (const kind of kinds) assert.ok(there.includes(kind), `${kind} is not among ${there.join(', ')}`);
});

for (const kind of kinds) test(kind, { timeout: 300_000 }, () => check(join(pages, `${kind}.html`), kind, true));

test('assembly: the crank turned by hand moves the piston as a slider-crank does, and what the page writes runs', { timeout: 300_000 }, async () => {
  const page = await (await browser.newContext({ viewport: { width: 1400, height: 900 }, reducedMotion: 'reduce' })).newPage();
  await page.goto(pathToFileURL(join(pages, 'assembly.html')).href);
  await page.waitForFunction(() => document.documentElement.dataset.ready === 'true');
  assert.equal(await page.evaluate(() => flexura.freedom), 1);
  const [radius, length] = [0.025, 0.1]; // [m], cases/assembly
  for (const turn of [0.5, 1.5, 3, -1, 0]) {
    assert.ok(await page.evaluate((q) => flexura.drive('block_crankshaft', 'angle', q), turn));
    const { crank, piston } = await page.evaluate(() => ({ crank: flexura.pose('crankshaft'), piston: flexura.pose('piston') }));
    const pin = [0, 1, 2].map((i) => crank[8 + i] * radius); // the crank's z axis, matrices go by columns
    // STEP keeps placements to some 1e-9 m, and the loop closes no better.
    assert.ok(Math.abs(piston[14] - (pin[2] + Math.sqrt(length ** 2 - pin[0] ** 2))) < 1e-7, `${turn}: ${piston[14]}`);
  }
  // The text is a mechanism file: the same joints, found right by the program.
  const { mechanism, interfaces } = await page.evaluate(() => flexura.texts());
  writeFileSync(join(pages, 'assembly', 'decided.toml'), mechanism);
  const said = (file) => execFileSync('flexura', ['check', join(pages, 'assembly', file)], { encoding: 'utf8' }).replace(/^.*\.toml.*$/gm, '');
  assert.equal(said('decided.toml'), said('mechanism.toml'));
  // So are the interfaces those of the part files.
  const [file, text] = Object.entries(interfaces).find(([name]) => name.includes('connecting_rod'));
  const tables = (toml) => toml.replace(/^#.*\n/gm, '').match(/\[interface[^]*?(?=\n\[|$)/g).map((t) => t.trim()).sort();
  assert.deepEqual(tables(text), tables(readFileSync(join(pages, 'assembly', file), 'utf8')));
  await page.context().close();
});

for (const name of ofSite) {
  test(`site: ${name}`, { timeout: 300_000 }, () => {
    const file = join(site, name);
    assert.ok(existsSync(file), `${file} is not there: build the site with docs/build`);
    return check(file, `site_${name.replace(/\.html$/, '').replaceAll('/', '_')}`, false);
  });
}
