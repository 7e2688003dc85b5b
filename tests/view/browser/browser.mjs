// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// What the browser tests share: chromium, a page opened from disk, pixels of a screenshot.
import { chromium } from 'playwright-core';
import { PNG } from 'pngjs';
import { pathToFileURL } from 'node:url';
import { join } from 'node:path';

/** Where view_write_pages has put the pages. */
export const pages = process.env.FLEXURA_PAGES;

export function launch() {
  return chromium.launch({
    executablePath: process.env.FLEXURA_CHROMIUM ?? '/usr/bin/chromium',
    // Software rendering: the same pictures on a machine without a graphics card.
    args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
  });
}

/** Opens a page from disk and waits until it stands; collects what it complains about and what it asks the network. */
export async function open(browser, name, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1000, height: 700 }, reducedMotion: 'reduce', ...options });
  const page = await context.newPage();
  page.complaints = [];
  page.requests = [];
  page.on('console', (m) => { if (['error', 'warning'].includes(m.type())) page.complaints.push(m.text()); });
  page.on('pageerror', (e) => page.complaints.push(e.message));
  page.on('request', (r) => page.requests.push(r.url()));
  await page.goto(pathToFileURL(join(pages, name)).href);
  await page.waitForFunction(() => document.documentElement.dataset.ready, null, { timeout: 120_000 });
  return page;
}

/** The picture that the graphics card draws at this moment: { width, height, at(x, y) -> [r, g, b] }, CSS pixels. */
export async function picture(page) {
  const address = await page.evaluate(() => flexura.snapshot());
  const png = PNG.sync.read(Buffer.from(address.split(',')[1], 'base64'));
  return {
    width: png.width, height: png.height,
    at: (x, y) => [...png.data.subarray(4 * (y * png.width + x), 4 * (y * png.width + x) + 3)],
  };
}

/** Number of pixels that differ by more than the noise of compression (there is none in a PNG). */
export function difference(a, b) {
  let count = 0;
  for (let y = 0; y < a.height; ++y) {
    for (let x = 0; x < a.width; ++x) {
      const p = a.at(x, y);
      const q = b.at(x, y);
      if (p[0] !== q[0] || p[1] !== q[1] || p[2] !== q[2]) ++count;
    }
  }
  return count;
}

/** Middle of the magenta pixels (the dot of flexura.mark), or null. */
export function magenta(image) {
  let n = 0;
  let sx = 0;
  let sy = 0;
  for (let y = 0; y < image.height; ++y) {
    for (let x = 0; x < image.width; ++x) {
      const [r, g, b] = image.at(x, y);
      if (r > 200 && g < 60 && b > 200) {
        ++n;
        sx += x + 0.5;
        sy += y + 0.5;
      }
    }
  }
  return n ? { x: sx / n, y: sy / n, n } : null;
}

/** A point of the world on the picture [CSS pixels], by the camera's matrix (16 numbers by columns). */
export function through(camera, [x, y, z], width, height) {
  const row = (i) => camera[i] * x + camera[4 + i] * y + camera[8 + i] * z + camera[12 + i];
  const w = row(3);
  return { x: (row(0) / w / 2 + 0.5) * width, y: (0.5 - row(1) / w / 2) * height };
}

/** In the page: contrast of an element's text against the nearest opaque background (WCAG 2.1), 1 to 21. */
export function contrast(selector) {
  const channel = (v) => (v / 255 <= 0.04045 ? v / 255 / 12.92 : ((v / 255 + 0.055) / 1.055) ** 2.4);
  const light = ([r, g, b]) => 0.2126 * channel(r) + 0.7152 * channel(g) + 0.0722 * channel(b);
  const numbers = (css) => css.match(/[\d.]+/g).map(Number);
  const element = document.querySelector(selector);
  let back = element;
  while (back.parentElement && (numbers(getComputedStyle(back).backgroundColor)[3] ?? 1) < 1) back = back.parentElement;
  const a = light(numbers(getComputedStyle(element).color));
  const b = light(numbers(getComputedStyle(back).backgroundColor));
  return (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
}
