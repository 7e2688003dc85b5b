// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// The modes page: the part with its interfaces, a list of modes, and the chosen shape moving.
import * as THREE from 'three';
import { scaleTexture } from './colormap';
import { readF4 } from './data';
import { DeformedBody } from './deformed_body';
import { FilmDialog, filmText, type Filmed, type FilmWish } from './film_dialog';
import { Legend } from './legend';
import { ModeTable, type ModeRow } from './mode_table';
import { macDialog } from './mac';
import { Stage, viewNames, type ViewName } from './stage';
import { Surface, type SurfaceHeader } from './surface';
import { cssColor, download, figure, h, iconButton, icon, lengthText, lengthUnit, say, shortcuts, slider,
         stressUnit, themeButton,
         toggle, topBar } from './ui';

export interface ModesHeader {
  format: 1;
  page: 'modes';
  title: string;
  created_by: string;
  body: { mass: number; centre: number[]; whole: number[]; n_b: number; n_q: number };
  interfaces: { name: string; tie: string; position: number[]; directions: string[] }[];
  surface: SurfaceHeader;
  modes: ModeRow[];
  mac: number[][];
  mesh_error?: boolean; // block mesh_error: a number for each vertex
}

const fieldNames = ['Part', '|u|', 'along x', 'along y', 'along z', 'von Mises', 'Error of the mesh'];

export async function modesPage(app: HTMLElement, header: ModesHeader): Promise<void> {
  const surface = await Surface.read(header.surface);
  const { modes } = header;
  for (const m of modes) { // a constraint mode has none of these
    m.frequency ??= NaN;
    m.damping ??= NaN;
    m.effective_mass ??= Array<number>(6).fill(NaN);
  }
  const hertz = (m: ModeRow) => (Number.isNaN(m.frequency) ? '' : `${figure(m.frequency, 5)} Hz`);
  const state = {
    mode: -1, pinned: -1, playing: !matchMedia('(prefers-reduced-motion: reduce)').matches, phase: 0, speed: 0.6, amplitude: 0.08, field: 1,
    cutAxis: -1, cutAt: 0.5, marked: -1,
  };

  const stage = new Stage(`Mode shapes of ${header.title}`);
  const magnitude = scaleTexture('magnitude');
  const signed = scaleTexture('signed');
  const meshError = header.mesh_error ? await readF4('mesh_error') : null;
  // What lies along sharp edges would leave all the rest dark: the last hundredth shares the end of the scale.
  const meshErrorTop = meshError ? Float32Array.from(meshError).sort()[Math.floor(0.99 * (meshError.length - 1))] : 0;
  const body = new DeformedBody(surface, magnitude, meshError);
  stage.scene.add(body.group);

  // --- what is drawn ---------------------------------------------------------------------------------------------
  const reach = () => state.amplitude * surface.size;
  /** From there the part stays on the picture, however it moves. */
  const view = (name: ViewName) => stage.view(name, surface.box.clone().expandByScalar(reach()));
  const largest = new Map<number, number>();
  const largestStress = new Map<number, number>();
  const hasStress = surface.stress !== null;
  const weight = (mode: number) => {
    const most = largest.get(mode) ?? 0;
    return most > 0 ? reach() / most : 0;
  };
  const showMode = (mode: number) => {
    body.weights.fill(0);
    if (mode >= 0) body.weights[mode] = weight(mode);
    body.magnify = Math.cos(state.phase);
    body.update();
  };
  stage.preparePane = (pane) => showMode(stage.panes > 1 && pane === 0 ? state.pinned : state.mode);
  stage.onFrame = (dt) => {
    if (!state.playing || state.mode < 0) return false;
    state.phase = (state.phase + 2 * Math.PI * state.speed * dt) % (2 * Math.PI);
    return true;
  };

  const legend = new Legend();
  stage.covered = () => legend.covered;
  const captions = [h('div', { class: 'caption' }), h('div', { class: 'caption right' })];
  const probe = h('div', { class: 'probe', hidden: true });
  const describe = (mode: number) => mode < 0 ? [h('strong', {}, 'Undeformed')] : [
    h('strong', {}, `Mode ${modes[mode].number}`), h('span', {}, hertz(modes[mode])),
    h('span', { class: 'kind' }, [modes[mode].kind, modes[mode].detail, modes[mode].set].filter((s) => s).join(', '))];

  function refresh(): void {
    const field = state.mode < 0 && state.field !== 6 ? 0 : state.field;
    const isSigned = field > 1 && field < 5;
    (body.mesh.material as THREE.ShaderMaterial).uniforms.uScale.value = isSigned ? signed : magnitude;
    (body.edges.material as THREE.ShaderMaterial).uniforms.uScale.value = isSigned ? signed : magnitude;
    const stress = (largestStress.get(state.mode) ?? 0) * weight(state.mode);
    const top = field === 6 ? meshErrorTop : field === 5 ? stress : reach();
    body.setField(field, isSigned ? -top : 0, top);
    const plane = new THREE.Vector4(0, 0, 0, 0);
    if (state.cutAxis >= 0) {
      plane.setComponent(state.cutAxis, 1);
      const low = surface.box.min.getComponent(state.cutAxis);
      const high = surface.box.max.getComponent(state.cutAxis);
      plane.w = low + state.cutAt * (high - low);
    }
    body.cut = plane;
    const { factor, unit } = field === 6 ? { factor: 100, unit: '%' } : field === 5 ? stressUnit(top) : lengthUnit(top);
    legend.show(field === 0 ? null : {
      title: `${fieldNames[field]} [${unit}]`, scale: isSigned ? 'signed' : 'magnitude',
      low: isSigned ? -top * factor : 0, high: top * factor,
      note: field === 6 ? 'of the root mean square stress' : field === 5 ? `for |u| up to ${lengthText(reach())}` : `scaled to ${lengthText(reach())}`,
    });
    captions[0].replaceChildren(...describe(stage.panes > 1 ? state.pinned : state.mode));
    captions[1].hidden = stage.panes === 1;
    captions[1].replaceChildren(...describe(state.mode));
    if (state.marked >= 0) {
      showMode(state.mode);
      const u = surface.displacement(state.marked, body.weights);
      const { factor, unit } = lengthUnit(reach());
      const c = (v: number) => figure(Math.abs(v) < 1e-6 * reach() ? 0 : v * factor, 3);
      probe.hidden = false;
      const sigma = surface.vonMises(state.marked, body.weights);
      const stress = stressUnit(sigma);
      probe.textContent = `vertex ${state.marked}   |u| ${c(u.length())}   u (${c(u.x)}, ${c(u.y)}, ${c(u.z)}) ${unit}`
        + (hasStress ? `   von Mises ${figure(sigma * stress.factor, 3)} ${stress.unit}` : '')
        + (meshError ? `   error of the mesh ${figure(100 * meshError[state.marked], 3)} %` : '');
    } else probe.hidden = true;
    stage.draw();
  }

  async function select(mode: number): Promise<void> {
    if (mode >= 0) {
      await surface.load(mode);
      if (!largest.has(mode)) {
        largest.set(mode, surface.largest(mode));
        const one = new Float32Array(modes.length);
        one[mode] = 1;
        largestStress.set(mode, surface.largestStress(one));
      }
    }
    state.mode = mode;
    state.phase = 0;
    table.select(mode);
    refresh();
  }

  function mark(vertex: number): void {
    state.marked = vertex;
    body.mark(vertex);
    refresh();
  }

  // --- look --------------------------------------------------------------------------------------------------------
  function look(): void {
    body.setLook({
      color: new THREE.Color(cssColor('--part')), accent: new THREE.Color(cssColor('--interface')),
      edge: new THREE.Color(cssColor('--edge')), outline: new THREE.Color(cssColor('--outline')), opacity: 1,
    });
    stage.draw();
  }
  const show = { edges: true, outline: true, interfaces: true };
  const interfaceLabels = header.interfaces.map((item, i) => {
    const label = h('div', { class: 'label' }, h('i', {}), h('span', {}, item.name));
    const at = new THREE.Vector3().fromArray(item.position);
    label.title = `interface ${i + 1}: ${item.tie} tie, ${item.directions.join(' ')}`;
    stage.addLabel(label, () => at);
    return label;
  });

  // --- controls ----------------------------------------------------------------------------------------------------
  const play = iconButton('pause', 'Stop (space)', () => setPlaying(!state.playing), { id: 'play' });
  function setPlaying(on: boolean): void {
    state.playing = on;
    play.replaceChildren(icon(on ? 'pause' : 'play'));
    play.title = on ? 'Stop (space)' : 'Play (space)';
    play.setAttribute('aria-label', on ? 'Stop' : 'Play');
    stage.draw();
  }
  const amplitude = slider('Amplitude', {
    min: 0, max: 30, step: 0.5, value: 100 * state.amplitude, id: 'amplitude',
    text: (v) => lengthText((v / 100) * surface.size, 2),
    change: (v) => { state.amplitude = v / 100; refresh(); },
  });
  const speed = slider('Speed', {
    min: 0.1, max: 3, step: 0.1, value: state.speed, id: 'speed',
    text: (v) => `${v.toFixed(1)} cycles/s`, change: (v) => { state.speed = v; },
  });
  const color = h('select', { id: 'color', 'aria-label': 'Colour', onchange: () => setField(Number(color.value)) },
                  ...[['Displacement', 1], ...(hasStress ? [['Von Mises stress', 5]] : []), ['Along x', 2], ['Along y', 3], ['Along z', 4],
                      ...(meshError ? [['Error of the mesh', 6]] : []), ['Part and interfaces', 0]]
                    .map(([text, value]) => h('option', { value }, String(text))));
  function setField(field: number): void {
    state.field = field;
    color.value = String(field);
    refresh();
  }
  const outline = toggle('Outline', true, (on) => { body.outline.visible = show.outline = on; stage.draw(); },
                         { title: 'Undeformed outline (O)' });
  const edges = toggle('Edges', true, (on) => { body.edges.visible = show.edges = on; stage.draw(); },
                       { title: 'Feature edges (E)' });
  const marks = toggle('Interfaces', true, (on) => {
    show.interfaces = on;
    for (const label of interfaceLabels) label.hidden = !on;
    stage.draw();
  }, { title: 'Names of the interfaces (N)' });
  const cutAt = slider('at', { min: 0, max: 1, step: 0.01, value: 0.5, id: 'cut-at',
    text: (v) => {
      if (state.cutAxis < 0) return '';
      const low = surface.box.min.getComponent(state.cutAxis);
      const high = surface.box.max.getComponent(state.cutAxis);
      return lengthText(low + v * (high - low), 3);
    },
    change: (v) => { state.cutAt = v; refresh(); } });
  cutAt.element.hidden = true;
  const cut = h('select', { id: 'cut', 'aria-label': 'Cut plane', onchange: () => {
    state.cutAxis = Number(cut.value);
    cutAt.element.hidden = state.cutAxis < 0;
    cutAt.refresh();
    refresh();
  } }, h('option', { value: -1 }, 'No cut'), h('option', { value: 0 }, 'Cut across x'),
                h('option', { value: 1 }, 'Cut across y'), h('option', { value: 2 }, 'Cut across z'));
  const compare = toggle('Side by side', false, (on) => {
    if (on !== (stage.panes === 2)) stage.widen(on ? 1.7 : 1 / 1.7);
    stage.panes = on ? 2 : 1;
    state.pinned = state.mode;
    stage.element.classList.toggle('two', on);
    if (on) say('Left stays; click another mode for the right picture');
    refresh();
  }, { title: 'Keep this mode at the left and choose another for the right (B)', id: 'compare' });
  const look_at = h('div', { class: 'group views', role: 'group', 'aria-label': 'Views' },
    ...viewNames.map((name) => h('button', { class: 'toggle', type: 'button', 'data-view': name,
                                             title: `Look ${name === 'iso' ? 'from a corner' : 'from ' + name}`,
                                             onclick: () => view(name) }, name)));
  const fileName = header.title.replace(/[^\w.-]+/g, '_');
  const nameOfMode = (m: number) => m < 0 ? header.title : [`${header.title}: mode ${modes[m].number}`, hertz(modes[m]) || modes[m].kind].join(', ');
  const fileOfMode = (m: number) => `${fileName}${m < 0 ? '' : `-mode${modes[m].number}`}`;
  async function savePng(): Promise<void> {
    download(`${fileOfMode(state.mode)}.png`, await stage.png(nameOfMode(state.mode), [legend]));
  }
  const filmed: Filmed = {
    stage, legends: [legend], title: () => nameOfMode(state.mode), name: () => fileOfMode(state.mode), seconds: () => 2 / state.speed, isPeriodic: true, look: (name) => view(name),
    // Two cycles.
    show: (part) => {
      state.phase = 4 * Math.PI * part;
      return `${((720 * part) % 360).toFixed(0)}°`;
    },
    hold: () => {
      const { playing, phase } = state;
      setPlaying(false);
      return () => { state.phase = phase; setPlaying(playing); };
    },
  };
  const film = new FilmDialog(filmed);
  const mac = macDialog(header.mac, modes, (i, j) => {
    void select(i).then(() => {
      compare.set(i !== j);
      if (i !== j) void select(j);
    });
  });
  const table = new ModeTable(modes, header.body.whole, (mode) => void select(mode));

  const strip = h('div', { class: 'strip' },
    h('div', { class: 'group' }, play, amplitude.element, speed.element),
    h('div', { class: 'group' }, color, outline, edges, marks),
    h('div', { class: 'group' }, cut, cutAt.element, compare));
  const corner = h('div', { class: 'corner' }, look_at,
    iconButton('camera', 'Save a picture (P)', () => void savePng(), { id: 'png' }),
    iconButton('film', 'Save a film (M)', () => void film.open(), { id: 'film' }));
  const step = (by: number) => {
    const next = table.neighbour(by);
    if (next >= 0) void select(next);
  };
  const axis = (i: number): [string[], string, () => void] =>
    [[String(i + 1)], `View ${viewNames[i]}`, () => view(viewNames[i] as ViewName)];
  const keys = shortcuts([
    { keys: [' '], text: 'play or stop', run: () => setPlaying(!state.playing) },
    { keys: ['ArrowDown', 'j'], text: 'next mode in the list', run: () => step(1) },
    { keys: ['ArrowUp', 'k'], text: 'previous mode', run: () => step(-1) },
    { keys: ['+', '='], text: 'larger amplitude', run: () => amplitude.set(amplitude.get() + 1) },
    { keys: ['-'], text: 'smaller amplitude', run: () => amplitude.set(amplitude.get() - 1) },
    { keys: ['['], text: 'slower', run: () => speed.set(speed.get() - 0.1) },
    { keys: [']'], text: 'faster', run: () => speed.set(speed.get() + 0.1) },
    ...[0, 1, 2, 3, 4, 5].map(axis).map(([k, text, run]) => ({ keys: k, text, run })),
    { keys: ['0', 'i'], text: 'view from a corner', run: () => view('iso') },
    { keys: ['c'], text: 'next colouring', run: () => {
      const fields = Array.from(color.options, (option) => Number(option.value)).sort();
      setField(fields[(fields.indexOf(state.field) + 1) % fields.length]);
    } },
    { keys: ['o'], text: 'undeformed outline', run: () => outline.click() },
    { keys: ['e'], text: 'feature edges', run: () => edges.click() },
    { keys: ['n'], text: 'names of the interfaces', run: () => marks.click() },
    { keys: ['b'], text: 'two modes side by side', run: () => compare.click() },
    { keys: ['p'], text: 'save a picture', run: () => void savePng() },
    { keys: ['m'], text: 'save a film', run: () => void film.open() },
    { keys: ['u'], text: 'undeformed part', run: () => void select(-1) },
    { keys: ['/'], text: 'search the list', run: () => table.focusSearch() },
    { keys: ['t'], text: 'light or dark', run: () => theme.click() },
    { keys: ['?'], text: 'this list', run: () => keys.click() },
  ]);
  const theme = themeButton(look);

  // A click that is not a drag asks for the vertex under it.
  let pressed = { x: 0, y: 0 };
  stage.canvas.addEventListener('pointerdown', (e) => { pressed = { x: e.offsetX, y: e.offsetY }; });
  stage.canvas.addEventListener('pointerup', (e) => {
    if (e.button !== 0 || Math.hypot(e.offsetX - pressed.x, e.offsetY - pressed.y) > 3 || stage.panes > 1) return;
    mark(nearest(e.offsetX, e.offsetY));
  });
  function nearest(x: number, y: number): number {
    showMode(state.mode);
    let best = -1;
    let least = Infinity;
    const p = new THREE.Vector3();
    for (let v = 0; v < header.surface.vertices; ++v) {
      body.drawn(v, p);
      const depth = p.distanceTo(stage.camera.position);
      const at = stage.project(p, true);
      const miss = Math.hypot(at.x - x, at.y - y);
      // Within a few pixels the nearer vertex wins.
      if (miss < 12 && miss + (200 * depth) / surface.size < least) {
        least = miss + (200 * depth) / surface.size;
        best = v;
      }
    }
    return best;
  }

  const frequencies = modes.map((m) => m.frequency).filter((f) => !Number.isNaN(f));
  const range = frequencies.length ? `${figure(Math.min(...frequencies), 4)} – ${figure(Math.max(...frequencies), 4)} Hz` : 'none';
  app.replaceChildren(
    topBar(header.title, [['Mass', `${figure(header.body.mass, 4)} kg`], ['Size', lengthText(surface.size)],
                          ['Interfaces', String(header.interfaces.length)], ['Modes', `${[...new Set(modes.map((m) => m.set))].map((set) => `${modes.filter((m) => m.set === set).length} ${set.toLowerCase()}`).join(', ')}`], ['Frequencies', range]],
           keys, theme),
    h('main', { class: 'split' },
      h('section', { class: 'viewer', 'aria-label': 'Picture' },
        h('div', { class: 'canvas-box' }, stage.element, ...captions, legend.element, probe, corner), strip),
      h('aside', { class: 'panel', 'aria-label': 'Modes' }, table.element,
        h('div', { class: 'panel-foot' }, table.struckLine, h('button', { class: 'plain', type: 'button', id: 'mac',
          onclick: () => mac.showModal() }, icon('grid'), 'MAC matrix')))),
    mac,
    h('footer', { class: 'foot' }, `Written by ${header.created_by}. ${header.surface.vertices} vertices, ${
      header.surface.triangles} triangles.${(header.surface.levels ?? 511) < 511
      ? ` Shapes to 1/${header.surface.levels} of their largest displacement, to keep this page small.` : ''}`));
  setPlaying(state.playing);
  look();
  view('iso');
  if (modes.length) await select(modes.findIndex((m) => m.frequency > 0) >= 0 ? modes.findIndex((m) => m.frequency > 0) : 0);
  else refresh();

  // --- for scripts and tests: PAGE.md ------------------------------------------------------------------------------
  (window as unknown as { flexura: unknown }).flexura = {
    page: 'modes', header, frequencies: modes.map((m) => m.frequency),
    get mode() { return state.mode < 0 ? null : modes[state.mode].number; },
    setMode: (number: number | null) => select(number === null ? -1
      : modes.findIndex((m) => m.number === number && m.set === table.set)),
    get set() { return table.set; }, setSet: (name: string) => table.showSet(name),
    setAmplitude: (fraction: number) => { amplitude.set(100 * fraction); state.amplitude = fraction; refresh(); },
    setPhase: (phase: number) => { setPlaying(false); state.phase = phase; refresh(); stage.drawNow(); },
    setPlaying, setField, view,
    size: surface.size,
    vertex: (v: number) => surface.position(v).toArray(),
    displacement: (v: number) => {
      showMode(state.mode);
      return surface.displacement(v, body.weights).multiplyScalar(body.magnify).toArray();
    },
    vonMises: (v: number) => { showMode(state.mode); return surface.vonMises(v, body.weights); },
    meshError: (v: number) => (meshError ? meshError[v] : null),
    deformed: (v: number) => { showMode(state.mode); return body.drawn(v).toArray(); },
    project: (p: number[]) => { const { x, y } = stage.project(new THREE.Vector3().fromArray(p)); return [x, y]; },
    camera: () => stage.matrix(),
    mark: (v: number) => { mark(v); stage.drawNow(); },
    pixel: (x: number, y: number) => stage.pixel(x, y), snapshot: () => stage.snapshot(),
    film: (wish: FilmWish) => filmText(filmed, wish),
    struck: () => table.struck(), framesDrawn: () => stage.framesDrawn,
  };
}
