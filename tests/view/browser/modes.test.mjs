// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// The modes page of the synthetic tube (tests/view/synthetic.hpp): its shapes are known in closed form.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { after, before, test } from 'node:test';
import { PNG } from 'pngjs';
import { contrast, difference, launch, magenta, open, picture, through } from './browser.mjs';

const length = 1.0;
const radius = 0.06;
const around = 48;
const along = 60;

/** Vertex j of ring i on the outer wall. */
const vertex = (i, j) => i * around + j;
const place = (i, j) => {
  const angle = (2 * Math.PI * j) / around;
  return [(length * i) / along, radius * Math.cos(angle), radius * Math.sin(angle)];
};
/** Shape k at a point, largest displacement anywhere on the tube, both before scaling. */
function shape(k, p) {
  const wave = ((Math.floor(k / 2) + 1) * Math.PI) / length;
  const axis = k % 2 === 0 ? 1 : 2;
  const u = [-wave * Math.cos(wave * p[0]) * p[axis], 0, 0];
  u[axis] = Math.sin(wave * p[0]);
  return u;
}
function largest(k) {
  let most = 0;
  for (let i = 0; i <= along; ++i) {
    for (let j = 0; j < around; ++j) most = Math.max(most, Math.hypot(...shape(k, place(i, j))));
  }
  return most;
}

let browser;
let page;
before(async () => {
  browser = await launch();
  page = await open(browser, 'modes.html');
});
after(() => browser.close());

test('opens from disk without a complaint and asks the network for nothing', async () => {
  assert.equal(await page.evaluate(() => document.documentElement.dataset.ready), 'true');
  assert.deepEqual(page.complaints, []);
  assert.deepEqual(page.requests.filter((url) => !/^(file|blob|data):/.test(url)), []);
});

test('lists the frequencies', async () => {
  const rows = await page.locator('.modes tbody tr').evaluateAll((list) => list.map((row) =>
    [row.dataset.mode, row.cells[2].textContent.replace(/\s/g, '')]));
  assert.equal(rows.length, 12);
  rows.forEach(([number, text], k) => {
    assert.equal(Number(number), k + 1);
    const frequency = 100 * (Math.floor(k / 2) + 1) ** 2 * (k % 2 === 0 ? 1 : 1.01);
    // Five digits are printed.
    assert.ok(Math.abs(Number(text) - frequency) <= 0.5e-4 * frequency, `${text} is not ${frequency}`);
  });
});

test('a click on a mode changes the picture', async () => {
  await page.evaluate(() => { flexura.setPlaying(false); });
  const first = await picture(page);
  await page.locator('.modes tbody tr[data-mode="4"]').click();
  await page.waitForFunction(() => flexura.mode === 4);
  const second = await picture(page);
  assert.ok(difference(first, second) > 0.02 * first.width * first.height);
  assert.match(await page.locator('.caption').first().textContent(), /Mode 4.*404/);
});

test('from every side the part stays on the picture, however it moves', async () => {
  for (const name of ['+x', '−x', '+y', '−y', '+z', '−z', 'iso']) {
    for (const phase of [0, Math.PI]) {
      const now = await page.evaluate(([v, p]) => { flexura.setPhase(p); flexura.view(v); flexura.setPhase(p); }, [name, phase])
        .then(() => picture(page));
      const empty = now.at(0, 0).join();
      for (let x = 0; x < now.width; ++x) for (const y of [0, now.height - 1]) assert.equal(now.at(x, y).join(), empty, `${name} ${x} ${y}`);
      for (let y = 0; y < now.height; ++y) for (const x of [0, now.width - 1]) assert.equal(now.at(x, y).join(), empty, `${name} ${x} ${y}`);
    }
  }
});

test('playing moves the picture, stopping holds it', async () => {
  await page.locator('#play').click();
  const drawn = await page.evaluate(() => flexura.framesDrawn());
  await page.waitForFunction((n) => flexura.framesDrawn() > n + 3, drawn);
  await page.locator('#play').click();
  const a = await picture(page);
  assert.equal(difference(a, await picture(page)), 0);
});

test('a vertex is where the closed form says, from the page\'s data', async () => {
  const fraction = 0.1;
  const phase = 0.7;
  for (const number of [1, 2, 5]) {
    await page.evaluate(([n, f, p]) => flexura.setMode(n).then(() => { flexura.setAmplitude(f); flexura.setPhase(p); }),
                        [number, fraction, phase]);
    const size = await page.evaluate(() => flexura.size);
    assert.ok(Math.abs(size - Math.hypot(length, 2 * radius, 2 * radius)) < 1e-6);
    const scale = (fraction * size * Math.cos(phase)) / largest(number - 1);
    for (const [i, j] of [[30, 0], [15, 12], [47, 31]]) {
      const p = place(i, j);
      const u = shape(number - 1, p);
      const found = await page.evaluate((v) => flexura.deformed(v), vertex(i, j));
      for (let a = 0; a < 3; ++a) {
        // Half a step of the 16 bits, of the shape and of its largest value, and 32-bit vertices: 1e-4 of the amplitude.
        assert.ok(Math.abs(found[a] - (p[a] + scale * u[a])) < 1e-4 * fraction * size, `mode ${number}, vertex ${i} ${j}`);
      }
    }
  }
});

test('the graphics card draws the vertex there, seen in pixels', async () => {
  await page.evaluate(() => flexura.setMode(3).then(() => { flexura.setAmplitude(0.12); flexura.view('+z'); }));
  for (const phase of [0, 1.0, Math.PI]) {
    const [i, j] = [14, 12];
    await page.evaluate(([p, v]) => { flexura.setPhase(p); flexura.mark(v); }, [phase, vertex(i, j)]);
    const { camera, size } = await page.evaluate(() => ({ camera: flexura.camera(), size: flexura.size }));
    const p = place(i, j);
    const scale = (0.12 * size * Math.cos(phase)) / largest(2);
    const u = shape(2, p);
    const image = await picture(page);
    const expected = through(camera, p.map((x, a) => x + scale * u[a]), image.width, image.height);
    const found = magenta(image);
    assert.ok(found && found.n > 30, 'the dot is not on the picture');
    // The dot is a square of whole pixels: its middle is within half a pixel, the window on it within another.
    assert.ok(Math.hypot(found.x - expected.x, found.y - expected.y) < 1.0,
              `dot at ${found.x}, ${found.y}, expected ${expected.x}, ${expected.y}`);
    const rest = through(camera, p, image.width, image.height);
    assert.ok(Math.hypot(rest.x - expected.x, rest.y - expected.y) > 20, 'the test must see a displacement');
  }
  await page.evaluate(() => flexura.mark(-1));
});

test('colours follow the displacement: dark at a node of the mode, yellow where it is largest', async () => {
  // Mode 3 is sin(2 pi x / L) along y: largest at x = L/4, on the axis of bending none at L/2.
  await page.evaluate(() => flexura.setMode(3).then(() => { flexura.setField(1); flexura.setPhase(Math.PI / 2); flexura.view('+z'); }));
  const hue = async (x) => {
    const [px, py] = await page.evaluate((p) => flexura.project(p), [x, 0, radius]);
    return page.evaluate((at) => flexura.pixel(...at), [px, py]);
  };
  const most = await hue(length / 4);
  const none = await hue(length / 2);
  assert.ok(most[0] > 150 && most[1] > 130 && most[2] < 90, `yellow: ${most}`);
  assert.ok(none[2] > none[1] && none[0] < 110, `violet: ${none}`);
});

test('stress is that of the closed form, in the data, in the legend and in the picture', async () => {
  const fraction = 0.1;
  await page.evaluate((f) => flexura.setMode(1).then(() => { flexura.setAmplitude(f); flexura.setField(5); flexura.setPhase(Math.PI / 2); }),
                      fraction);
  const size = await page.evaluate(() => flexura.size);
  // sigma = E w^2 sin(w x) y for the shape, times the amplitude over the shape's largest displacement.
  const exact = (i, j) => {
    const [x, y] = place(i, j);
    return 2.1e11 * Math.PI ** 2 * Math.abs(Math.sin(Math.PI * x) * y) * fraction * size / largest(0);
  };
  for (const [i, j] of [[30, 0], [12, 5], [55, 20]]) {
    const found = await page.evaluate((v) => flexura.vonMises(v), vertex(i, j));
    // Half a step of 1023.
    assert.ok(Math.abs(found - exact(i, j)) < (0.5 / 1023 + 1e-6) * exact(30, 0), `${found} ${exact(i, j)}`);
  }
  const legend = await page.locator('.legend:not(.left)').textContent();
  assert.match(legend, /von Mises \[GPa\]/);
  assert.ok(legend.includes((exact(30, 0) / 1e9).toPrecision(3)), legend);
  await page.evaluate(() => flexura.view('+y'));
  const at = async (x) => page.evaluate((p) => flexura.pixel(...flexura.project(p)), [x, radius, 0]);
  const most = await at(0.5 * length);
  const least = await at(0.03 * length);
  assert.ok(most[0] > 150 && most[1] > 130 && most[2] < 90, `yellow: ${most}`);
  assert.ok(least[2] > least[1] && least[0] < 110, `violet: ${least}`);
  await page.evaluate(() => flexura.setField(1));
});

test('sorts by any column and finds modes by kind and range', async () => {
  const numbers = () => page.locator('.modes tbody tr').evaluateAll((rows) => rows.map((r) => Number(r.dataset.mode)));
  await page.locator('.modes th button', { hasText: 'Hz' }).click();
  assert.deepEqual(await numbers(), [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]);
  await page.locator('.modes th button', { hasText: 'Hz' }).click();
  assert.deepEqual((await numbers())[0], 12);
  await page.fill('#search', 'bending z');
  assert.deepEqual(await numbers(), [12, 10, 8, 6, 4, 2]);
  await page.fill('#search', '400..1000');
  assert.deepEqual(await numbers(), [6, 5, 4, 3]);
  await page.fill('#search', '');
  await page.locator('.modes th button', { hasText: 'No' }).click();
});

test('keys choose modes, views and the list of keys', async () => {
  await page.locator('.modes tbody tr[data-mode="2"]').click();
  await page.locator('canvas').first().focus();
  await page.keyboard.press('ArrowDown');
  await page.waitForFunction(() => flexura.mode === 3);
  await page.keyboard.press('k');
  await page.waitForFunction(() => flexura.mode === 2);
  await page.keyboard.press('?');
  assert.ok(await page.locator('dialog.help').isVisible());
  await page.keyboard.press('Escape');
});

test('struck modes give the lines for the part file and for a mechanism', async () => {
  for (const n of [7, 3]) await page.getByLabel(`Keep mode ${n}`, { exact: true }).uncheck();
  const lines = await page.locator('.struck code').allTextContents();
  assert.equal(lines[0], 'strike_modes = [3, 7]');
  assert.match(lines[1], /^modes = "1-2, 4-6, 8/);
  assert.deepEqual(await page.evaluate(() => flexura.struck()), [3, 7]);
  for (const n of [7, 3]) await page.getByLabel(`Keep mode ${n}`, { exact: true }).check();
});

test('two modes stand side by side', async () => {
  await page.locator('.modes tbody tr[data-mode="1"]').click();
  await page.locator('#compare').click();
  await page.locator('.modes tbody tr[data-mode="6"]').click();
  await page.waitForFunction(() => flexura.mode === 6);
  assert.match(await page.locator('.caption').first().textContent(), /Mode 1/);
  assert.match(await page.locator('.caption.right').textContent(), /Mode 6/);
  const image = await picture(page);
  let differs = 0;
  const half = Math.floor(image.width / 2);
  for (let y = 150; y < image.height - 150; y += 3) {
    for (let x = 100; x < half - 100; x += 3) {
      if (String(image.at(x, y)) !== String(image.at(x + half, y))) ++differs;
    }
  }
  assert.ok(differs > 300, `${differs} places differ`);
  await page.locator('#compare').click();
});

test('the cut plane takes away what lies behind it', async () => {
  await page.evaluate(() => flexura.setMode(null).then(() => flexura.view('+z')));
  const [x, y] = await page.evaluate(() => flexura.project([0.8, 0, 0.06]));
  const solid = await page.evaluate((at) => flexura.pixel(...at), [x, y]);
  await page.selectOption('#cut', '0');
  const cut = await page.evaluate((at) => flexura.pixel(...at), [x, y]);
  assert.ok(solid[3] === 255 && cut[3] === 0, `${solid} ${cut}`);
  await page.selectOption('#cut', '-1');
});

test('pictures and films are saved', async () => {
  await page.locator('.modes tbody tr[data-mode="1"]').click();
  await page.waitForFunction(() => flexura.mode === 1);
  const [png] = await Promise.all([page.waitForEvent('download'), page.locator('#png').click()]);
  assert.equal(png.suggestedFilename(), 'tube-mode1.png');
  // The colour scale is in the picture: violet below, yellow above, in the upper right.
  const saved = PNG.sync.read(await readFile(await png.path()));
  const column = (test) => {
    let most = 0;
    for (let x = Math.floor(0.7 * saved.width); x < saved.width; ++x) {
      let n = 0;
      for (let y = 0; y < 230; ++y) {
        const [r, g, b] = saved.data.subarray(4 * (y * saved.width + x));
        if (test(r, g, b)) ++n;
      }
      most = Math.max(most, n);
    }
    return most;
  };
  assert.ok(column((r, g, b) => r > 180 && g > 200 && b < 70) > 10, 'no yellow end of the scale');
  assert.ok(column((r, g, b) => r > 60 && r < 80 && g < 40 && b > 80 && b < 125) > 10, 'no violet end of the scale');
  await page.locator('#film').click();
  await page.locator('#film-format').selectOption('gif');
  await page.locator('#film-seconds').fill('0.2');
  const [film] = await Promise.all([page.waitForEvent('download'), page.locator('#film-save').click()]);
  assert.equal(film.suggestedFilename(), 'tube-mode1.gif');
  assert.deepEqual(page.complaints, []);
});

test('every control has a name, in both themes the text is legible', async () => {
  const nameless = await page.locator('button, input, select').evaluateAll((list) => list.filter((e) =>
    !(e.getAttribute('aria-label') || e.textContent.trim() || e.closest('label'))).map((e) => e.outerHTML));
  assert.deepEqual(nameless, []);
  for (const colorScheme of ['light', 'dark']) {
    await page.emulateMedia({ colorScheme });
    const ratio = [];
    for (const selector of ['.modes td.kind', '.modes td.number', '.slider-name', '.hint']) {
      ratio.push(await page.evaluate(contrast, selector));
    }
    // WCAG 2.1, level AA, for text of this size.
    for (const r of ratio) assert.ok(r >= 4.5, `${colorScheme}: contrast ${r}`);
  }
});

test('on paper the part is a picture on white, with the table below', async () => {
  await page.evaluate(() => dispatchEvent(new Event('beforeprint')));
  await page.emulateMedia({ media: 'print', colorScheme: 'dark' });
  const seen = await page.evaluate(() => {
    const image = document.querySelector('img.print');
    return { ground: getComputedStyle(document.body).backgroundColor, width: image.naturalWidth, shown: image.clientWidth };
  });
  assert.equal(seen.ground, 'rgb(255, 255, 255)');
  assert.ok(seen.width > 300 && seen.shown > 300, JSON.stringify(seen));
  assert.equal(await page.locator('.strip').isVisible(), false);
  assert.ok(await page.locator('.modes tbody tr').last().isVisible());
  await page.emulateMedia({ media: 'screen', colorScheme: 'light' });
});
