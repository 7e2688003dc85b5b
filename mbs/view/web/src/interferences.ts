// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Bodies that overlap during a run (flexura simulate --interferences): a ball where they are deepest in one another, while they
// are, and a list that leads there.
import * as THREE from 'three';
import type { Run } from './motion_data';
import { cssColor, figure, h, icon } from './ui';

interface Interference {
  bodies: [string, string];
  depth: number | null;
  time: number;
  point: [number, number, number];
  from: number;
  to: number;
  times: number;
}

function of(run: Run): Interference[] {
  const told = (run.header.summary as { interferences?: unknown } | null)?.interferences;
  return Array.isArray(told) ? told as Interference[] : [];
}

export class Interferences {
  readonly group = new THREE.Group();
  readonly element: HTMLElement | null;
  private readonly balls: { run: number; one: Interference; ball: THREE.Mesh }[] = [];

  constructor(runs: Run[], size: number, go: (run: number, time: number) => void) {
    const material = new THREE.MeshBasicMaterial({ color: new THREE.Color(cssColor('--bad') || '#d22'), transparent: true,
                                                   opacity: 0.75, depthTest: false });
    const rows: HTMLElement[] = [];
    runs.forEach((r, run) => of(r).forEach((one) => {
      const ball = new THREE.Mesh(new THREE.SphereGeometry(0.012 * size, 20, 12), material);
      ball.position.set(...one.point);
      ball.renderOrder = 9;
      ball.visible = false;
      this.group.add(ball);
      this.balls.push({ run, one, ball });
      rows.push(h('button', { class: 'toggle interference', type: 'button', title: 'Show it',
                              onclick: () => go(run, one.time) },
        `${runs.length > 1 ? `${r.header.name}: ` : ''}${one.bodies.join(' and ')}, `
        + `${one.depth === null ? 'depth unknown' : `${figure(1e3 * one.depth, 3)} mm deep`} at ${figure(one.time, 4)} s`));
    }));
    this.element = rows.length
      ? h('section', { class: 'card' }, h('header', {}, h('h2', {}, icon('warning'), 'Bodies that overlap')), ...rows) : null;
  }

  setTime(main: number, t: number): void {
    const slack = 1e-9 * Math.max(1, Math.abs(t));
    for (const { run, one, ball } of this.balls) {
      ball.visible = run === main && (Math.abs(t - one.time) <= slack || (t >= one.from - slack && t <= one.to + slack));
    }
  }
}
