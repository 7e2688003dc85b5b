// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Colour scales, even in lightness and safe for colour-blind eyes: viridis and inferno (Smith, van der Walt) for magnitudes and
// pressures, blue-white-red for signed components.
import * as THREE from 'three';

const stops = {
  magnitude: ['#440154', '#482475', '#414487', '#355f8d', '#2a788e', '#21918c', '#22a884', '#44bf70', '#7ad151',
              '#bddf26', '#fde725'],
  pressure: ['#1b0c41', '#4a0c6b', '#781c6d', '#a52c60', '#cf4446', '#ed6925', '#fb9b06', '#f7d13d', '#fcffa4'],
  signed: ['#1d4f9c', '#3f7fc4', '#82b1dd', '#c3d9ec', '#f2f2f0', '#f6cdb8', '#e8967a', '#cb5346', '#9c1c2e'],
};
export type ScaleName = keyof typeof stops;

function rgb(hex: string): [number, number, number] {
  const n = parseInt(hex.slice(1), 16);
  return [n >> 16, (n >> 8) & 255, n & 255];
}

export function scaleTexture(name: ScaleName): THREE.DataTexture {
  const n = 256;
  const data = new Uint8Array(4 * n);
  const s = stops[name].map(rgb);
  for (let i = 0; i < n; ++i) {
    const x = (i / (n - 1)) * (s.length - 1);
    const k = Math.min(Math.floor(x), s.length - 2);
    for (let c = 0; c < 3; ++c) data[4 * i + c] = Math.round(s[k][c] + (x - k) * (s[k + 1][c] - s[k][c]));
    data[4 * i + 3] = 255;
  }
  const texture = new THREE.DataTexture(data, n, 1);
  texture.minFilter = texture.magFilter = THREE.LinearFilter;
  texture.needsUpdate = true;
  return texture;
}

/** Red, green and blue of a part of the scale, as they go to the screen. */
export function scaleColor(name: ScaleName, part: number): [number, number, number] {
  const s = stops[name];
  const x = Math.max(0, Math.min(1, part)) * (s.length - 1);
  const k = Math.min(Math.floor(x), s.length - 2);
  const [a, b] = [rgb(s[k]), rgb(s[k + 1])];
  const mix = (c: number) => (a[c] + (x - k) * (b[c] - a[c])) / 255;
  return [mix(0), mix(1), mix(2)];
}

export function scaleStops(name: ScaleName): string[] {
  return stops[name];
}
