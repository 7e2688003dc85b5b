// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Nothing lies over anything else, at every width of a window; units have an axis each; what is printed is whole.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { launch, open } from './browser.mjs';

let browser;
before(async () => { browser = await launch(); });
after(() => browser.close());

/** Pairs of these elements that are seen and share more than a pixel, and those that leave the window sideways. */
const conflicts = (page, selectors) => page.evaluate((list) => {
  const seen = list.flatMap((selector) => [...document.querySelectorAll(selector)].filter((e) => e.checkVisibility())
    .map((e) => ({ name: `${selector} ${e.textContent.slice(0, 20)}`, e, box: e.getBoundingClientRect() })));
  const out = [];
  for (const [i, a] of seen.entries()) {
    if (a.box.right > document.documentElement.clientWidth + 1) out.push(`${a.name} leaves the window`);
    for (const b of seen.slice(i + 1)) {
      if (a.e.contains(b.e) || b.e.contains(a.e)) continue;
      const wide = Math.min(a.box.right, b.box.right) - Math.max(a.box.left, b.box.left);
      const high = Math.min(a.box.bottom, b.box.bottom) - Math.max(a.box.top, b.box.top);
      if (wide > 1 && high > 1) out.push(`${a.name} / ${b.name}`);
    }
  }
  return out;
}, selectors);

const overlays = ['.legend', '.runs button', '.caption', '.corner', '.probe', '.triad', '.strip', '.panel-head .search', '.tabs'];
for (const [width, height] of [[1280, 800], [1024, 600], [760, 900], [600, 900], [480, 900], [360, 740]]) {
  test(`at ${width} x ${height} nothing on the pages lies over anything else`, async () => {
    const viewport = { width, height };
    const motion = await open(browser, 'motion.html', { viewport });
    assert.deepEqual(await conflicts(motion, overlays), []);
    const legend = '.plot-values dt, .plot-values dd';
    assert.deepEqual(await conflicts(motion, [legend]), []);
    // Names as long as they come, and numbers with exponents.
    await motion.evaluate(() => document.querySelectorAll('.plot-values').forEach((list) => list.querySelectorAll('div').forEach((row) => {
      row.querySelector('dt span').textContent = 'crank_rocker_web_8mm: coupler.strain_energy_of_the_coupler_link';
      row.querySelector('dd').textContent = '−2.3961·10⁻¹⁰⁶';
    })));
    assert.deepEqual(await conflicts(motion, [legend]), []);
    // And no number is cut off.
    assert.deepEqual(await motion.evaluate(() => [...document.querySelectorAll('.plot-values dd')].filter((dd) =>
      dd.scrollWidth > dd.clientWidth + 1 || dd.getBoundingClientRect().right > dd.closest('.card').getBoundingClientRect().right).length), 0);
    const modes = await open(browser, 'modes.html', { viewport });
    await modes.evaluate(() => flexura.mark(30));
    assert.deepEqual(await conflicts(modes, overlays), []);
    if (width > 600) return;
    // On small screens nothing but the triad and labels lies on the picture.
    for (const page of [motion, modes]) {
      assert.deepEqual(await conflicts(page, ['.stage', '.legend', '.runs', '.caption', '.corner', '.probe']), []);
    }
  });
}

test('two units have an axis each, and three two plots', async () => {
  const page = await open(browser, 'motion.html');
  const before = await page.evaluate(() => flexura.plots().length);
  await page.evaluate(() => flexura.addPlot(['slider.position', 'crank.speed', 'rod.deflection']));
  // [m] and [rad/s]: labels of both, beside time's.
  const labels = await page.evaluate(() => [...document.querySelectorAll('.card .plot')].at(-1).querySelectorAll('.u-axis').length);
  assert.equal(labels, 3);
  assert.match(await page.locator('.card .plot-values').last().textContent(), /m.*rad\/s/);
  await page.evaluate(() => flexura.addPlot(['slider.position', 'crank.speed', 'energy.kinetic']));
  assert.deepEqual((await page.evaluate(() => flexura.plots())).slice(before + 1), [['slider.position', 'crank.speed'], ['energy.kinetic']]);
});

test('the run that is hidden leaves no scale behind, and the next one is solid', async () => {
  const page = await open(browser, 'motion.html');
  assert.ok(await page.locator('.legend:not(.left)').isVisible());
  await page.locator('.runs button', { hasText: 'flexible' }).click();
  assert.equal(await page.evaluate(() => flexura.mode), 0); // the rigid run: nothing of it is coloured
  await page.locator('.runs button', { hasText: 'rigid' }).click();
  assert.equal(await page.locator('.legend:not(.left)').isVisible(), false);
  await page.locator('.runs button', { hasText: 'flexible' }).click();
  assert.ok(await page.locator('.legend:not(.left)').isVisible());
});

test('the largest values are stated, and a click shows place and time', async () => {
  const page = await open(browser, 'motion.html');
  const { stress, displacement } = await page.evaluate(() => flexura.largest);
  for (const [field, peak] of [[1, displacement], [5, stress]]) {
    await page.locator(`.facts [data-peak="${field}"]`).click();
    assert.equal(await page.evaluate(() => flexura.time), peak.time);
    if (field === 5) {
      const drawn = await page.evaluate((v) => flexura.vonMises('flexible', 'rod', v), peak.vertex);
      // Steps of 1/1023 of each of the four modes' largest stress.
      assert.ok(Math.abs(drawn - peak.value) < 4e-3 * peak.value, `${drawn} ${peak.value}`);
    }
  }
});

test('printed plots are as wide as the paper and not cut', async () => {
  const page = await open(browser, 'motion.html', { viewport: { width: 1280, height: 800 } });
  await page.evaluate(() => dispatchEvent(new Event('beforeprint')));
  await page.waitForTimeout(300);
  await page.emulateMedia({ media: 'print' });
  const widths = await page.evaluate(() => [...document.querySelectorAll('.plot canvas')].map((c) => c.clientWidth));
  assert.ok(widths.length >= 4 && widths.every((w) => w === 690), `${widths}`);
  assert.ok(await page.evaluate(() => [...document.querySelectorAll('.card')].every((c) => getComputedStyle(c).breakInside === 'avoid')));
  await page.evaluate(() => dispatchEvent(new Event('afterprint')));
});
