// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Amplitude spectrum of a stored quantity: resampled evenly, mean taken off, Hann window, fast Fourier transform.
// A sine of amplitude a on a line of the spectrum shows as a.
import { locate } from './motion_data';

export function spectrum(time: ArrayLike<number>, values: ArrayLike<number>): { frequency: number[]; amplitude: number[] } {
  const n_t = time.length;
  const span = n_t > 1 ? time[n_t - 1] - time[0] : 0;
  if (!(span > 0)) return { frequency: [], amplitude: [] };
  const n = Math.min(16384, 2 ** Math.ceil(Math.log2(Math.max(8, n_t))));
  const re = new Float64Array(n);
  const im = new Float64Array(n);
  let mean = 0;
  for (let i = 0; i < n; ++i) {
    const { at, part } = locate(time, time[0] + (span * i) / n);
    re[i] = part === 0 ? values[at] : values[at] + part * (values[at + 1] - values[at]);
    mean += re[i] / n;
  }
  for (let i = 0; i < n; ++i) re[i] = (re[i] - mean) * (1 - Math.cos((2 * Math.PI * i) / n));
  transform(re, im);
  const frequency: number[] = [];
  const amplitude: number[] = [];
  for (let k = 0; k < n / 2; ++k) {
    frequency.push(k / span);
    amplitude.push((2 * Math.hypot(re[k], im[k])) / n); // the window's mean is 1
  }
  return { frequency, amplitude };
}

/** In-place radix-2 transform (Cooley and Tukey 1965); the length is a power of two. */
function transform(re: Float64Array, im: Float64Array): void {
  const n = re.length;
  for (let i = 1, j = 0; i < n; ++i) {
    let bit = n >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i < j) {
      [re[i], re[j]] = [re[j], re[i]];
      [im[i], im[j]] = [im[j], im[i]];
    }
  }
  for (let half = 1; half < n; half *= 2) {
    for (let k = 0; k < half; ++k) {
      const c = Math.cos((Math.PI * k) / half);
      const s = -Math.sin((Math.PI * k) / half);
      for (let i = k; i < n; i += 2 * half) {
        const j = i + half;
        const x = c * re[j] - s * im[j];
        const y = s * re[j] + c * im[j];
        re[j] = re[i] - x;
        im[j] = im[i] - y;
        re[i] += x;
        im[i] += y;
      }
    }
  }
}
