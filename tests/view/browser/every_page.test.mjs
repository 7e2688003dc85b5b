// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Every kind of page that the programs write (every_page.sh) and pages of the documentation's site, in both themes, at 1400 and at
// 700 pixels: axe-core finds no violation of accessibility, nothing is wider than the window, the page complains of nothing.
// With $FLEXURA_SCREENSHOTS their pictures go into that folder, to be looked at (the script "screenshots").
import assert from 'node:assert/strict';
import { existsSync, mkdirSync, readFileSync, readdirSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { launch, pages } from './browser.mjs';

const axe = readFileSync(join('node_modules', 'axe-core', 'axe.min.js'), 'utf8');
const site = process.env.FLEXURA_SITE;
const pictures = process.env.FLEXURA_SCREENSHOTS;
const kinds = ['modes_solid', 'modes_beams', 'modes_suspension', 'modes_engine', 'motion_engine', 'motion_ball', 'motion_suspension',
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
      const { violations } = await page.evaluate(() => axe.run(document, { resultTypes: ['violations'] }));
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

for (const name of ofSite) {
  test(`site: ${name}`, { timeout: 300_000 }, () => {
    const file = join(site, name);
    assert.ok(existsSync(file), `${file} is not there: build the site with docs/build`);
    return check(file, `site_${name.replace(/\.html$/, '').replaceAll('/', '_')}`, false);
  });
}
