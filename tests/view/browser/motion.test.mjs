// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// The motion page of the synthetic slider-crank (tests/view/synthetic.hpp): closed-form motion, two runs.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { difference, launch, magenta, open, picture } from './browser.mjs';

const radius = 0.25;
const rod = 1.0;
const sliderAt = (t) => {
  const angle = 2 * Math.PI * t;
  return radius * Math.cos(angle) + rod * Math.cos(Math.asin((radius * Math.sin(angle)) / rod));
};
const modal = (j, t) => (0.002 / (j + 1)) * Math.sin(2 * Math.PI * (2 + j) * t);

let browser;
let page;
before(async () => {
  browser = await launch();
  page = await open(browser, 'motion.html');
});
after(() => browser.close());

test('opens from disk without a complaint and asks the network for nothing', async () => {
  assert.equal(await page.evaluate(() => document.documentElement.dataset.ready), 'true');
  assert.deepEqual(page.complaints, []);
  assert.deepEqual(page.requests.filter((url) => !/^(file|blob|data):/.test(url)), []);
});

test('the time slider moves the slider-crank', async () => {
  const first = await picture(page);
  const time = page.locator('#time');
  await time.focus();
  await page.evaluate(() => {
    const input = document.getElementById('time');
    input.value = '0.4';
    input.dispatchEvent(new Event('input', { bubbles: true }));
  });
  assert.equal(await page.evaluate(() => flexura.time), 0.4);
  const second = await picture(page);
  assert.ok(difference(first, second) > 0.01 * first.width * first.height);
  const pose = await page.evaluate(() => flexura.pose('flexible', 'slider'));
  assert.ok(Math.abs(pose[0] - sliderAt(0.4)) < 1e-6); // 0.4 s is a stored row; poses have 24 bits
});

test('between stored rows bodies are interpolated', async () => {
  // Rows are 5 ms apart: linear interpolation is off by h^2/8 of the largest acceleration, r (2 pi)^2 (1 + r/l).
  const bound = (0.005 ** 2 / 8) * radius * (2 * Math.PI) ** 2 * (1 + radius / rod) * 1.05 + 1e-6;
  for (const t of [0.1234, 0.7777, 1.9981]) {
    const { slider, pin } = await page.evaluate((at) => {
      flexura.setTime(at);
      return { slider: flexura.pose('rigid', 'slider')[0], pin: flexura.place('rigid', 'rod', [1, 0, 0]) };
    }, t);
    assert.ok(Math.abs(slider - sliderAt(t)) < bound, `${slider} ${sliderAt(t)}`);
    assert.ok(Math.hypot(pin[0] - slider, pin[1], pin[2]) < 2 * bound, 'the rod ends in the slider');
  }
});

test('the flexible rod bends by its modal coordinates, magnified, on the graphics card as well', async () => {
  const t = 0.125;
  const [i, j] = [20, 0]; // ring at mid length of the 32 x 40 tube, at the top of y
  const p = [0.5, 0.06, 0];
  let u = [0, 0, 0];
  for (let k = 0; k < 4; ++k) {
    const wave = (Math.floor(k / 2) + 1) * Math.PI;
    const axis = k % 2 === 0 ? 1 : 2;
    const s = modal(k, t);
    u[axis] += s * Math.sin(wave * p[0]);
    u[0] += -s * wave * Math.cos(wave * p[0]) * p[axis];
  }
  const magnify = 50;
  const { deformed, place } = await page.evaluate(([at, v, m, q]) => {
    flexura.setMagnify(m);
    flexura.setTime(at);
    return { deformed: flexura.deformed('flexible', 'rod', v), place: flexura.place('flexible', 'rod', q) };
  }, [t, i * 32 + j, magnify, p.map((x, a) => x + magnify * u[a])]);
  // 16-bit shapes: half a step of each, 50 x 4 x 0.002 / 65534, and 24-bit poses.
  for (let a = 0; a < 3; ++a) assert.ok(Math.abs(deformed[a] - place[a]) < 1e-5, `${deformed} ${place}`);

  await page.evaluate((v) => { flexura.view('+z'); flexura.mark('flexible', 'rod', v); }, i * 32 + j);
  const expected = await page.evaluate((q) => flexura.project(q), place);
  const found = magenta(await picture(page));
  assert.ok(found && found.n > 30, 'the dot is not on the picture');
  assert.ok(Math.hypot(found.x - expected[0], found.y - expected[1]) < 1.0, `${found.x} ${found.y} ${expected}`);
  await page.evaluate(() => { flexura.mark('flexible', 'rod', -1); flexura.view('iso'); });
});

test('plots show the stored numbers', async () => {
  assert.deepEqual(await page.evaluate(() => flexura.plots()),
                   [['slider.position'], ['crank.speed'], ['rod.deflection'], ['energy.kinetic', 'energy.strain']]);
  const [rigid, flexible] = await page.evaluate(() => flexura.plotted(1));
  assert.equal(rigid.run, 'rigid');
  assert.equal(flexible.unit, 'rad/s');
  assert.equal(flexible.values.length, 401);
  flexible.values.forEach((v, k) => {
    const t = flexible.time[k];
    // Stored as 64-bit numbers; the two libraries' sine may differ in the last place.
    assert.ok(Math.abs(v - (2 * Math.PI + 0.2 * Math.sin(16 * Math.PI * t))) < 1e-13, `${v} at ${t}`);
    assert.ok(Math.abs(rigid.values[k] - 2 * Math.PI) < 1e-14);
  });
  // And the number printed under the plot is the one at the current time.
  await page.evaluate(() => flexura.setTime(0.25));
  const text = await page.locator('.card').first().locator('.plot-values').textContent();
  assert.match(text, new RegExp(`flexible${sliderAt(0.25).toPrecision(5)}`));
});

test('stress of the rod is that of its modal coordinates', async () => {
  const t = 0.125;
  const [i, j] = [20, 4]; // mid length, an eighth of the way round
  const p = [0.5, 0.06 * Math.cos(Math.PI / 4), 0.06 * Math.sin(Math.PI / 4)];
  let sigma = 0;
  for (let k = 0; k < 4; ++k) {
    const wave = (Math.floor(k / 2) + 1) * Math.PI;
    sigma += modal(k, t) * 2.1e11 * wave ** 2 * Math.sin(wave * p[0]) * p[k % 2 === 0 ? 1 : 2];
  }
  const { found, most } = await page.evaluate(([at, v]) => {
    flexura.setField(5);
    flexura.setTime(at);
    return { found: flexura.vonMises('flexible', 'rod', v), most: flexura.largestStress };
  }, [t, i * 32 + j]);
  // Four modes, each quantised to half a step of 1023 of its own largest stress.
  const half = [0, 1, 2, 3].reduce((sum, k) => sum + 0.5 / 1023 * 0.002 / (k + 1) * 2.1e11 * ((Math.floor(k / 2) + 1) * Math.PI) ** 2 * 0.06, 0);
  assert.ok(Math.abs(found - Math.abs(sigma)) < half, `${found} ${sigma} ${half}`);
  assert.ok(most >= found && most < 2.1e11 * 0.06 * Math.PI ** 2 * 0.002 * (1 + 0.5 + 4 / 3 + 1), `${most}`);
  assert.match(await page.locator('.legend:not(.left)').textContent(), /von Mises \[(MPa|GPa)\]/);
  await page.evaluate(() => flexura.setField(1));
});

test('a force is an arrow that turns with the axes it is given in', async () => {
  // 1 kN along the crank, which has turned by a twentieth: -18 degrees about y.
  const t = 0.05;
  const { force, at } = await page.evaluate((time) => {
    flexura.showRun('rigid', false);
    flexura.setTime(time);
    flexura.view('-y'.replace('-', '\u2212'));
    return { force: flexura.force('flexible', 'push'), at: flexura.pose('flexible', 'slider').slice(0, 3) };
  }, t);
  const angle = 2 * Math.PI * t;
  const expected = [1000 * Math.cos(angle), 0, 1000 * Math.sin(angle)];
  for (let a = 0; a < 3; ++a) assert.ok(Math.abs(force[a] - expected[a]) < 1e-3, `${force}`); // poses have 24 bits
  // Drawn over the slider: the arrow's colour a little along it, the slider's own on the other side.
  const pink = async (x) => {
    const [r, g, b] = await page.evaluate((p) => flexura.pixel(...flexura.project(p)),
                                          at.map((c, a) => c + x * expected[a] / 1000));
    return r > 1.5 * g && r > b;
  };
  assert.equal(await pink(0.06), true);
  assert.equal(await pink(-0.06), false);
  await page.evaluate(() => flexura.showRun('rigid', true));
});

test('section forces of the beam are those of its deformation, in numbers, as a diagram and plotted', async () => {
  const t = 0.125;
  const bending = (k, x) => 2.1e11 * (Math.PI / 4) * (0.06 ** 4 - 0.04 ** 4) * ((Math.floor(k / 2) + 1) * Math.PI) ** 2
    * Math.sin((Math.floor(k / 2) + 1) * Math.PI * x);
  const exact = (at) => {
    let [M_y, M_z] = [0, 0];
    for (let k = 0; k < 4; ++k) if (k % 2 === 0) M_z -= modal(k, at) * bending(k, 0.25); else M_y += modal(k, at) * bending(k, 0.25);
    return [M_y, M_z];
  };
  const { now, plotted } = await page.evaluate(async (at) => {
    flexura.setTime(at);
    const name = flexura.addSectionForce('rod', 1, 5);
    await flexura.addPlot([name]);
    return { now: flexura.sectionForces('flexible', 'rod', 1), plotted: await flexura.plotted(flexura.plots().length - 1) };
  }, t);
  const most = 0.002 * bending(0, 0.5);
  // 24 bits of the shapes' section forces and of the modal coordinates, four of each.
  assert.ok(Math.abs(now[4] - exact(t)[0]) < 1e-6 * most && Math.abs(now[5] - exact(t)[1]) < 1e-6 * most, `${now} ${exact(t)}`);
  assert.deepEqual(plotted.map((c) => [c.run, c.name, c.unit]), [['flexible', 'rod.tube.M_z at 0.2500 m', 'N*m']]);
  plotted[0].values.forEach((v, k) => assert.ok(Math.abs(v - exact(plotted[0].time[k])[1]) < 1e-6 * most));
  // The table names the largest along the member; the diagram is seen.
  await page.locator('#tab-sections').click();
  assert.match(await page.locator('.section-forces tbody tr td').first().textContent(), /rod: tube/);
  assert.ok(Number(await page.locator('.section-forces button.value').nth(5).textContent().then((s) => s.replace(/[\s]/g, '').replace('−', '-'))) !== 0);
  // M_z is drawn along the member's y: seen along y it would be a line.
  await page.evaluate(() => flexura.view('iso'));
  const without = await picture(page);
  await page.selectOption('#sections', '5');
  assert.ok(difference(without, await picture(page)) > 500);
  await page.selectOption('#sections', '-1');
  assert.equal(difference(without, await picture(page)), 0);
  await page.locator('#tab-plots').click();
  await page.getByRole('button', { name: 'Remove rod.tube.M_z' }).click();
});

test('a click into a plot sets the time', async () => {
  const over = page.locator('.card').first().locator('.u-over');
  const box = await over.boundingBox();
  await over.click({ position: { x: box.width / 2, y: box.height / 2 } });
  const t = await page.evaluate(() => flexura.time);
  assert.ok(Math.abs(t - 1.0) < 2.0 / box.width * 1.5, `${t}`); // the middle, within a pixel and a half
});

test('CSV holds what is plotted', async () => {
  const csv = await page.evaluate(() => flexura.csv());
  const lines = csv.trim().split('\n');
  assert.equal(lines.length, 402);
  assert.match(lines[0], /^"rigid: time \[s\]","rigid: slider.position \[m\]","rigid: crank.speed \[rad\/s\]"/);
  const row = lines[101].split(',').map(Number);
  assert.equal(row[0], 0.5);
  assert.ok(Math.abs(row[1] - sliderAt(0.5)) < 1e-14);
});

test('runs are hidden and shown, in the picture and in the plots', async () => {
  const both = await picture(page);
  await page.locator('.toggle.run', { hasText: 'flexible' }).click();
  const one = await picture(page);
  assert.ok(difference(both, one) > 1000);
  assert.deepEqual((await page.evaluate(() => flexura.plotted(0))).map((c) => c.run), ['rigid']);
  await page.locator('.toggle.run', { hasText: 'flexible' }).click();
});

test('the spectrum of the crank\'s ripple stands at 8 Hz', async () => {
  const card = page.locator('.card').nth(1);
  await card.getByRole('button', { name: 'Spectrum' }).click();
  const { frequency, amplitude } = await page.evaluate(() => flexura.spectrum('flexible', 'crank.speed'));
  const peak = amplitude.indexOf(Math.max(...amplitude));
  assert.ok(Math.abs(frequency[peak] - 8) < 1e-9, `${frequency[peak]} Hz`); // 16 periods in the 2 s: on a line
  // 512 points between 401 rows: linear interpolation of a sine with 25 rows a period loses up to (pi/25)^2/3 = 0.5 %.
  assert.ok(Math.abs(amplitude[peak] - 0.2) < 0.006 * 0.2, `${amplitude[peak]} rad/s`);
  await card.getByRole('button', { name: 'Spectrum' }).click();
});

test('warnings and summaries are visible and harmless', async () => {
  assert.match(await page.locator('.warnings summary').textContent(), /3 warnings/);
  await page.locator('#tab-summary').click();
  const text = await page.locator('.summary').textContent();
  assert.match(text, /stopped early: end of the test's patience/);
  assert.match(text, /one <b>warning<\/b>/);
  assert.match(text, /energy error3\.2/);
  await page.locator('#tab-quantities').click();
  await page.locator('.quantities tbody tr').first().waitFor();
  await page.locator('#tab-plots').click();
  assert.deepEqual(page.complaints, []);
});

test('the camera follows a body', async () => {
  await page.selectOption('#follow', 'slider');
  const place = async (t) => page.evaluate((at) => {
    flexura.setTime(at);
    return flexura.project(flexura.pose('flexible', 'slider').slice(0, 3));
  }, t);
  const a = await place(0.1);
  const b = await place(0.45);
  assert.ok(Math.hypot(a[0] - b[0], a[1] - b[1]) < 1.0, `${a} ${b}`); // the same pixel
  await page.selectOption('#follow', '');
});
