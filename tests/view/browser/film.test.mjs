// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Films, of a page and from the command line: every frame there, opaque, as long as asked for, with title and colour scale.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { launch, open } from './browser.mjs';

const size = { width: 320, height: 180 };
const frames = 12;
let browser;
let page;
const folder = mkdtempSync(join(tmpdir(), 'flexura-film-test-'));
before(async () => {
  browser = await launch();
  page = await open(browser, 'motion.html');
});
after(async () => {
  await browser.close();
  rmSync(folder, { recursive: true });
});

const make = async (format, options = {}) =>
  Buffer.from(await page.evaluate((o) => flexura.film(o), { format, ...size, fps: 12, seconds: 1, ...options }), 'base64');

/** Every picture of a film as the browser decodes it: RGBA of its pixels. */
const decode = (bytes, type) => page.evaluate(async ([text, t]) => {
  const data = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const decoder = new ImageDecoder({ data, type: t });
  await decoder.tracks.ready;
  const out = [];
  for (let i = 0; i < decoder.tracks.selectedTrack.frameCount; ++i) {
    const { image } = await decoder.decode({ frameIndex: i });
    const canvas = new OffscreenCanvas(image.displayWidth, image.displayHeight);
    const g = canvas.getContext('2d');
    g.drawImage(image, 0, 0);
    out.push({ width: canvas.width, height: canvas.height, duration: image.duration, pixels: [...g.getImageData(0, 0, canvas.width, canvas.height).data] });
  }
  return out;
}, [bytes.toString('base64'), type]);

/** Length, size and the alpha of a corner of a video, as a player shows it. */
const play = (bytes, type) => page.evaluate(async ([text, t]) => {
  const video = document.createElement('video');
  video.muted = true;
  video.src = URL.createObjectURL(new Blob([Uint8Array.from(atob(text), (c) => c.charCodeAt(0))], { type: t }));
  await new Promise((done, failed) => { video.onloadeddata = done; video.onerror = () => failed(new Error(video.error.message)); });
  video.currentTime = 0.01;
  await new Promise((done) => { video.onseeked = done; });
  const canvas = new OffscreenCanvas(video.videoWidth, video.videoHeight);
  const g = canvas.getContext('2d');
  // The decoder may hand its picture over a little after the event.
  let corner;
  for (let i = 0; i < 100 && corner?.[3] !== 255; ++i) {
    g.drawImage(video, 0, 0);
    corner = [...g.getImageData(2, canvas.height - 3, 1, 1).data];
    await new Promise((done) => { setTimeout(done, 50); });
  }
  return { duration: video.duration, width: video.videoWidth, height: video.videoHeight, corner };
}, [bytes.toString('base64'), type]);

/** Samples of the only track of an MP4 (ISO/IEC 14496-12, 8.7.3: the count of box stsz). */
const samples = (mp4) => mp4.readUInt32BE(mp4.indexOf('stsz') + 12);

function assertPicture({ width, height, pixels }, title) {
  assert.deepEqual({ width, height }, size);
  const dark = (x0, x1, y0, y1) => {
    let n = 0;
    for (let y = y0; y < y1; ++y) for (let x = x0; x < x1; ++x) n += pixels[4 * (y * width + x)] < 110 && pixels[4 * (y * width + x) + 2] < 110;
    return n;
  };
  for (let i = 3; i < pixels.length; i += 4) assert.equal(pixels[i], 255);
  assert.ok(dark(10, 160, 10, 26) > 40, `${title}: no title`);
  assert.ok(dark(10, 160, 28, 44) > 20, `${title}: no time`);
  let yellow = 0; // the upper end of the colour scale
  for (let y = 0; y < height; ++y) for (let x = width / 2; x < width; ++x) yellow += pixels[4 * (y * width + x)] > 180 && pixels[4 * (y * width + x) + 2] < 90;
  assert.ok(yellow > 20, `${title}: no colour scale`);
}

test('a GIF has every frame, opaque, with title, time and scale', async () => {
  const shown = await decode(await make('gif'), 'image/gif');
  assert.equal(shown.length, frames);
  shown.forEach((picture, i) => assertPicture(picture, `frame ${i}`));
  // 1 s of hundredths [us].
  assert.equal(shown.reduce((sum, { duration }) => sum + duration, 0), 1e6);
  // The crank turns twice in the film: frames differ.
  assert.notDeepEqual(shown[0].pixels, shown[2].pixels);
});

test('an MP4 has every frame, and a player shows it opaque', async () => {
  const bytes = await make('mp4');
  assert.equal(samples(bytes), frames);
  const { duration, width, height, corner } = await play(bytes, 'video/mp4');
  assert.deepEqual({ width, height }, size);
  assert.ok(Math.abs(duration - 1) < 1e-3, `${duration}`);
  // The ground of the light theme, not black.
  assert.ok(corner[3] === 255 && corner[0] > 200, `${corner}`);
});

test('a WebM is opaque', async () => {
  const bytes = await make('webm');
  const { corner, duration } = await play(bytes, 'video/webm');
  assert.ok(corner[3] === 255 && corner[0] > 200, `${corner}`);
  assert.ok(Math.abs(duration - 1) < 0.1, `${duration}`);
  assert.equal(bytes.indexOf(Buffer.from([0x53, 0xc0, 0x81, 0x01])), -1); // AlphaMode 1
});

test('what no film can be is refused, and the picture is as before', async () => {
  const before = await page.evaluate(() => [flexura.time, flexura.snapshot().length]);
  for (const [wrong, rule] of [[{ fps: 0 }, 'frames per second'], [{ seconds: 1e6 }, '6000 frames'], [{ width: 10 }, '64 to 4096 pixels']]) {
    await assert.rejects(make('gif', wrong), (error) => error.message.includes(rule));
  }
  assert.deepEqual(await page.evaluate(() => [flexura.time, flexura.snapshot().length]), before);
});

test('the command line makes the film without a window', async () => {
  writeFileSync(join(folder, 'm.toml'), `gravity = [0, -9.81, 0]
[body.bob]
mass = 1.0
inertia = [0.01, 0.01, 0.01]
position = [1, 0, 0]
[joint.pin]
type = "revolute"
from = "ground"
to = "bob"
[solver]
end_time = 1
`);
  const flexura = (...words) => execFileSync(join(process.env.FLEXURA_BIN, 'flexura'), words,
    { cwd: folder, env: { ...process.env, FLEXURA_BROWSER: process.env.FLEXURA_CHROMIUM ?? '/usr/bin/chromium' }, stdio: ['ignore', 'pipe', 'pipe'] }).toString();
  flexura('simulate', 'm.toml', '-o', 'm.h5');
  const words = ['--film-size', '320x180', '--film-fps', '12', '--film-seconds', '1'];
  assert.match(flexura('view', 'm.h5', '--film', 'm.mp4', ...words, '--film-view', '-y'), /^wrote m\.mp4/);
  assert.equal(samples(readFileSync(join(folder, 'm.mp4'))), frames);
  flexura('view', 'm.h5', '--film', 'm.gif', ...words);
  assert.equal((await decode(readFileSync(join(folder, 'm.gif')), 'image/gif')).length, frames);
});
