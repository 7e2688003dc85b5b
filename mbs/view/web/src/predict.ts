// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Fields on the vertices of a surface, as the writer packed them (encode.hpp, PAGE.md): predicted and zigzag.

/** Places in which vertices are met, and from which three each is predicted (the writer's encode.hpp). */
export interface Predictions {
  vertex: Int32Array;
  a: Int32Array;
  b: Int32Array;
  c: Int32Array;
}

export function predict(triangles: Int32Array, parent: Int32Array, n: number): Predictions {
  const p: Predictions = {
    vertex: new Int32Array(n), a: new Int32Array(n), b: new Int32Array(n), c: new Int32Array(n),
  };
  const met = new Uint8Array(n);
  let count = 0;
  let last = -1;
  const meet = (v: number, a: number, b: number, c: number) => {
    if (met[v]) return;
    met[v] = 1;
    p.vertex[count] = v;
    p.a[count] = a;
    p.b[count] = b;
    p.c[count++] = c;
    last = v;
  };
  for (let k = 0; k < parent.length; ++k) {
    for (let corner = 0; corner < 3; ++corner) {
      const w = triangles[3 * k + corner];
      if (met[w]) continue;
      if (parent[k] < 0) {
        meet(w, last, -1, -1);
        continue;
      }
      const x = triangles[3 * k + ((corner + 1) % 3)];
      const y = triangles[3 * k + ((corner + 2) % 3)];
      let c = -1;
      let shared = 0;
      for (let j = 0; j < 3; ++j) {
        const v = triangles[3 * parent[k] + j];
        if (v === x || v === y) ++shared;
        else c = v;
      }
      if (shared === 2 && c >= 0) meet(w, x, y, c);
    }
  }
  for (let v = 0; v < n; ++v) meet(v, last, -1, -1);
  return p;
}


/** Unpacks component c of a field into out[stride * v + channel] for every vertex v. */
export function unpack(rest: Uint16Array, c: number, p: Predictions, out: Int16Array, stride: number, channel: number): void {
  const n = p.vertex.length;
  for (let i = 0; i < n; ++i) {
    const zigzag = rest[c * n + i];
    const difference = zigzag & 1 ? -((zigzag + 1) >> 1) : zigzag >> 1;
    const a = p.a[i];
    let guess = a < 0 ? 0 : out[stride * a + channel];
    if (p.b[i] >= 0) guess += out[stride * p.b[i] + channel] - out[stride * p.c[i] + channel];
    out[stride * p.vertex[i] + channel] = guess + difference; // wraps modulo 2^16, as the writer's did
  }
}
