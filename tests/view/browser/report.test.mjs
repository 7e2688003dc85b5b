// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// The report page of tests/view/write_pages.cpp: a table, a plot of a sine, notices.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { after, before, test } from 'node:test';
import { contrast, launch, open } from './browser.mjs';

let browser;
let page;
before(async () => {
  browser = await launch();
  page = await open(browser, 'report.html');
});
after(() => browser.close());

test('opens from disk without a complaint and asks the network for nothing', async () => {
  assert.equal(await page.evaluate(() => document.documentElement.dataset.ready), 'true');
  assert.deepEqual(page.complaints, []);
  assert.deepEqual(page.requests.filter((url) => !/^(file|blob|data):/.test(url)), []);
});

test('is read without a script', async () => {
  const context = await browser.newContext({ javaScriptEnabled: false });
  const plain = await context.newPage();
  await plain.goto(page.url());
  assert.equal(await plain.locator('table.data tbody tr').count(), 3);
  assert.ok(await plain.locator('svg.report-plot path.curve').first().isVisible());
  await context.close();
});

test('columns sort by their numbers and turn round', async () => {
  const runs = () => page.locator('table.data tbody tr td:first-child').allTextContents();
  await page.getByRole('button', { name: 'wall time' }).click();
  assert.deepEqual(await runs(), ['rigid', 'modal', 'full']);
  await page.getByRole('button', { name: 'error' }).click();
  assert.deepEqual(await runs(), ['full', 'modal', 'rigid']);
  await page.getByRole('button', { name: 'error' }).click();
  assert.deepEqual(await runs(), ['rigid', 'modal', 'full']);
});

test('tables and plots are saved as CSV with every digit', async () => {
  const csv = async (name) => {
    const [file] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', { name }).click()]);
    return (await readFile(await file.path(), 'utf8')).trim().split('\n');
  };
  const table = await csv('Save Runs as CSV');
  assert.equal(table.length, 4);
  assert.ok(table.includes('"modal",0.3125,0.0002'));
  const plot = await csv('Save Signals as CSV');
  assert.equal(plot.length, 202);
  assert.equal(plot[0], '"sine: time [s]","sine: signal [m]","points: time [s]","points: signal [m]"');
  const [t, y] = plot[26].split(',').map(Number);
  assert.equal(t, 0.25);
  assert.ok(Math.abs(y - 1) < 1e-15);
});

test('the pointer reads values off the plot', async () => {
  const svg = page.locator('svg.report-plot');
  await svg.scrollIntoViewIfNeeded();
  const box = await svg.boundingBox();
  const [x0, , x1] = (await svg.getAttribute('data-frame')).split(' ').map(Number);
  const [low, high] = (await svg.getAttribute('data-x')).split(' ').map(Number);
  // The user unit of the picture, less its padding: where t = 1 is.
  const at = await page.evaluate(([x]) => {
    const p = new DOMPoint(x, 100).matrixTransform(document.querySelector('svg.report-plot').getScreenCTM());
    return [p.x, p.y];
  }, [x0 + ((1 - low) / (high - low)) * (x1 - x0)]);
  assert.ok(at[0] > box.x && at[0] < box.x + box.width);
  await page.mouse.move(at[0], at[1]);
  const tip = await page.locator('.tip').textContent();
  assert.match(tip, /sine: 1(\.000)?, /);
  assert.match(tip, /b · points: 1(\.000)?, 0\.8/);
});

test('numbers of a plot are a table for those who do not see it', async () => {
  await page.locator('details.numbers summary').click();
  // The table is filled when the browser says that it was opened, a little after the click.
  await page.locator('details.numbers tbody tr').first().waitFor();
  assert.equal(await page.locator('details.numbers tbody tr').count(), 204);
  await page.locator('details.numbers summary').click();
  assert.match(await page.locator('svg.report-plot').getAttribute('aria-label'), /^Signals: signal over time; curves sine, points/);
});

test('text is legible in both themes, controls have names, links lead to sections', async () => {
  for (const colorScheme of ['light', 'dark']) {
    await page.emulateMedia({ colorScheme });
    // WCAG 2.1, level AA.
    for (const selector of ['.fact-list dt', 'thead th', 'td.number', 'td.bad', 'td.good', '.notice.warning', 'main p']) {
      const ratio = await page.evaluate(contrast, selector);
      assert.ok(ratio >= 4.5, `${colorScheme} ${selector}: contrast ${ratio}`);
    }
  }
  const nameless = await page.locator('button').evaluateAll((list) => list.filter((e) =>
    !(e.getAttribute('aria-label') || e.textContent.trim())).length);
  assert.equal(nameless, 0);
  for (const link of await page.locator('nav a').all()) {
    assert.equal(await page.locator(await link.getAttribute('href')).count(), 1);
  }
});

test('dark is the same whether the system or the reader asks for it', async () => {
  const colors = () => page.evaluate(() => {
    const names = [...document.styleSheets].flatMap((sheet) => [...sheet.cssRules]).filter((r) => r.selectorText === ':root')
      .flatMap((r) => [...r.style]).filter((n) => n.startsWith('--'));
    const style = getComputedStyle(document.documentElement);
    return Object.fromEntries(names.map((n) => [n, style.getPropertyValue(n).trim()]));
  });
  await page.emulateMedia({ colorScheme: 'light' });
  const light = await colors();
  await page.emulateMedia({ colorScheme: 'dark' });
  const system = await colors();
  await page.emulateMedia({ colorScheme: 'light' });
  await page.evaluate(() => { document.documentElement.dataset.theme = 'dark'; });
  assert.deepEqual(await colors(), system);
  assert.ok(Object.keys(system).length > 30);
  for (const [name, value] of Object.entries(light)) assert.ok(system[name] !== value, `${name} is not darkened`);
  await page.evaluate(() => { delete document.documentElement.dataset.theme; });
});

test('on paper there are no buttons and the plots are there', async () => {
  // White paper, whatever the screen's theme.
  await page.emulateMedia({ media: 'print', colorScheme: 'dark' });
  assert.equal(await page.evaluate(() => getComputedStyle(document.body).backgroundColor), 'rgb(255, 255, 255)');
  await page.emulateMedia({ media: 'print', colorScheme: 'light' });
  assert.equal(await page.locator('.card-buttons').first().isVisible(), false);
  assert.equal(await page.locator('nav').isVisible(), false);
  assert.ok(await page.locator('svg.report-plot').isVisible());
  const pdf = await page.pdf();
  assert.ok(pdf.length > 10_000);
  await page.emulateMedia({ media: 'screen' });
});
