// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Rigid bodies and the joints between them, moved by hand: Newton's method on the joints' rows, in the browser.
//
// A joint sits at a frame in each of its bodies, A and B, that coincide where the file has them; d = o_B - o_A. Its rows are, by type,
// of n . d = 0 with n fixed in A, and of x_A . z_B = 0 and the like; of a screw z . d = lead / 2 pi times the angle, turns aside. Bodies that are fixed to one another move as one group; a group moves
// by a small turn w about the middle c of all and a shift L u, with L the size of all, so that rows and unknowns are of one magnitude.
import * as THREE from 'three';

export interface PlacedJoint { type: string; lead: number; a: number; b: number; X_AJ: THREE.Matrix4; X_BJ: THREE.Matrix4 }
export type Coordinate = 'angle' | 'slide' | 'x' | 'y';

/** What a joint leaves free, as far as it can be moved by hand, and which rows it has. */
const kinds: Record<string, { coordinates: Coordinate[]; across: string; turns: string[] }> = {
  fixed: { coordinates: [], across: 'xyz', turns: ['xz', 'yz', 'xy'] },
  revolute: { coordinates: ['angle'], across: 'xyz', turns: ['xz', 'yz'] },
  prismatic: { coordinates: ['slide'], across: 'xy', turns: ['xz', 'yz', 'xy'] },
  screw: { coordinates: ['angle', 'slide'], across: 'xy', turns: ['xz', 'yz'] },
  cylindrical: { coordinates: ['angle', 'slide'], across: 'xy', turns: ['xz', 'yz'] },
  planar: { coordinates: ['angle', 'x', 'y'], across: 'z', turns: ['xz', 'yz'] },
  universal: { coordinates: [], across: 'xyz', turns: ['xy'] },
  spherical: { coordinates: [], across: 'xyz', turns: [] },
};
export const jointTypes = Object.keys(kinds);
export const coordinatesOf = (type: string): Coordinate[] => kinds[type]?.coordinates ?? [];

interface Frame { o: THREE.Vector3; axes: Record<string, THREE.Vector3> }
interface Row { value: number; ga: number; gb: number; turnA: THREE.Vector3; turnB: THREE.Vector3; shift: THREE.Vector3 | null }

/** Solves the symmetric positive definite A x = b in place (Cholesky); A row by row. */
function solve(A: Float64Array, b: Float64Array): void {
  const n = b.length;
  for (let k = 0; k < n; ++k) {
    for (let j = 0; j <= k; ++j) {
      let sum = A[k * n + j];
      for (let i = 0; i < j; ++i) sum -= A[k * n + i] * A[j * n + i];
      A[k * n + j] = j < k ? sum / A[j * n + j] : Math.sqrt(Math.max(sum, 1e-300));
    }
    for (let i = 0; i < k; ++i) b[k] -= A[k * n + i] * b[i];
    b[k] /= A[k * n + k];
  }
  for (let k = n - 1; k >= 0; --k) {
    for (let i = k + 1; i < n; ++i) b[k] -= A[i * n + k] * b[i];
    b[k] /= A[k * n + k];
  }
}

const wrapped = (angle: number) => Math.atan2(Math.sin(angle), Math.cos(angle));

export class JointMotion {
  readonly poses: THREE.Matrix4[];
  private joints: PlacedJoint[] = [];
  private group: number[] = [];
  private column = new Map<number, number>(); // of a group that moves: where its six unknowns start

  /** Poses of the bodies in W where the file has them; the size of all and its middle. */
  constructor(readonly home: THREE.Matrix4[], private readonly size: number, private readonly middle: THREE.Vector3) {
    this.poses = home.map((X) => X.clone());
  }

  setJoints(joints: PlacedJoint[], ground: number): void {
    this.joints = joints;
    this.group = this.home.map((_, i) => i);
    const root = (i: number): number => (this.group[i] === i ? i : root(this.group[i]));
    for (const j of joints) if (j.type === 'fixed') this.group[root(j.b)] = root(j.a);
    this.group = this.home.map((_, i) => root(i));
    this.column.clear();
    for (const g of this.group) {
      if (g !== this.group[ground] && !this.column.has(g)) this.column.set(g, 6 * this.column.size);
    }
    this.reset();
  }

  reset(): void {
    this.home.forEach((X, i) => this.poses[i].copy(X));
  }

  private frame(body: number, X: THREE.Matrix4): Frame {
    const M = new THREE.Matrix4().multiplyMatrices(this.poses[body], X);
    const axes = { x: new THREE.Vector3(), y: new THREE.Vector3(), z: new THREE.Vector3() };
    M.extractBasis(axes.x, axes.y, axes.z);
    return { o: new THREE.Vector3().setFromMatrixPosition(M), axes };
  }

  /** n . d with n fixed in A, over the size. */
  private across(j: PlacedJoint, A: Frame, B: Frame, n: THREE.Vector3): Row {
    const d = B.o.clone().sub(A.o);
    const arm = (o: THREE.Vector3) => o.clone().sub(this.middle).cross(n).divideScalar(this.size);
    return { value: n.dot(d) / this.size, ga: this.group[j.a], gb: this.group[j.b], shift: n, turnB: arm(B.o),
             turnA: arm(A.o).negate().add(n.clone().cross(d).divideScalar(this.size)) };
  }

  /** p_A . q_B. */
  private turned(j: PlacedJoint, A: Frame, B: Frame, p: string, q: string): Row {
    const t = B.axes[q].clone().cross(A.axes[p]);
    return { value: A.axes[p].dot(B.axes[q]), ga: this.group[j.a], gb: this.group[j.b], turnA: t.clone().negate(), turnB: t, shift: null };
  }

  /** h (angle - z . d / h) with h the advance in one radian over the size: whole turns are none. */
  private screwed(j: PlacedJoint, A: Frame, B: Frame): Row {
    const slide = this.across(j, A, B, A.axes.z);
    const advance = (j.lead || 1e-9) / (2 * Math.PI * this.size);
    const z = A.axes.z.clone().multiplyScalar(advance);
    const angle = Math.atan2(A.axes.y.dot(B.axes.x), A.axes.x.dot(B.axes.x));
    return { value: advance * wrapped(angle - slide.value / advance), ga: slide.ga, gb: slide.gb,
             turnA: z.clone().negate().sub(slide.turnA), turnB: z.sub(slide.turnB), shift: slide.shift!.clone().negate() };
  }

  private rowsOf(j: PlacedJoint): Row[] {
    const kind = kinds[j.type];
    if (!kind || j.type === 'fixed' || this.group[j.a] === this.group[j.b]) return [];
    const A = this.frame(j.a, j.X_AJ);
    const B = this.frame(j.b, j.X_BJ);
    return [...[...kind.across].map((axis) => this.across(j, A, B, A.axes[axis])),
            ...kind.turns.map(([p, q]) => this.turned(j, A, B, p, q)), ...(j.type === 'screw' ? [this.screwed(j, A, B)] : [])];
  }

  private dense(row: Row, out: Float64Array, at: number): void {
    for (const [g, turn, sign] of [[row.ga, row.turnA, -1], [row.gb, row.turnB, 1]] as const) {
      const c = this.column.get(g);
      if (c === undefined) continue;
      turn.toArray(out as unknown as number[], at + c);
      if (row.shift) row.shift.clone().multiplyScalar(sign).toArray(out as unknown as number[], at + c + 3);
    }
  }

  /** Degrees of freedom where the bodies stand, and how many rows of each joint follow from those before it. */
  freedom(): { dof: number; redundant: number[] } {
    const n = 6 * this.column.size;
    const basis: Float64Array[] = [];
    const redundant = this.joints.map((j) => {
      let extra = 0;
      for (const r of this.rowsOf(j)) {
        const row = new Float64Array(n);
        this.dense(r, row, 0);
        const length = Math.hypot(...row);
        for (let round = 0; round < 2; ++round) {
          for (const q of basis) {
            let dot = 0;
            for (let i = 0; i < n; ++i) dot += q[i] * row[i];
            for (let i = 0; i < n; ++i) row[i] -= dot * q[i];
          }
        }
        const left = Math.hypot(...row);
        // Placements of STEP files are right to 1e-7 of the size.
        if (left > 1e-5 * length) basis.push(row.map((x) => x / left));
        else ++extra;
      }
      return extra;
    });
    return { dof: n - basis.length, redundant };
  }

  /** [rad] or [m]; an angle is between -pi and pi. */
  coordinate(joint: number, which: Coordinate): number {
    const j = this.joints[joint];
    const A = this.frame(j.a, j.X_AJ);
    const B = this.frame(j.b, j.X_BJ);
    if (which === 'angle') return Math.atan2(A.axes.y.dot(B.axes.x), A.axes.x.dot(B.axes.x));
    return A.axes[which === 'slide' ? 'z' : which].dot(B.o.clone().sub(A.o));
  }

  /** Brings the coordinate there, the other bodies along as the joints let them; false where they do not go as far. */
  drive(joint: number, which: Coordinate, target: number): boolean {
    const most = which === 'angle' ? 0.1 : 0.03 * this.size;
    let step = most;
    for (let n = 0; n < 400; ++n) {
      const now = this.coordinate(joint, which);
      // The slider goes from -180 to 180 degrees: not through that end.
      const way = target - now;
      if (Math.abs(way) < 1e-12 * (which === 'angle' ? 1 : this.size)) return true;
      const aim = Math.abs(way) <= step ? target : now + Math.sign(way) * step;
      const before = this.poses.map((X) => X.clone());
      if (this.assemble(joint, which, aim)) {
        if (aim === target) return true;
        step = Math.min(most, 2 * step);
        continue;
      }
      before.forEach((X, i) => this.poses[i].copy(X));
      step /= 4;
      if (step < 1e-3 * most) return false;
    }
    return false;
  }

  private assemble(joint: number, which: Coordinate, aim: number): boolean {
    const n = 6 * this.column.size;
    if (n === 0) return false;
    for (let iteration = 0; iteration < 20; ++iteration) {
      const rows = this.joints.flatMap((j) => this.rowsOf(j));
      const j = this.joints[joint];
      const A = this.frame(j.a, j.X_AJ);
      if (which === 'angle') {
        const z = A.axes.z;
        rows.push({ value: wrapped(this.coordinate(joint, which) - aim), ga: this.group[j.a], gb: this.group[j.b], turnA: z.clone().negate(),
                    turnB: z, shift: null });
      } else {
        const row = this.across(j, A, this.frame(j.b, j.X_BJ), A.axes[which === 'slide' ? 'z' : which]);
        row.value -= aim / this.size;
        rows.push(row);
      }
      if (rows.every((r) => Math.abs(r.value) < 1e-11)) return true;
      const m = rows.length;
      const J = new Float64Array(m * n);
      rows.forEach((r, i) => this.dense(r, J, i * n));
      // The shortest step: J^T (J J^T + e)^-1 r; rows that follow from others leave J J^T singular, e keeps it definite.
      const JJ = new Float64Array(m * m);
      for (let p = 0; p < m; ++p) {
        for (let q = 0; q <= p; ++q) {
          let sum = p === q ? 1e-9 : 0;
          for (let i = 0; i < n; ++i) sum += J[p * n + i] * J[q * n + i];
          JJ[p * m + q] = JJ[q * m + p] = sum;
        }
      }
      const y = Float64Array.from(rows, (r) => -r.value);
      solve(JJ, y);
      const x = new Float64Array(n);
      for (let p = 0; p < m; ++p) for (let i = 0; i < n; ++i) x[i] += J[p * n + i] * y[p];
      if (!x.every(Number.isFinite) || Math.hypot(...x) > 2) return false;
      this.move(x);
    }
    // Files whose joints do not quite meet converge to what they leave.
    const left = this.joints.flatMap((j) => this.rowsOf(j)).reduce((most, r) => Math.max(most, Math.abs(r.value)), 0);
    const reached = this.coordinate(joint, which) - aim;
    return left < 1e-5 && Math.abs(which === 'angle' ? wrapped(reached) : reached / this.size) < 1e-5;
  }

  private move(x: Float64Array): void {
    const step = new Map<number, THREE.Matrix4>();
    for (const [g, c] of this.column) {
      const w = new THREE.Vector3().fromArray(x as unknown as number[], c);
      const angle = w.length();
      const turn = angle > 0 ? new THREE.Matrix4().makeRotationAxis(w.clone().divideScalar(angle), angle) : new THREE.Matrix4();
      const to = this.middle.clone().add(new THREE.Vector3().fromArray(x as unknown as number[], c + 3).multiplyScalar(this.size));
      step.set(g, new THREE.Matrix4().makeTranslation(to.x, to.y, to.z).multiply(turn)
        .multiply(new THREE.Matrix4().makeTranslation(-this.middle.x, -this.middle.y, -this.middle.z)));
    }
    this.poses.forEach((X, i) => {
      const S = step.get(this.group[i]);
      if (S) X.premultiply(S);
    });
  }
}
