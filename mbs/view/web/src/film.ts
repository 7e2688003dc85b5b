// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Films, frame by frame: each one is drawn, then encoded, so that a slow machine takes longer and drops none.
import { applyPalette, GIFEncoder, quantize } from 'gifenc';
import { BufferTarget, CanvasSource, canEncodeVideo, Mp4OutputFormat, Output, QUALITY_HIGH, WebMOutputFormat, type VideoCodec } from 'mediabunny';
import { h } from './ui';

export const filmFormats = ['mp4', 'webm', 'gif'] as const;
export type FilmFormat = (typeof filmFormats)[number];

export interface FilmOptions { format: FilmFormat; width: number; height: number; fps: number; frames: number }

/** Draws frame `i` on the whole canvas. */
export type FramePainter = (g: CanvasRenderingContext2D, i: number) => void;

// H.264 is what presentations and phones play; WebM has codecs of its own.
const codecs: Record<'mp4' | 'webm', VideoCodec[]> = { mp4: ['avc'], webm: ['vp9', 'vp8', 'av1'] };

/** The codec with which this browser writes the format; null where it has none. GIF needs none. */
async function codecOf(format: 'mp4' | 'webm', width: number, height: number): Promise<VideoCodec | null> {
  if (typeof VideoEncoder === 'undefined') return null;
  for (const codec of codecs[format]) if (await canEncodeVideo(codec, { width, height, bitrate: QUALITY_HIGH })) return codec;
  return null;
}

/** The formats that this browser writes. */
export async function writableFormats(width: number, height: number): Promise<FilmFormat[]> {
  const can = await Promise.all(filmFormats.map(async (f) => f === 'gif' || (await codecOf(f, width, height)) !== null));
  return filmFormats.filter((_, i) => can[i]);
}

/** Lets the page draw and listen; timers of a page in the background would take a second. */
function breathe(): Promise<void> {
  return new Promise((resolve) => {
    const { port1, port2 } = new MessageChannel();
    port1.onmessage = () => { port1.close(); resolve(); };
    port2.postMessage(null);
  });
}

/** Delays of a GIF are hundredths of a second: these add up to the film's time. */
export function gifDelay(i: number, fps: number): number {
  return 10 * (Math.round((100 * (i + 1)) / fps) - Math.round((100 * i) / fps));
}

export async function encodeFilm(o: FilmOptions, paint: FramePainter, progress: (part: number) => void, stop?: AbortSignal): Promise<Blob> {
  const canvas = h('canvas', { width: o.width, height: o.height });
  const g = canvas.getContext('2d', { alpha: false, willReadFrequently: o.format === 'gif' })!;
  const step = async (i: number) => {
    progress(i / o.frames);
    await breathe();
    stop?.throwIfAborted();
    paint(g, i);
  };
  if (o.format === 'gif') return encodeGif(o, g, step, progress);
  const codec = await codecOf(o.format, o.width, o.height);
  if (!codec) throw new Error(`this browser writes no ${o.format === 'mp4' ? 'MP4 (H.264)' : 'WebM'}: choose another format, GIF works everywhere`);
  const target = new BufferTarget();
  const output = new Output({ format: o.format === 'mp4' ? new Mp4OutputFormat() : new WebMOutputFormat(), target });
  const source = new CanvasSource(canvas, { codec, bitrate: QUALITY_HIGH });
  output.addVideoTrack(source, { frameRate: o.fps });
  try {
    await output.start();
    for (let i = 0; i < o.frames; ++i) {
      await step(i);
      await source.add(i / o.fps, 1 / o.fps);
    }
    await output.finalize();
  } catch (error) {
    await output.cancel();
    throw error;
  }
  progress(1);
  return new Blob([target.buffer!], { type: `video/${o.format}` });
}

/** One palette for all frames, of some of them: colours do not flicker. */
async function encodeGif(o: FilmOptions, g: CanvasRenderingContext2D, step: (i: number) => Promise<void>, progress: (part: number) => void): Promise<Blob> {
  const sampled = Math.min(o.frames, 8);
  const every = Math.max(1, Math.ceil((o.width * o.height * sampled) / 400_000));
  const pixels: number[] = [];
  for (let k = 0; k < sampled; ++k) {
    await step(Math.floor((k * (o.frames - 1)) / Math.max(1, sampled - 1)));
    const { data } = g.getImageData(0, 0, o.width, o.height);
    for (let i = 4 * (k % every); i < data.length; i += 4 * every) pixels.push(data[i], data[i + 1], data[i + 2], 255);
  }
  const palette = quantize(Uint8ClampedArray.from(pixels), 256);
  const gif = GIFEncoder();
  for (let i = 0; i < o.frames; ++i) {
    await step(i);
    gif.writeFrame(applyPalette(g.getImageData(0, 0, o.width, o.height).data, palette), o.width, o.height,
                   { palette: i === 0 ? palette : undefined, delay: gifDelay(i, o.fps), repeat: 0 });
  }
  gif.finish();
  progress(1);
  return new Blob([gif.bytes()], { type: 'image/gif' });
}
