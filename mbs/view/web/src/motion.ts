// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// The motion page: the mechanism moving, its runs over one another, plots of what was stored.
import * as THREE from 'three';
import { scaleTexture } from './colormap';
import { FilmDialog, type Filmed } from './film_dialog';
import { Interferences } from './interferences';
import { LargestValues, most, type PlacedPeak } from './largest';
import { Legend } from './legend';
import { modeList, modeOf } from './mode_runs';
import { Mechanism } from './mechanism';
import { Run, type MotionHeader } from './motion_data';
import { PressureView } from './pressure_view';
import { PlotDeck } from './plots';
import { QuantityTable } from './quantity_table';
import { motionScripts } from './motion_scripts';
import { SectionPanel } from './section_panel';
import { Stage, upIn, viewNames, type ViewName } from './stage';
import { summaryPanel, warningsOf } from './summary';
import { Surface } from './surface';
import { cssColor, download, factList, figure, h, icon, iconButton, forceText, lengthUnit, say, shortcuts, slider,
         stressUnit, themeButton,
         toggle, topBar } from './ui';

export type { MotionHeader } from './motion_data';

/** 1, 2 or 5 times a power of ten, at or below x. */
function round125(x: number): number {
  const power = 10 ** Math.floor(Math.log10(x));
  const m = x / power;
  return power * (m >= 5 ? 5 : m >= 2 ? 2 : 1);
}

function firstPlots(header: MotionHeader): string[][] {
  if (header.plots.length) return header.plots;
  const names = header.runs.flatMap((r) => r.quantities.map((q) => q.name));
  const known = [...new Set(names)];
  const energies = known.filter((n) => /^energy\.(kinetic|strain|potential|total)$/.test(n));
  // What the model's author gave a name of its own (no dot) says most; then how fast it runs.
  const named = known.filter((n) => !n.includes('.')).slice(0, 2);
  const speed = known.filter((n) => /speed$/.test(n)).slice(0, 1);
  const strain = known.filter((n) => /\.strain_energy$/.test(n));
  let first = [...speed.map((n) => [n]), ...named.map((n) => [n]), ...(strain.length ? [strain] : [])];
  if (!first.length) first = known.filter((n) => !/^(energy|power)\./.test(n)).slice(0, 3).map((n) => [n]);
  return [...first, ...(energies.length ? [energies] : []),
          ...known.filter((n) => n === 'energy.balance').map((n) => [n])];
}

export async function motionPage(app: HTMLElement, header: MotionHeader): Promise<void> {
  const surfaces = await Promise.all(header.surfaces.map((s) => Surface.read(s)));
  const runs = header.runs.map((r, i) => new Run(i, r));
  await Promise.all(runs.map((r) => r.load()));
  const t0 = Math.min(...runs.filter((r) => r.time.length).map((r) => r.time[0]));
  const t1 = Math.max(...runs.filter((r) => r.time.length).map((r) => r.time[r.time.length - 1]));
  const duration = Math.max(t1 - t0, 1e-12);
  const isStill = t1 <= t0; // a mechanism that does not assemble, say
  const isModes = header.runs.every((r) => modeOf(r) !== null);
  const state = {
    time: t0, playing: !matchMedia('(prefers-reduced-motion: reduce)').matches && t1 > t0,
    speed: round125(duration / 6), magnify: 1, field: 1, follow: '',
    main: isModes ? 0 : runs.length - 1, visible: runs.map((_, i) => !isModes || i === 0),
  };
  // Of several runs the one with the most to show is drawn solid.
  if (!isModes) runs.forEach((r, i) => {
    const flexible = (k: Run) => k.header.bodies.reduce((s, b) => s + b.n_shapes, 0);
    if (flexible(r) > flexible(runs[state.main])) state.main = i;
  });

  const stage = new Stage(`Motion of ${header.title}`, upIn(header.gravity));
  stage.covered = () => legend.covered;
  const scale = scaleTexture('magnitude');
  // Glyphs are sized by the bodies at the start.
  const sizes = new THREE.Box3();
  const probe = new Mechanism(runs[state.main], header, surfaces, scale, 1e-9);
  probe.box(t0, sizes);
  const size = sizes.isEmpty() ? 1 : sizes.getSize(new THREE.Vector3()).length() || 1;
  const mechanisms = runs.map((r) => new Mechanism(r, header, surfaces, scale, 0.014 * size));
  await Promise.all(mechanisms.map((m) => m.loadShapes()));
  for (const m of mechanisms) stage.scene.add(m.group);
  const overlaps = new Interferences(runs, size, (run, t) => { state.main = run; state.visible[run] = true; setPlaying(false); state.time = t; refresh(); });
  stage.scene.add(overlaps.group);

  const extent = new THREE.Box3();
  for (let i = 0; i <= 40; ++i) for (const m of mechanisms) m.box(t0 + (duration * i) / 40, extent);
  const start = mechanisms[state.main].box(t0);
  mechanisms[state.main].boxOfContacts(extent);
  const travels = extent.getSize(new THREE.Vector3()).length() > 6 * start.getSize(new THREE.Vector3()).length();
  const shown = travels ? start : extent;
  // One scale for all runs; modes have a size of their own each, and a scale of their own.
  const largestOf = (value: (m: Mechanism) => number) => Math.max(0, ...mechanisms.filter((_, i) => !isModes || i === state.main).map(value));
  const deflection = () => largestOf((m) => m.largestDeflection);
  const stressMost = () => largestOf((m) => m.largestStress);
  const deforms = mechanisms.some((m) => m.largestDeflection > 0);
  const isStressed = mechanisms.some((m) => m.largestStress > 0);
  const flexibleSize = Math.max(0, ...mechanisms[state.main].bodies.filter((b) => b.deformed)
    .map((b) => b.deformed!.surface.size));
  // Modes are drawn as large as they are stored.
  // A thousand times at most by itself: what is smaller still does not deform for the eye, and is said in numbers.
  const fullMagnify = deforms && !isModes ? Math.min(1000, Math.max(1, round125((0.06 * flexibleSize) / deflection()))) : 1;
  state.magnify = fullMagnify;
  if (!deforms) state.field = 0;

  // --- drawing -----------------------------------------------------------------------------------------------------
  const clock = h('output', { class: 'clock', 'aria-label': 'Time' });
  const digits = Math.max(0, Math.min(6, 3 - Math.floor(Math.log10(duration))));
  let followed: THREE.Vector3 | null = null;
  function setTime(t: number): void {
    state.time = Math.min(t1, Math.max(t0, t));
    mechanisms.forEach((m, i) => { if (state.visible[i]) m.setTime(state.time); });
    // A mode's run is one period of it.
    clock.textContent = isModes ? `${((360 * (state.time - t0)) / duration).toFixed(0)}°` : `${state.time.toFixed(digits)} s`;
    timeline.input.value = String(state.time);
    timeline.input.setAttribute('aria-valuetext', clock.textContent);
    timeline.input.style.setProperty('--part', `${(100 * (state.time - t0)) / duration}%`);
    const body = state.follow ? mechanisms[state.main].body(state.follow) : undefined;
    if (body) {
      const at = body.box.isEmpty() ? body.group.position.clone()
        : body.box.getCenter(new THREE.Vector3()).applyMatrix4(body.group.matrixWorld);
      if (followed) stage.follow(at.clone().sub(followed));
      followed = at;
    } else followed = null;
    deck.setTime(state.time);
    overlaps.setTime(state.main, state.time);
    sections.refresh(mechanisms[state.main]);
    quantities.refresh(state.time);
    stage.draw();
  }
  stage.onFrame = (dt) => {
    if (!state.playing) return false;
    const next = state.time + dt * state.speed;
    setTime(next >= t1 ? (state.time < t1 ? t1 : t0) : next);
    return true;
  };
  const legend = new Legend();
  const pressures = new PressureView(mechanisms, () => refresh());
  function refresh(): void {
    const isStress = state.field === 5;
    const top = isStress ? stressMost() : deflection();
    mechanisms.forEach((m, i) => {
      m.group.visible = state.visible[i];
      m.magnify = state.magnify;
      const ghost = i !== state.main;
      m.setLook(ghost ? new THREE.Color(cssColor(`--run${i % 6}`)) : null);
      for (const b of m.bodies) {
        const moves = b.number >= 0 && m.run.header.bodies[b.number].n_shapes > 0;
        b.deformed?.setField(ghost || !moves || top === 0 ? 0 : state.field, 0, top);
      }
    });
    const { factor, unit } = isStress ? stressUnit(top) : lengthUnit(top);
    // A ghost has the colour of its run.
    legend.show(state.field === 0 || top === 0 || !state.visible[state.main] ? null : {
      title: `${isStress ? 'von Mises' : `|u| ${fromWhere()}`} [${unit}]`, scale: 'magnitude', low: 0, high: top * factor,
      note: isModes ? `mode shape, its size is free; drawn ×${figure(state.magnify, 3)}` : `drawn ×${figure(state.magnify, 3)}`,
    });
    setTime(state.time);
  }

  // --- controls ----------------------------------------------------------------------------------------------------
  const play = iconButton('pause', 'Stop (space)', () => setPlaying(!state.playing), { id: 'play' });
  function setPlaying(on: boolean): void {
    state.playing = on;
    if (on) largest.clear();
    play.replaceChildren(icon(on ? 'pause' : 'play'));
    play.title = on ? 'Stop (space)' : 'Play (space)';
    play.setAttribute('aria-label', on ? 'Stop' : 'Play');
    stage.draw();
  }
  const timeline = { input: h('input', { type: 'range', id: 'time', min: t0, max: t1, step: 'any', 'aria-label': 'Time',
                                         oninput: () => { setPlaying(false); setTime(Number(timeline.input.value)); } }) };
  const speed = slider('Speed', {
    min: -4, max: 2, step: 0.05, value: Math.log10(state.speed), id: 'speed',
    text: (v) => `×${figure(10 ** v, 2)}`, change: (v) => { state.speed = 10 ** v; } });
  const magnify = slider('Deformation', {
    min: 0, max: Math.max(1, Math.log10(fullMagnify) + 1), step: 0.02, value: Math.log10(state.magnify), id: 'magnify',
    text: (v) => `×${figure(10 ** v, 2)}`, change: (v) => { state.magnify = 10 ** v; refresh(); } });
  magnify.element.hidden = !deforms;
  const color = h('select', { id: 'color', 'aria-label': 'Colour', title: 'Next colouring (C)',
                              onchange: () => setField(Number(color.value)) },
                  ...[['Displacement', 1], ...(isStressed ? [['Von Mises stress', 5]] : []), ['Bodies', 0]]
                    .map(([text, value]) => h('option', { value }, String(text))));
  const setField = (field: number) => {
    state.field = field;
    color.value = String(field);
    refresh();
  };
  color.hidden = !deforms;
  // Where displacements are taken from.
  const flexible = runs.flatMap((r) => r.header.bodies.filter((b) => b.n_shapes > 0));
  const isHeld = flexible.some((b) => typeof b.held_by === 'number');
  const interfaces = [...new Set(flexible.flatMap((b) => (b.frames ?? []).map((f) => f.name)))];
  const references: [string, string][] = [
    ['held', isHeld ? 'from where it is held' : 'from the floating frame'],
    ...(isHeld ? [['own', 'from the floating frame'] as [string, string]] : []),
    ...interfaces.map((name) => [`interface:${name}`, `from interface ${name}`] as [string, string]),
    ['ground', 'since the start, from ground'],
    ...header.bodies.filter((b) => b.kind !== 'ground').map((b) => [`body:${b.name}`, `since the start, from ${b.name}`] as [string, string])];
  const reference = h('select', { id: 'reference', 'aria-label': 'Displacement counts', title: 'Where displacement is taken from',
                                  onchange: () => setReference(reference.value) },
                      ...references.map(([value, text]) => h('option', { value }, text)));
  const fromWhere = () => references.find(([value]) => value === reference.value)![1];
  const setReference = (choice: string) => {
    // Where nothing holds a body the floating frame is the first of the list already.
    const known = references.some(([value]) => value === choice) ? choice : 'held';
    reference.value = known;
    for (const m of mechanisms) m.setReference(known);
    largest.clear();
    largest.refresh();
    showFacts();
    refresh();
  };
  reference.hidden = !deforms;
  const glyphs = toggle('Joints', true, (on) => {
    for (const m of mechanisms) m.showJoints = on;
    stage.draw();
  }, { title: 'Joints and springs (J)' });
  const contacts = toggle('Contacts', true, (on) => {
    for (const m of mechanisms) m.showContacts = on;
    stage.draw();
  }, { title: 'Surfaces that are touched, spheres that touch them, paths (X)' });
  contacts.hidden = !mechanisms.some((m) => m.contacts.length);
  const markers = toggle('Markers', false, (on) => {
    for (const m of mechanisms) m.showMarkers = on;
    stage.draw();
  }, { title: 'Markers as triads: x red, y green, z blue (K)' });
  markers.hidden = !mechanisms.some((m) => m.markers.length);
  const forceMost = Math.max(0, ...mechanisms.map((m) => m.arrows.largest));
  const forces = toggle(`Forces ≤ ${forceText(forceMost)}`, true, (on) => {
    for (const m of mechanisms) m.arrows.group.visible = on;
    stage.draw();
  }, { title: `Forces as arrows, the longest ${forceText(forceMost)} (F)` });
  forces.hidden = forceMost === 0;
  const plotSection = (name: string) => { void deck.add([name]); tab('plots'); };
  const sections = new SectionPanel(mechanisms, size, plotSection, () => { refresh(); });
  sections.choice.hidden = !sections.present;
  const moving = header.bodies.filter((b) => b.kind !== 'ground').map((b) => b.name);
  const follow = h('select', { id: 'follow', 'aria-label': 'Camera follows', onchange: () => {
    state.follow = follow.value;
    followed = null;
    setTime(state.time);
  } }, h('option', { value: '' }, 'Fixed camera'), ...moving.map((name) => h('option', { value: name }, `Follow ${name}`)));
  /** `main`: the run to be drawn solid, where it is seen; else the next one that is. */
  function showRuns(main: number): void {
    const seen = runs.map((_, k) => (main + k) % runs.length).find((k) => state.visible[k]);
    if (seen !== undefined) state.main = seen;
    runButtons.forEach((button, i) => button.setAttribute('aria-pressed', String(state.visible[i])));
    refresh();
    deck.redraw();
  }
  const runButtons = runs.map((r, i) => h('button', {
    class: 'toggle run', type: 'button', 'aria-pressed': 'true', style: `--color: var(--run${i % 6})`,
    title: 'Show or hide this run; double click draws it solid, R the next one',
    onclick: () => { state.visible[i] = !state.visible[i]; showRuns(state.main); },
    ondblclick: () => { state.visible[i] = true; showRuns(i); } }, h('i', {}), r.header.name));
  const modes = isModes ? modeList(header.runs, (i) => setMode(i)) : null;
  const setMode = (i: number) => {
    state.main = i;
    state.visible = runs.map((_, k) => k === i);
    modes!.mark(i);
    refresh();
  };
  const views = h('div', { class: 'group views', role: 'group', 'aria-label': 'Views' },
    ...viewNames.map((name) => h('button', { class: 'toggle', type: 'button', 'data-view': name,
                                             onclick: () => view(name) }, name)));
  const view = (name: ViewName) => {
    stage.view(name, state.follow ? mechanisms[state.main].box(state.time) : shown);
    followed = null;
    setTime(state.time);
  };
  const fileName = header.title.replace(/[^\w.-]+/g, '_');
  const savePng = async () => download(`${fileName}.png`, await stage.png(`${header.title}, ${instant()}`, [legend, pressures.legend]));
  const instant = () => isModes ? `${runs[state.main].header.name}, ${clock.textContent}` : `t = ${clock.textContent}`;
  const filmed: Filmed = {
    stage, legends: [legend, pressures.legend], title: () => header.title, name: () => fileName,
    seconds: () => (isModes ? 2 : 1) * Math.min(60, duration / state.speed), isPeriodic: isModes, look: (name) => view(name),
    show: (part) => {
      setTime(t0 + duration * (isModes ? (2 * part) % 1 : part));
      return instant() + (runs.length > 1 && !isModes ? `   ${runs.filter((_, i) => state.visible[i]).map((r) => r.header.name).join(', ')}` : '');
    },
    hold: () => {
      const { playing, time } = state;
      setPlaying(false);
      return () => { setTime(time); setPlaying(playing); };
    },
  };
  const film = new FilmDialog(filmed);

  // --- plots, quantities, summary ------------------------------------------------------------------------------------
  const deck = new PlotDeck(runs, (r) => state.visible[r.number], (t) => { setPlaying(false); setTime(t); });
  const all = [...new Map(header.runs.flatMap((r) => r.quantities).map((q) => [q.name, q])).values()];
  const names = h('datalist', { id: 'quantities' }, ...all.map((q) => h('option', { value: q.name }, q.unit)));
  const add = h('input', { type: 'search', id: 'add-plot', list: 'quantities', placeholder: 'Add a plot: a, b',
                           'aria-label': 'Add a plot of quantities, separated by commas', onchange: () => {
    const wanted = add.value.split(',').map((s) => s.trim()).filter((s) => s);
    const unknown = wanted.find((w) => !all.some((q) => q.name === w));
    if (unknown) say(`No quantity is called "${unknown}"`);
    else if (wanted.length) {
      void deck.add(wanted).then(() => deck.element.lastElementChild?.scrollIntoView({ behavior: 'smooth' }));
      add.value = '';
    }
  } });
  const saveCsv = iconButton('table', 'Save the plotted curves as CSV', () =>
    void deck.csv().then((text) => download(`${fileName}.csv`, text, 'text/csv')), { id: 'csv' });

  const quantities = new QuantityTable(runs, all, (name) => { void deck.add([name]); tab('plots'); });
  const largest = new LargestValues(isModes ? [] : mechanisms, fromWhere, (peak, field) => {
    setPlaying(false);
    state.visible[peak.run] = true;
    state.time = peak.time;
    setField(field);
    showRuns(peak.run);
  });
  const pages: Record<string, HTMLElement> = {
    ...(modes ? { modes: h('div', { class: 'tab-page', role: 'tabpanel', 'aria-label': 'Modes' }, modes.element) } : {}),
    plots: h('div', { class: 'tab-page', role: 'tabpanel', 'aria-label': 'Plots' }, deck.element),
    quantities: h('div', { class: 'tab-page', role: 'tabpanel', 'aria-label': 'Quantities', hidden: true },
      ...quantities.elements),
    sections: h('div', { class: 'tab-page', role: 'tabpanel', 'aria-label': 'Section forces', hidden: true }, sections.element),
    summary: h('div', { class: 'tab-page', role: 'tabpanel', 'aria-label': 'Summary', hidden: true }, largest.element, overlaps.element, summaryPanel(runs)),
  };
  const tabs: Record<string, HTMLButtonElement> = {};
  for (const [name, title] of [...(modes ? [['modes', 'Modes']] : []), ['plots', 'Plots'], ['quantities', 'Quantities'], ['sections', 'Sections'], ['summary', 'Summary']]) {
    tabs[name] = h('button', { role: 'tab', type: 'button', id: `tab-${name}`, 'aria-selected': String(name === 'plots'),
                               onclick: () => tab(name) }, title);
  }
  tabs.sections.hidden = !sections.present;
  tabs.plots.hidden = isModes || isStill;
  function tab(name: string): void {
    for (const [key, page] of Object.entries(pages)) {
      page.hidden = key !== name;
      tabs[key].setAttribute('aria-selected', String(key === name));
    }
    sections.shown = name === 'sections';
    if (name === 'sections') sections.refresh(mechanisms[state.main]);
    quantities.show(name === 'quantities', state.time);
  }
  const warnings = runs.flatMap(warningsOf);
  // The worst of the runs, of the energy that went through the mechanism.
  const energyError = Math.max(0, ...runs.map((r) => {
    const told = (r.header.summary as { relative_energy_error?: unknown } | null)?.relative_energy_error;
    return typeof told === 'number' && Number.isFinite(told) ? Math.abs(told) : 0;
  }));

  const strip = h('div', { class: 'strip' },
    h('div', { class: 'group wide', hidden: isStill }, play, timeline.input, clock),
    h('div', { class: 'group' }, ...(isStill ? [] : [speed.element]), magnify.element),
    h('div', { class: 'group' }, color, reference, glyphs, contacts, markers, forces, pressures.button, sections.choice, follow));
  const corner = h('div', { class: 'corner' }, views,
    iconButton('camera', 'Save a picture (P)', () => void savePng(), { id: 'png' }),
    iconButton('film', 'Save a film (M)', () => void film.open(), { id: 'film' }));
  const step = (n: number) => { setPlaying(false); setTime(state.time + (n * duration) / 200); };
  const keys = shortcuts([
    { keys: [' '], text: 'play or stop', run: () => setPlaying(!state.playing) },
    { keys: ['ArrowRight'], text: 'later', run: (e) => step(e.shiftKey ? 10 : 1) },
    { keys: ['ArrowLeft'], text: 'earlier', run: (e) => step(e.shiftKey ? -10 : -1) },
    { keys: ['Home'], text: 'to the start', run: () => setTime(t0) },
    { keys: ['End'], text: 'to the end', run: () => setTime(t1) },
    { keys: ['['], text: 'slower', run: () => speed.set(speed.get() - 0.1) },
    { keys: [']'], text: 'faster', run: () => speed.set(speed.get() + 0.1) },
    { keys: ['+', '='], text: 'more deformation', run: () => magnify.set(magnify.get() + 0.1) },
    { keys: ['-'], text: 'less deformation', run: () => magnify.set(magnify.get() - 0.1) },
    ...[0, 1, 2, 3, 4, 5].map((i) => ({ keys: [String(i + 1)], text: `view ${viewNames[i]}`, run: () => view(viewNames[i]) })),
    { keys: ['0', 'i'], text: 'view from a corner', run: () => view('iso') },
    { keys: ['c'], text: 'next colouring', run: () => setField(state.field === 1 && isStressed ? 5 : state.field === 0 ? 1 : 0) },
    { keys: ['j'], text: 'joints and springs', run: () => glyphs.click() },
    { keys: ['x'], text: 'surfaces that are touched, and paths', run: () => contacts.click() },
    { keys: ['k'], text: 'markers', run: () => markers.click() },
    { keys: ['f'], text: 'forces', run: () => forces.click() },
    ...(runs.length > 1 && !isModes ? [{ keys: ['r'], text: 'next run solid', run: () => showRuns(state.main + 1) }] : []),
    ...pressures.keys,
    ...(sections.present ? [{ keys: ['s'], text: 'next diagram of section forces', run: () => {
      sections.choice.value = String(sections.drawn = sections.drawn < 5 ? sections.drawn + 1 : -1);
      refresh();
    } }] : []),
    { keys: ['p'], text: 'save a picture', run: () => void savePng() },
    { keys: ['m'], text: 'save a film', run: () => void film.open() },
    { keys: ['t'], text: 'light or dark', run: () => theme.click() },
    { keys: ['?'], text: 'this list', run: () => keys.click() },
  ]);
  const theme = themeButton(() => { refresh(); deck.redraw(); });

  const facts = factList([]);
  const showFacts = () => facts.replaceChildren(
    ...factList([['Bodies', String(moving.length)], [isModes ? 'Modes' : 'Runs', String(runs.length)],
                 ...(isModes || isStill ? [] : [['Time', `${figure(duration, 4)} s`] as [string, string]])]).children,
    ...(isModes ? [] : largest.facts.map((f) => h('div', {}, ...f))),
    ...factList(energyError > 0 ? [['Energy error', `${figure(100 * energyError, 2)} %`]] : []).children);
  showFacts();
  app.replaceChildren(
    topBar(header.title, facts, keys, theme),
    h('main', { class: 'split motion' },
      h('section', { class: 'viewer', 'aria-label': 'Picture' },
        h('div', { class: 'canvas-box' }, stage.element,
          h('div', { class: 'runs', role: 'group', 'aria-label': 'Runs' }, ...(isModes ? [] : runButtons)), legend.element, pressures.legend.element, corner), strip),
      h('aside', { class: 'panel', 'aria-label': 'Plots and results' },
        h('div', { class: 'panel-head' }, h('div', { class: 'tabs', role: 'tablist' }, ...Object.values(tabs)),
          h('label', { class: 'search' }, icon('search'), add), names, saveCsv),
        ...(warnings.length ? [h('details', { class: 'warnings' }, h('summary', {}, icon('warning'),
          `${warnings.length} warning${warnings.length > 1 ? 's' : ''}`), ...warnings.map((w) => h('p', {}, w)))] : []),
        ...Object.values(pages))),
    h('footer', { class: 'foot' }, `Written by ${header.created_by}.`));
  const playAtFirst = state.playing;
  state.playing = false;
  refresh();
  stage.view('iso', shown);
  if (modes) {
    tab('modes');
    modes.mark(state.main);
  } else if (isStill) tab('quantities'); // one instant: nothing to plot over time
  else for (const plot of firstPlots(header)) await deck.add(plot);
  setTime(t0);
  setPlaying(playAtFirst);

  const placed = (of: (m: Mechanism) => Omit<PlacedPeak, 'run'>[]) =>
    mechanisms.flatMap((m, run) => (isModes && run !== state.main ? [] : of(m).map((p) => ({ ...p, run }))));
  (window as unknown as { flexura: unknown }).flexura = motionScripts({
    header, runs, mechanisms, stage, deck, sections, filmed, quantities: all.map((q) => q.name), start: t0, end: t1,
    largest: () => ({ displacement: most(placed((m) => m.displacements)), stress: most(placed((m) => m.stresses)) }), state, view, setField, setReference, setMode, setPlaying, setTime, showRuns, refresh,
  });
}
