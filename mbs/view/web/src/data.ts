// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// The numbers inside the page: blocks (byte planes, deflate, base64) and the header.  See ../../PAGE.md.

export type Numbers = Int32Array | Float32Array | Float64Array | Uint16Array;

const makers: Record<string, { size: number; make: (b: ArrayBuffer) => Numbers }> = {
  i4: { size: 4, make: (b) => new Int32Array(b) },
  f4: { size: 4, make: (b) => new Float32Array(b) },
  f8: { size: 8, make: (b) => new Float64Array(b) },
  u2: { size: 2, make: (b) => new Uint16Array(b) },
};

function fromBase64(text: string): Uint8Array<ArrayBuffer> {
  const quick = Uint8Array as unknown as { fromBase64?: (t: string) => Uint8Array<ArrayBuffer> };
  if (quick.fromBase64) return quick.fromBase64(text);
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; ++i) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

/** The header's JSON. */
export function readHeader<T>(): T {
  return JSON.parse(document.getElementById('header')!.textContent!) as T;
}

/** A block by its name; its text leaves the document, so read each block once and keep it. */
export async function readBlock(name: string): Promise<Numbers> {
  const element = document.querySelector<HTMLScriptElement>(`script[data-block="${CSS.escape(name)}"]`);
  if (!element) throw new Error(`this page holds no block "${name}": it was cut short`);
  const maker = makers[element.dataset.type ?? ''];
  if (!maker) throw new Error(`block "${name}" has the unknown type "${element.dataset.type}"`);
  const packed = fromBase64(element.textContent!);
  element.remove();
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate'));
  const planes = new Uint8Array(await new Response(stream).arrayBuffer());
  const items = planes.length / maker.size;
  const bytes = new Uint8Array(planes.length);
  for (let plane = 0, from = 0; plane < maker.size; ++plane) {
    for (let i = 0, to = plane; i < items; ++i, to += maker.size) bytes[to] = planes[from++];
  }
  return maker.make(bytes.buffer);
}

export const readI4 = (name: string) => readBlock(name) as Promise<Int32Array>;
export const readF4 = (name: string) => readBlock(name) as Promise<Float32Array>;
export const readF8 = (name: string) => readBlock(name) as Promise<Float64Array>;
export const readU2 = (name: string) => readBlock(name) as Promise<Uint16Array>;
