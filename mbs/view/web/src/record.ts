// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// A short film of the canvas, by the browser's own encoder.

export function record(stream: MediaStream, seconds: number): Promise<Blob> {
  return new Promise((resolve, reject) => {
    const types = ['video/webm;codecs=vp9', 'video/webm', 'video/mp4'];
    const type = types.find((t) => typeof MediaRecorder !== 'undefined' && MediaRecorder.isTypeSupported(t));
    if (!type) {
      reject(new Error('this browser records no films'));
      return;
    }
    const recorder = new MediaRecorder(stream, { mimeType: type, videoBitsPerSecond: 8_000_000 });
    const parts: Blob[] = [];
    recorder.ondataavailable = (e) => parts.push(e.data);
    recorder.onstop = () => resolve(new Blob(parts, { type }));
    recorder.onerror = () => reject(new Error('the recording failed'));
    recorder.start();
    setTimeout(() => recorder.stop(), 1000 * seconds);
  });
}
