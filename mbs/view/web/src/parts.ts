// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// The page of parts: an assembly with the joints that were proposed for it, to be accepted, changed, deleted and moved by hand, and
// the text of the files that follow; or one part with numbers on its faces, and the interfaces chosen from them.
import * as THREE from 'three';
import { coordinatesOf, JointMotion, jointTypes } from './joint_motion';
import { JointList } from './joint_list';
import { decisions, frameAlong, interfaceTexts, mechanismText, pose, type Joint, type PartsHeader } from './parts_data';
import { PartsScene, type Picked } from './parts_scene';
import { Stage, viewNames, type ViewName } from './stage';
import { cssColor, download, h, icon, iconButton, lengthText, say, shortcuts, themeButton, toggle, topBar } from './ui';

interface Chosen { body: number; face: number }

export async function partsPage(app: HTMLElement, header: PartsHeader): Promise<void> {
  const isAssembly = header.ground >= 0;
  const stage = new Stage(isAssembly ? 'The assembly; a click chooses a face or a joint' : 'The part; a click chooses a face');
  const home = header.bodies.map((b) => pose(b.rotation, b.position));
  const scene = await PartsScene.read(header, stage);
  scene.place(home);
  const box = scene.box.clone();
  const size = box.getSize(new THREE.Vector3()).length() || 1;
  const middle = box.getCenter(new THREE.Vector3());
  const motion = new JointMotion(home, size, middle);
  const state = {
    joints: decisions(header), ground: header.ground, joint: -1, body: isAssembly ? -1 : 0, freedom: 0,
    overlap: -1, // looked at
    faces: [] as Chosen[], // chosen in the picture, the latest last
    ticked: new Set<string>(), // "part face": wanted as interfaces
  };
  const faceOf = (c: Chosen) => header.parts[header.bodies[c.body].part].faces.find((f) => f.number === c.face)!;
  const isFixed = (j: Joint) => j.type === 'fixed';

  // --- what was decided ----------------------------------------------------------------------------------------------
  function decided(): void {
    if (isAssembly) {
      const accepted = state.joints.filter((j) => j.accepted);
      motion.setJoints(accepted.map((j) => ({
        type: j.type, lead: j.lead, a: j.a, b: j.b, X_AJ: home[j.a].clone().invert().multiply(j.frame), X_BJ: home[j.b].clone().invert().multiply(j.frame),
      })), state.ground);
      const { dof, redundant } = motion.freedom();
      accepted.forEach((j, i) => { j.redundant = redundant[i]; });
      state.freedom = dof;
      scene.place(motion.poses);
      scene.setJoints(state.joints, home, size);
    }
    refresh();
  }

  function drive(joint: Joint, which: Parameters<JointMotion['drive']>[1], value: number): boolean {
    const i = state.joints.filter((j) => j.accepted).indexOf(joint);
    const went = motion.drive(i, which, value);
    scene.place(motion.poses);
    return went;
  }
  const coordinate = (joint: Joint, which: Parameters<JointMotion['coordinate']>[1]) =>
    motion.coordinate(state.joints.filter((j) => j.accepted).indexOf(joint), which);

  function change(joint: Joint, change: Partial<Pick<Joint, 'type' | 'accepted' | 'name' | 'lead'>>): void {
    const wasFixed = isFixed(joint);
    Object.assign(joint, change);
    if (joint.type === 'screw' && !joint.lead) joint.lead = 1e-3; // to be changed: nothing is known of it
    // A fixed joint has no axis: that of the bore it sits on is the likeliest.
    if (change.type && wasFixed && !isFixed(joint)) {
      const seat = joint.faces.map(([body, face]) => ({ body, face })).find((c) => faceOf(c).kind === 'cylinder');
      if (seat) align(joint, seat);
    }
    decided();
  }

  /** The joint's frame on a face: z along its axis or normal. */
  function align(joint: Joint, on: Chosen): void {
    const face = faceOf(on);
    const X = home[on.body];
    const point = new THREE.Vector3(...face.point).applyMatrix4(X);
    const axis = face.axis ? new THREE.Vector3(...face.axis).transformDirection(X) : new THREE.Vector3(0, 0, 1);
    joint.frame.copy(frameAlong(point, axis));
  }

  function addJoint(type: string): void {
    const [p, q] = state.faces;
    const names = header.bodies.map((b) => b.name);
    const taken = new Set(state.joints.map((j) => j.name));
    const wanted = `${names[p.body]}_${names[q.body]}`;
    let name = wanted;
    for (let n = 2; taken.has(name); ++n) name = `${wanted}_${n}`;
    const joint: Joint = {
      name, type, lead: type === 'screw' ? 1e-3 : 0, a: p.body, b: q.body, confidence: '', doubt: '', evidence: [], faces: [[p.body, p.face], [q.body, q.face]],
      on: [p.face, q.face], accepted: true, frame: new THREE.Matrix4(), proposed: null, redundant: 0,
    };
    align(joint, faceOf(p).axis ? p : q);
    state.joints.push(joint);
    state.faces = [];
    decided();
    choose(state.joints.length - 1);
  }

  function choose(joint: number): void {
    state.joint = joint;
    state.overlap = -1;
    state.body = -1;
    state.faces = [];
    refresh();
    list?.reveal();
  }

  function chooseFace(c: Chosen): void {
    state.joint = state.overlap = -1;
    if (isAssembly) {
      const again = state.faces.findIndex((f) => f.body === c.body && f.face === c.face);
      if (again >= 0) state.faces.splice(again, 1);
      else state.faces = [...state.faces.filter((f) => f.body !== c.body).slice(-1), c];
      state.body = state.faces.at(-1)?.body ?? -1;
    } else tick(c);
    refresh();
  }

  function tick(c: Chosen): void {
    const key = `${header.bodies[c.body].part} ${c.face}`;
    if (!state.ticked.delete(key)) state.ticked.add(key);
    refresh();
  }
  const isTicked = (c: Chosen) => state.ticked.has(`${header.bodies[c.body].part} ${c.face}`);

  // --- panel: joints, faces, texts -----------------------------------------------------------------------------------
  const list = isAssembly ? new JointList(header, {
    choose, change, drive, coordinate, reset: () => { motion.reset(); scene.place(motion.poses); refresh(); },
    flip: (j) => { j.frame.multiply(new THREE.Matrix4().makeRotationX(Math.PI)); decided(); },
    align: (j, body, face) => { align(j, { body, face }); decided(); },
    remove: (j) => { state.joints.splice(state.joints.indexOf(j), 1); choose(-1); decided(); },
    ground: (body) => { state.ground = body; decided(); },
    look: (i) => { choose(-1); state.overlap = i; refresh(); },
  }, size) : null;

  const faceBox = h('div', { class: 'faces' });
  function showFaces(): void {
    const rows: HTMLElement[] = [];
    const row = (c: Chosen) => {
      const face = faceOf(c);
      const box = h('input', { type: 'checkbox', checked: isTicked(c), 'aria-label': `Interface on face ${c.face}`, onchange: () => tick(c) });
      return h('tr', { 'data-face': c.face, 'aria-selected': String(state.faces.some((f) => f.body === c.body && f.face === c.face) || isTicked(c)) },
               h('td', {}, box), h('td', { class: 'number' }, String(c.face)), h('td', {}, face.text.replaceAll('^2', '²')));
    };
    if (state.body >= 0) {
      const body = header.bodies[state.body];
      const part = header.parts[body.part];
      if (isAssembly) rows.push(h('h2', {}, body.name), h('p', { class: 'hint' }, body.text));
      rows.push(h('p', { class: 'hint' }, 'Ticked faces become interfaces of the part file.'),
                h('table', {}, h('thead', {}, h('tr', {}, h('th', {}, h('span', { class: 'unseen' }, 'interface')), h('th', { class: 'number' }, 'No'), h('th', {}, 'Face'))),
                  h('tbody', {}, ...part.faces.map((f) => row({ body: state.body, face: f.number })))));
    } else rows.push(h('p', { class: 'hint' }, 'Click a part in the picture: its faces get their numbers.'));
    if (isAssembly && state.faces.length === 2) {
      const type = h('select', { id: 'new-type', 'aria-label': 'Type of the new joint' }, ...jointTypes.map((t) => h('option', { value: t }, t)));
      type.value = 'revolute';
      const [p, q] = state.faces.map((c) => `face ${c.face} of ${header.bodies[c.body].name}`);
      rows.unshift(h('div', { class: 'new-joint' }, h('span', {}, `Between ${p} and ${q}:`), type,
                     h('button', { class: 'plain', type: 'button', id: 'new-joint', onclick: () => addJoint(type.value) }, 'New joint')));
    } else if (isAssembly && state.faces.length === 1) {
      rows.unshift(h('p', { class: 'hint' }, 'Click a face of another part as well to make a joint between the two.'));
    }
    faceBox.replaceChildren(...rows);
  }

  const textBox = h('div', { class: 'texts' });
  function block(title: string, name: string, note: string, text: string): HTMLElement {
    const copy = h('button', { class: 'plain small', type: 'button', onclick: () => {
      navigator.clipboard?.writeText(text).then(() => say('Copied'), () => say('The browser does not let this page copy: save instead'));
    } }, icon('copy'), 'Copy');
    const save = h('button', { class: 'plain small', type: 'button', onclick: () => download(name, text) }, icon('table'), 'Save');
    return h('section', { class: 'card' }, h('header', {}, h('h2', {}, title), h('span', { class: 'unit' }, note), copy, save),
             h('pre', { tabindex: 0, 'data-text': name }, text));
  }
  const texts = () => ({
    mechanism: isAssembly ? mechanismText(header, state.joints, state.ground, state.freedom) : '',
    interfaces: interfaceTexts(header, state.joints, state.ticked),
  });
  const contactLines = (header.contacts ?? []).filter((c) => c.lines).map((c) => `# ${c.text}\n${c.lines}`).join('\n');
  function showTexts(): void {
    const now = texts();
    const file = (name: string) => name.split('/').at(-1)!;
    textBox.replaceChildren(
      ...(isAssembly ? [block('mechanism.toml', 'mechanism.toml', 'put it in place of the one in the folder', now.mechanism)] : []),
      ...(contactLines ? [block('contacts.toml', 'contacts.toml', 'of what is to touch, to the end of mechanism.toml', contactLines)] : []),
      ...now.interfaces.map(({ part, text }) => block(`Interfaces of ${part.name}`, `${file(part.file).replace(/\.\w+$/, '')}.interfaces.toml`, `in ${part.file}`, text)),
      ...(now.interfaces.length ? [] : [h('p', { class: 'hint' }, isAssembly ? 'No joint sits on a face, and none is ticked.' : 'Tick faces, or click them: their interfaces stand here.')]));
  }

  const pages = [...(isAssembly ? [{ name: 'Joints', box: h('div', { class: 'tab-page' }, list!.element), show: () => list!.show(state.joints, state.joint, state.ground, state.freedom) }] : []),
                 { name: 'Faces', box: h('div', { class: 'tab-page' }, faceBox), show: showFaces },
                 { name: 'Text', box: h('div', { class: 'tab-page' }, textBox), show: showTexts }];
  let tab = 0;
  const tabs = pages.map(({ name }, i) => h('button', { type: 'button', role: 'tab', id: `tab-${name.toLowerCase()}`, onclick: () => showTab(i) }, name));
  pages.forEach(({ box, name }) => {
    box.setAttribute('role', 'tabpanel');
    box.setAttribute('aria-labelledby', `tab-${name.toLowerCase()}`);
    box.tabIndex = 0;
  });
  function showTab(i: number): void {
    tab = i;
    pages.forEach(({ box }, k) => {
      box.hidden = k !== i;
      tabs[k].setAttribute('aria-selected', String(k === i));
    });
    pages[i].show();
  }

  function refresh(): void {
    const joint = state.joint >= 0 ? state.joints[state.joint] : null;
    // Only a joint's bodies are solid; two that overlap are glass, with a ball where they do.
    const overlap = state.overlap >= 0 ? [...header.overlaps ?? [], ...header.contacts ?? []][state.overlap] : null;
    const pair = joint ?? overlap;
    scene.faded = (body) => pair !== null && (overlap !== null || (body !== pair.a && body !== pair.b));
    scene.hidden = (body) => overlap !== null && body !== overlap.a && body !== overlap.b;
    scene.point(overlap ? new THREE.Vector3(...overlap.place) : null);
    scene.numbered = (body) => numbers.getAttribute('aria-pressed') === 'true'
      && (isAssembly ? body === state.body || (joint !== null && (body === joint.a || body === joint.b)) : true);
    scene.look(state.joint);
    scene.mark([
      ...(joint ? joint.faces.map(([body, face]): [number, number, string] => [body, face, body === joint.a ? '--interface' : '--accent']) : []),
      ...state.faces.map((c): [number, number, string] => [c.body, c.face, '--interface']),
      ...(isAssembly ? [] : [...state.ticked].map((key): [number, number, string] => [0, Number(key.split(' ')[1]), '--interface'])),
    ]);
    scene.numberLater();
    pages[tab].show();
    freedomFact.textContent = String(state.freedom);
  }

  // --- controls ------------------------------------------------------------------------------------------------------
  const freedomFact = h('output', { id: 'freedom' });
  const numbers = toggle('Numbers of faces', true, () => refresh(), { title: isAssembly ? 'Of the chosen parts (N)' : 'On the faces (N)', id: 'numbers' });
  const glyphs = toggle('Joints', true, (on) => { scene.showJoints = on; }, { title: 'Joints (J)', id: 'glyphs' });
  const back = h('button', { class: 'plain', type: 'button', id: 'home', onclick: () => { motion.reset(); scene.place(motion.poses); refresh(); } },
                 icon('back'), 'As in the file');
  const view = (name: ViewName) => stage.view(name, scene.box.clone());
  const look_at = h('div', { class: 'group views', role: 'group', 'aria-label': 'Views' },
    ...viewNames.map((name) => h('button', { class: 'toggle', type: 'button', 'data-view': name,
                                             title: `Look ${name === 'iso' ? 'from a corner' : 'from ' + name}`, onclick: () => view(name) }, name)));
  async function savePng(): Promise<void> {
    scene.number();
    const blob = await stage.png(header.title, [], (g, scale) => {
      g.font = `600 ${12 * scale}px system-ui, sans-serif`;
      g.textAlign = 'center';
      g.textBaseline = 'middle';
      for (const { face, x, y } of scene.shownNumbers()) {
        g.fillStyle = cssColor('--surface');
        const wide = g.measureText(String(face)).width / 2 + 4 * scale;
        g.fillRect(x * scale - wide, (y - 8) * scale, 2 * wide, 16 * scale);
        g.fillStyle = cssColor('--ink');
        g.fillText(String(face), x * scale, y * scale);
      }
    });
    download(`${header.title.replace(/[^\w.-]+/g, '_')}.png`, blob);
  }
  const corner = h('div', { class: 'corner' }, look_at, iconButton('camera', 'Save a picture (P)', () => void savePng(), { id: 'png' }));
  const keys = shortcuts([
    ...(isAssembly ? [{ keys: ['ArrowDown'], text: 'next joint', run: () => choose(Math.min(state.joints.length - 1, state.joint + 1)) },
                      { keys: ['ArrowUp'], text: 'joint before', run: () => choose(Math.max(0, state.joint - 1)) },
                      { keys: ['j'], text: 'joints in the picture', run: () => glyphs.click() },
                      { keys: ['h'], text: 'bodies as in the file', run: () => back.click() }] : []),
    { keys: ['n'], text: 'numbers of faces', run: () => numbers.click() },
    { keys: ['u'], text: 'choose nothing', run: () => { state.body = isAssembly ? -1 : 0; choose(-1); if (!isAssembly) state.body = 0; refresh(); } },
    ...[0, 1, 2, 3, 4, 5].map((i) => ({ keys: [String(i + 1)], text: `View ${viewNames[i]}`, run: () => view(viewNames[i] as ViewName) })),
    { keys: ['0', 'i'], text: 'view from a corner', run: () => view('iso') },
    { keys: ['p'], text: 'save a picture', run: () => void savePng() },
    { keys: ['t'], text: 'light or dark', run: () => theme.click() },
    { keys: ['?'], text: 'this list', run: () => keys.click() },
  ]);
  const theme = themeButton(() => refresh());

  let pressed = { x: 0, y: 0 };
  stage.canvas.addEventListener('pointerdown', (e) => { pressed = { x: e.offsetX, y: e.offsetY }; });
  stage.canvas.addEventListener('pointerup', (e) => {
    if (e.button !== 0 || Math.hypot(e.offsetX - pressed.x, e.offsetY - pressed.y) > 3) return;
    clicked(scene.pick(e.offsetX, e.offsetY));
  });
  function clicked(what: Picked): void {
    if (what.joint >= 0) {
      choose(what.joint);
      if (tab !== 0) showTab(0);
    } else if (what.body >= 0) {
      chooseFace({ body: what.body, face: what.face });
      showTab(pages.findIndex((p) => p.name === 'Faces'));
    } else if (isAssembly) choose(-1);
  }

  const faces = header.bodies.reduce((n, b) => n + header.parts[b.part].faces.length, 0);
  const facts: [string, string][] = isAssembly
    ? [['Bodies', String(header.bodies.length)], ['Parts', String(header.parts.length)], ['Size', lengthText(size)]]
    : [['Faces', String(faces)], ['Size', lengthText(size)]];
  const bar = topBar(header.title, facts, keys, theme);
  if (isAssembly) bar.querySelector('.facts')!.append(h('div', {}, h('dt', {}, 'Degrees of freedom'), h('dd', {}, freedomFact)));
  app.replaceChildren(bar,
    h('main', { class: 'split parts' },
      h('section', { class: 'viewer', 'aria-label': 'Picture' },
        h('div', { class: 'canvas-box' }, stage.element, corner),
        h('div', { class: 'strip' }, h('div', { class: 'group' }, numbers, ...(isAssembly ? [glyphs, back] : [])))),
      h('aside', { class: 'panel', 'aria-label': isAssembly ? 'Joints' : 'Faces' },
        h('div', { class: 'panel-head' }, h('div', { class: 'tabs', role: 'tablist' }, ...tabs)), ...pages.map((p) => p.box))),
    h('footer', { class: 'foot' }, `Written by ${header.created_by}. ${header.bodies.length === 1 ? '1 body' : `${header.bodies.length} bodies`}, ${faces} faces.`));
  decided();
  showTab(0);
  view('iso');

  // --- for scripts and tests: PAGE.md --------------------------------------------------------------------------------
  (window as unknown as { flexura: unknown }).flexura = {
    page: 'parts', header, size,
    get freedom() { return state.freedom; },
    joints: () => state.joints.map(({ name, type, accepted, redundant, a, b }) => ({ name, type, accepted, redundant, a: header.bodies[a].name, b: header.bodies[b].name })),
    chooseJoint: (name: string) => choose(state.joints.findIndex((j) => j.name === name)),
    change: (name: string, to: Partial<Joint>) => change(state.joints.find((j) => j.name === name)!, to),
    coordinates: (name: string) => coordinatesOf(state.joints.find((j) => j.name === name)!.type),
    coordinate: (name: string, which: 'angle') => coordinate(state.joints.find((j) => j.name === name)!, which),
    drive: (name: string, which: 'angle', value: number) => drive(state.joints.find((j) => j.name === name)!, which, value),
    pose: (body: string) => motion.poses[header.bodies.findIndex((b) => b.name === body)].toArray(),
    click: (x: number, y: number) => clicked(scene.pick(x, y)), pick: (x: number, y: number) => scene.pick(x, y),
    numbers: () => { scene.number(); return scene.shownNumbers(); },
    texts: () => { const now = texts(); return { mechanism: now.mechanism, interfaces: Object.fromEntries(now.interfaces.map(({ part, text }) => [part.file, text])) }; },
    view, project: (p: number[]) => { const { x, y } = stage.project(new THREE.Vector3().fromArray(p)); return [x, y]; },
    camera: () => stage.matrix(), pixel: (x: number, y: number) => stage.pixel(x, y), snapshot: () => stage.snapshot(),
  };
}
