// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// What the motion page offers to scripts and tests as window.flexura: PAGE.md.
import * as THREE from 'three';
import { filmText, type Filmed, type FilmWish } from './film_dialog';
import type { PlacedPeak } from './largest';
import type { Mechanism } from './mechanism';
import { locate, type MotionHeader, type Run } from './motion_data';
import type { PlotDeck } from './plots';
import { forcesAt, type SectionPanel } from './section_panel';
import { spectrum } from './spectrum';
import type { Stage, ViewName } from './stage';

export interface MotionParts {
  header: MotionHeader;
  runs: Run[];
  mechanisms: Mechanism[];
  stage: Stage;
  deck: PlotDeck;
  sections: SectionPanel;
  filmed: Filmed;
  quantities: string[];
  start: number;
  end: number;
  largest: () => { displacement: PlacedPeak | null; stress: PlacedPeak | null };
  state: { time: number; magnify: number; visible: boolean[]; main: number };
  view: (name: ViewName) => void;
  setField: (field: number) => void;
  setReference: (choice: string) => void;
  setMode: (run: number) => void;
  setPlaying: (on: boolean) => void;
  setTime: (t: number) => void;
  showRuns: (main: number) => void;
  refresh: () => void;
}

export function motionScripts(page: MotionParts): object {
  const { runs, mechanisms, stage, deck, sections, state, refresh } = page;
  const runNamed = (name: string) => {
    const i = runs.findIndex((r) => r.header.name === name);
    if (i < 0) throw new Error(`no run is called "${name}"`);
    return i;
  };
  const bodyNamed = (run: string, name: string) => {
    const body = mechanisms[runNamed(run)].body(name);
    if (!body) throw new Error(`no body is called "${name}"`);
    return body;
  };
  return {
    page: 'motion', header: page.header, runs: runs.map((r) => r.header.name), quantities: page.quantities,
    get time() { return state.time; }, start: page.start, end: page.end,
    setTime: (t: number) => { page.setPlaying(false); page.setTime(t); stage.drawNow(); },
    setPlaying: page.setPlaying, setField: page.setField, get largest() { return page.largest(); },
    get largestStress() { return page.largest().stress?.value ?? 0; },
    vonMises: (run: string, body: string, v: number) => {
      const { surface, weights } = bodyNamed(run, body).deformed!;
      return surface.vonMises(v, weights);
    },
    setMagnify: (v: number) => { state.magnify = v; refresh(); }, get magnify() { return state.magnify; },
    showRun: (name: string, on: boolean) => { state.visible[runNamed(name)] = on; page.showRuns(state.main); },
    view: page.view, get largestDeflection() { return page.largest().displacement?.value ?? 0; },
    setReference: page.setReference, setMode: page.setMode, get mode() { return page.state.main; },
    quantity: async (run: string, name: string) => [...((await runs[runNamed(run)].quantity(name)) ?? [])],
    times: (run: string) => [...runs[runNamed(run)].time], frameTimes: (run: string) => [...runs[runNamed(run)].frameTime],
    plots: () => deck.cards.map((c) => c.names),
    addPlot: (wanted: string[]) => deck.add(wanted),
    plotted: async (i: number) => (await deck.cards[i].plotted()).map((c) => ({ ...c, time: [...c.time], values: [...c.values] })),
    spectrum: async (run: string, name: string) => {
      const r = runs[runNamed(run)];
      return spectrum(r.time, (await r.quantity(name)) ?? []);
    },
    csv: () => deck.csv(), film: (wish: FilmWish) => filmText(page.filmed, wish),
    force: (run: string, connection: string) => {
      const i = runNamed(run);
      const { at, part } = locate(runs[i].time, state.time);
      return mechanisms[i].arrows.force(connection, at, part)?.toArray() ?? null;
    },
    pressure: (run: string, connection: string, vertex: number) => {
      const i = runNamed(run);
      const { at, part } = locate(runs[i].time, state.time);
      return mechanisms[i].pressures.pressure(connection, vertex, at, part);
    },
    sectionForces: (run: string, body: string, place: number) => forcesAt(mechanisms[runNamed(run)], body, place),
    addSectionForce: (body: string, place: number, c: number) => sections.addHistory(body, place, c),
    drawSections: (c: number) => { sections.choice.value = String(sections.drawn = c); refresh(); stage.drawNow(); },
    pose: (run: string, body: string) => {
      const { position: p, quaternion: q } = bodyNamed(run, body).group;
      return [p.x, p.y, p.z, q.w, q.x, q.y, q.z];
    },
    place: (run: string, body: string, p: number[]) =>
      new THREE.Vector3().fromArray(p).applyMatrix4(bodyNamed(run, body).group.matrixWorld).toArray(),
    deformed: (run: string, body: string, v: number) => bodyNamed(run, body).deformed!.drawn(v).toArray(),
    mark: (run: string, body: string, v: number) => { bodyNamed(run, body).deformed!.mark(v); stage.drawNow(); },
    project: (p: number[]) => { const { x, y } = stage.project(new THREE.Vector3().fromArray(p)); return [x, y]; },
    camera: () => stage.matrix(),
    pixel: (x: number, y: number) => stage.pixel(x, y), snapshot: () => stage.snapshot(), framesDrawn: () => stage.framesDrawn,
  };
}
