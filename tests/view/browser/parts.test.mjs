// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// The page of parts: a four-bar linkage of boxes on hinges along z, of which the positions are known, and a part alone.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { launch, open } from './browser.mjs';

let browser;
before(async () => { browser = await launch(); });
after(() => browser.close());

// As write_pages.cpp draws it: A at the origin, D on x; crank AB, coupler BC, rocker DC.
const [ground, crank, coupler, rocker] = [4, 1, 3.5, 3];
/** C for a crank angle: the crossing of the circles about B and D, on the side away from A B D's right. */
function pointC(angle) {
  const B = [crank * Math.cos(angle), crank * Math.sin(angle)];
  const d = Math.hypot(ground - B[0], B[1]);
  const along = (coupler ** 2 - rocker ** 2 + d ** 2) / (2 * d);
  const off = Math.sqrt(coupler ** 2 - along ** 2);
  const u = [(ground - B[0]) / d, -B[1] / d];
  return [B[0] + along * u[0] - off * u[1], B[1] + along * u[1] + off * u[0]];
}
const place = (matrix, p) => [0, 1, 2].map((i) => matrix[i] * p[0] + matrix[4 + i] * p[1] + matrix[8 + i] * p[2] + matrix[12 + i]);

async function linkage(work) {
  const page = await open(browser, 'parts.html', { viewport: { width: 1400, height: 900 } });
  assert.equal(await page.evaluate(() => document.documentElement.dataset.ready), 'true', page.complaints.join('\n'));
  await work(page);
  assert.deepEqual(page.complaints, []);
  assert.deepEqual(page.requests.filter((url) => !/^(file|blob|data):/.test(url)), []);
  await page.context().close();
}

test('a plane loop of four hinges has one freedom and three rows too many', () => linkage(async (page) => {
  assert.equal(await page.evaluate(() => flexura.freedom), 1);
  const rows = async () => (await page.evaluate(() => flexura.joints())).reduce((n, j) => n + j.redundant, 0);
  assert.equal(await rows(), 3);
  // A hinge that may slide as well takes a row away that was one too many.
  await page.evaluate(() => flexura.change('crank_coupler', { type: 'cylindrical' }));
  assert.equal(await page.evaluate(() => flexura.freedom), 1);
  assert.equal(await rows(), 2);
  // Opened, three hinges in a chain.
  await page.evaluate(() => flexura.change('crank_coupler', { accepted: false }));
  assert.equal(await page.evaluate(() => flexura.freedom), 3);
  assert.equal(await rows(), 0);
}));

test('the crank turned, the rocker stands where the circles cross', () => linkage(async (page) => {
  const start = Math.PI / 3;
  for (const turn of [0.4, 1.7, 3.0, -0.3, -2.5, 0]) {
    assert.ok(await page.evaluate((q) => flexura.drive('frame_crank', 'angle', q), turn), `${turn}`);
    const rockerPose = await page.evaluate(() => flexura.pose('rocker'));
    const [x, y, z] = place(rockerPose, [rocker, 0, 0]);
    const wanted = pointC(start + turn);
    // Newton's method ends at 1e-11 of the size of all, 6 m.
    assert.ok(Math.hypot(x - wanted[0], y - wanted[1], z) < 1e-9, `${turn}: ${[x, y, z]} ${wanted}`);
    assert.ok(Math.abs(await page.evaluate(() => flexura.coordinate('frame_crank', 'angle')) - turn) < 1e-10);
  }
}));

test('a rocker goes as far as crank and coupler let it', () => linkage(async (page) => {
  const went = await page.evaluate(() => flexura.drive('frame_rocker', 'angle', 2.5));
  assert.equal(went, false);
  const [x, y] = place(await page.evaluate(() => flexura.pose('rocker')), [rocker, 0, 0]);
  // Dead points: crank and coupler in line, C at coupler - crank or coupler + crank from A; this way the shorter one. The last step
  // that failed is 4e-4 rad at most, and AC changes by AD DC sin(ADC) / AC = 3 m with each.
  assert.ok(Math.abs(Math.hypot(x, y) - (coupler - crank)) < 1.2e-3, `${Math.hypot(x, y)}`);
  // The slider says so and stays there.
  await page.evaluate(() => flexura.chooseJoint('frame_rocker'));
  const slider = page.locator('#drive-angle');
  await slider.evaluate((e) => { e.value = '170'; e.dispatchEvent(new Event('input', { bubbles: true })); });
  assert.ok(Number(await slider.inputValue()) < 120);
  assert.match(await page.locator('.toast').textContent(), /no further/);
}));

test('what is decided stands in the text', () => linkage(async (page) => {
  const before = (await page.evaluate(() => flexura.texts())).mechanism;
  assert.match(before, /\[joint\.crank_coupler\]\ntype = "revolute"\nfrom = "crank\.crank_coupler"\nto = "coupler\.crank_coupler"\n/);
  // The marker on the crank is at its far end, whatever the crank's pose.
  const marker = before.match(/\[body\.crank\.marker\.crank_coupler\]\non = "face2"\nposition = \[([^\]]+)\]/);
  assert.ok(marker, before);
  const p = marker[1].split(',').map(Number);
  assert.ok(Math.hypot(p[0] - crank, p[1], p[2]) < 1e-14, `${p}`);
  await page.locator('.joint[data-joint="crank_coupler"] select').first().selectOption('spherical');
  await page.locator('.joint[data-joint="frame_rocker"] input[type=checkbox]').uncheck();
  const after = (await page.evaluate(() => flexura.texts())).mechanism;
  assert.match(after, /# proposed was revolute\n\[joint\.crank_coupler\]\ntype = "spherical"/);
  assert.ok(!after.includes('frame_rocker'));
  assert.match(after, /^# degrees of freedom: /m);
  // Every part gets the tables of the faces that its joints sit on, and no others.
  const { interfaces } = await page.evaluate(() => flexura.texts());
  assert.deepEqual(Object.keys(interfaces).sort(), ['parts/bar1.toml', 'parts/bar2.toml', 'parts/bar3.toml', 'parts/frame.toml']);
  assert.match(interfaces['parts/bar1.toml'], /^\[interface\.face1\]\n# plane.*\nby = "plane"\npoint.*\n\[interface\.face2\]\n/s);
  // The tab shows the same, and it can be saved.
  await page.locator('#tab-text').click();
  assert.equal(await page.locator('pre[data-text="mechanism.toml"]').textContent(), after);
  const [saved] = await Promise.all([page.waitForEvent('download'), page.locator('.texts .card').first().getByText('Save').click()]);
  assert.equal(saved.suggestedFilename(), 'mechanism.toml');
}));

test('a click finds the face whose number stands there', () => linkage(async (page) => {
  // Straight from above the coupler's top is what is seen; a click chooses its part, whose faces get numbers.
  await page.locator('#glyphs').click();
  await page.evaluate(() => flexura.view('iso'));
  const C = await page.evaluate(() => flexura.project(flexura.pose('coupler').slice(12, 15).map((x, i) => x + flexura.pose('coupler')[i] * 1.75 + (i === 2 ? 0.1 : 0))));
  const picked = await page.evaluate(([x, y]) => flexura.pick(x, y), C);
  assert.equal(await page.evaluate((b) => flexura.header.bodies[b].name, picked.body), 'coupler');
  await page.evaluate(([x, y]) => flexura.click(x, y), C);
  const numbers = await page.evaluate(() => flexura.numbers());
  assert.ok(numbers.length >= 2, JSON.stringify(numbers));
  for (const { face, x, y } of numbers) {
    const there = await page.evaluate(([px, py]) => flexura.pick(px, py), [x, y]);
    assert.equal(there.face, face, JSON.stringify({ face, x, y, there }));
  }
}));

test('a joint is made between two clicked faces', () => linkage(async (page) => {
  await page.evaluate(() => flexura.change('crank_coupler', { accepted: false }));
  await page.locator('#glyphs').click();
  const at = async (body) => page.evaluate((b) => {
    // A pixel at which nothing but this body is under the pointer, looked for on a grid.
    const canvas = document.querySelector('canvas');
    for (let y = 4; y < canvas.clientHeight; y += 7) for (let x = 4; x < canvas.clientWidth; x += 7) {
      const what = flexura.pick(x, y);
      if (what.body >= 0 && flexura.header.bodies[what.body].name === b) return [x, y, what.face];
    }
    return null;
  }, body);
  const [first, second] = [await at('crank'), await at('coupler')];
  for (const [x, y] of [first, second]) await page.locator('canvas').click({ position: { x, y } });
  await page.locator('#new-type').selectOption('spherical');
  await page.locator('#new-joint').click();
  const joints = await page.evaluate(() => flexura.joints());
  assert.deepEqual({ ...joints.at(-1), redundant: 0 }, { name: 'crank_coupler_2', type: 'spherical', accepted: true, redundant: 0, a: 'crank', b: 'coupler' });
  const { mechanism } = await page.evaluate(() => flexura.texts());
  assert.match(mechanism, /# made on the page\n(# .*\n)*\[joint\.crank_coupler_2\]/);
}));

test('faces of a part alone are ticked and their interfaces written', async () => {
  const page = await open(browser, 'faces.html', { viewport: { width: 1400, height: 900 } });
  const numbers = await page.evaluate(() => flexura.numbers());
  assert.equal(numbers.length, 3, JSON.stringify(numbers)); // a box from a corner
  const { x, y, face } = numbers[0];
  await page.locator('canvas').click({ position: { x, y: y + 12 } });
  const other = [1, 2, 3, 4, 5, 6].find((n) => n !== face);
  await page.locator('#tab-faces').click();
  await page.locator(`tr[data-face="${other}"] input`).check();
  const { interfaces } = await page.evaluate(() => flexura.texts());
  const [text] = Object.values(interfaces);
  for (const n of [face, other]) assert.match(text, new RegExp(`\\[interface\\.face${n}\\]`));
  assert.equal(text.match(/\[interface/g).length, 2);
  await page.locator('#tab-text').click();
  assert.equal(await page.locator('pre').textContent(), text);
  assert.deepEqual(page.complaints, []);
  await page.context().close();
});
