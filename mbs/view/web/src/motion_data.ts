// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// What a motion page holds, and one run's histories, decoded when first asked for.
import { readF4, readF8 } from './data';
import type { SurfaceHeader } from './surface';

export type Point = [number, number, number];
export type Turn = [number, number, number, number]; // w x y z

export type PrimitiveHeader = { color?: string } & (
  | { type: 'cylinder' | 'cone'; radius: number; length: number; position: Point; axis: Point }
  | { type: 'sphere'; radius: number; position: Point }
  | { type: 'box'; size: Point; position: Point; rotation: [number, number, number, number] }
  | { type: 'line'; points: Point[] });

export interface BodyHeader { name: string; kind: string; shapes: PrimitiveHeader[] }

export interface Connection {
  name: string;
  kind: string;
  body_1?: string;
  body_2?: string;
  p_1?: Point;
  p_2?: Point;
  axis_1?: Point;
  /** Frame of the force components among the quantities: rotation w x y z in the body. */
  axes?: { body: string; rotation: Turn };
  /** Of kind marker: of its axes in body 1. */
  rotation?: Turn;
  /** What is touched, in axes on body 1 at p_1; touching: radius of the sphere about p_2 of body 2, 0 for none. */
  surface?: { kind: 'plane' | 'sphere' | 'cylinder' | 'curve' | 'body'; radius: number; closed: boolean; touching: number; rotation: Turn; points?: Point[] };
  /** A line on which the quantity NAME.place counts, by the undeformed body [m]. */
  path?: { body: string; p: Point; place: number }[];
}

/** An interface of a flexible body: its place, and how each modal coordinate displaces and turns it. */
export interface InterfaceFrame { name: string; point: Point; motion: number[][] }

/** A largest value [m or Pa]: the time it is stored at, and the vertex of the surface. */
export interface Peak { value: number; time: number; vertex: number; drawn?: number /* of stress: what the shapes alone make there */ }

export interface RunBody {
  name: string;
  surface: number | null;
  first_shape: number;
  n_shapes: number;
  frames?: InterfaceFrame[];
  held_by?: number | null; // the frame at which a joint to the ground holds it
  /** Over all stored times and vertices; displacement by what it counts from: "own", "interface:NAME", "ground", "body:NAME". */
  largest?: { displacement: Record<string, Peak>; stress?: Peak };
}

export interface RunHeader {
  name: string;
  complete: boolean;
  stopped_because: string;
  rows_stored: number;
  rows: number;
  frames: number;
  quantities: { name: string; unit: string; doc: string }[];
  bodies: RunBody[];
  summary: unknown;
}

export interface MotionHeader {
  format: 1;
  page: 'motion';
  title: string;
  created_by: string;
  gravity?: [number, number, number]; // [m/s^2]
  surfaces: SurfaceHeader[];
  bodies: BodyHeader[];
  connections: Connection[] | null;
  plots: string[][];
  runs: RunHeader[];
}

export interface BodyMotion { pose: Float32Array; modal: Float32Array | null }

export class Run {
  time = new Float64Array(0);
  frameTime = new Float64Array(0);
  motion: BodyMotion[] = [];
  private readonly values = new Map<number, Promise<Float64Array>>();
  private readonly ready = new Map<number, Float64Array>();

  constructor(readonly number: number, readonly header: RunHeader) {}

  async load(): Promise<void> {
    const key = `run${this.number}`;
    this.time = await readF8(`${key}/time`) as Float64Array<ArrayBuffer>;
    this.frameTime = await readF8(`${key}/frame_time`) as Float64Array<ArrayBuffer>;
    this.motion = await Promise.all(this.header.bodies.map(async (body, j) => ({
      pose: await readF4(`${key}/body/${j}/pose`),
      modal: body.n_shapes > 0 ? await readF4(`${key}/body/${j}/modal`) : null,
    })));
  }

  /** A quantity that the page itself has computed, at the stored times. */
  addQuantity(quantity: { name: string; unit: string; doc: string }, values: Float64Array): void {
    if (this.quantityNumber(quantity.name) >= 0) return;
    const j = this.header.quantities.push(quantity) - 1;
    this.values.set(j, Promise.resolve(values));
    this.ready.set(j, values);
  }

  quantityNumber(name: string): number {
    return this.header.quantities.findIndex((q) => q.name === name);
  }

  quantity(name: string): Promise<Float64Array> | null {
    const j = this.quantityNumber(name);
    if (j < 0) return null;
    let values = this.values.get(j);
    if (!values) {
      values = readF8(`run${this.number}/quantity/${j}`);
      this.values.set(j, values);
      void values.then((v) => this.ready.set(j, v));
    }
    return values;
  }

  /** Value at a time, linear between stored rows; null while not decoded. */
  /** The largest size of the loaded quantities in a unit: what is 1e-14 of it is round-off. */
  scaleOf(unit: string): number {
    const same = (u: string) => u === unit || [u, unit].every((x) => x === 'J' || x === 'N*m');
    let scale = 0;
    if (unit) for (const [j, values] of this.ready) if (same(this.header.quantities[j].unit)) for (const v of values) if (Math.abs(v) > scale) scale = Math.abs(v);
    return scale;
  }

  valueAt(name: string, t: number): number | null {
    const v = this.ready.get(this.quantityNumber(name));
    if (!v || !v.length) return null;
    const { at, part } = locate(this.time, t);
    return part === 0 ? v[at] : v[at] + part * (v[at + 1] - v[at]);
  }
}

/** Row and fraction of a time in a growing list; held at the ends. */
export function locate(times: ArrayLike<number>, t: number): { at: number; part: number } {
  const n = times.length;
  if (n < 2 || t <= times[0]) return { at: 0, part: 0 };
  if (t >= times[n - 1]) return { at: n - 1, part: 0 };
  let low = 0;
  let high = n - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle;
    else high = middle;
  }
  // Two rows may share a time, before and after an event.
  const span = times[high] - times[low];
  return { at: low, part: span > 0 ? (t - times[low]) / span : 0 };
}
