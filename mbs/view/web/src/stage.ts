// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// The drawing area: renderer, camera, views along the axes, labels, axes triad, pictures.  Draws only when asked.
import * as THREE from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import type { Legend } from './legend';
import { h, cssColor } from './ui';

// Colours go to the screen as they are written: they must match the legend's.
THREE.ColorManagement.enabled = false;

export const viewNames = ['+x', '−x', '+y', '−y', '+z', '−z', 'iso'] as const;
export type ViewName = (typeof viewNames)[number];
const directions: Record<ViewName, [number, number, number]> = {
  '+x': [1, 0, 0], '−x': [-1, 0, 0], '+y': [0, 1, 0], '−y': [0, -1, 0], '+z': [0, 0, 1], '−z': [0, 0, -1],
  iso: [0.62, -1, 0.62],
};

/** Against gravity, where there is one; otherwise z. */
export function upIn(gravity: [number, number, number] | undefined): THREE.Vector3 {
  const up = new THREE.Vector3(...(gravity ?? [0, 0, 0])).negate();
  return up.length() > 0 ? up.normalize() : new THREE.Vector3(0, 0, 1);
}

const narrow = 760; // [px]: a wider window has room for the colour scale beside what its picture shows

interface Label { element: HTMLElement; place: () => THREE.Vector3 }

export class Stage {
  readonly element: HTMLElement;
  readonly canvas: HTMLCanvasElement;
  readonly scene = new THREE.Scene();
  readonly camera = new THREE.PerspectiveCamera(24, 1, 0.01, 100);
  readonly controls: OrbitControls;
  /** Called before each picture with the time since the last one [s]; true asks for another one. */
  onFrame: (dt: number) => boolean = () => false;
  /** Side by side: number of pictures, each prepared before it is drawn. */
  panes = 1;
  /** What covers the picture's right edge [px]: narrow pictures are fitted beside it. */
  covered: () => number = () => 0;
  preparePane: (pane: number) => void = () => {};
  framesDrawn = 0;
  private readonly renderer: THREE.WebGLRenderer;
  private readonly labels: Label[] = [];
  private readonly labelLayer = h('div', { class: 'labels' });
  private readonly triad: SVGSVGElement;
  private queued = false;
  private last = 0;
  private readonly centre = new THREE.Vector3();
  private readonly halfExtent = new THREE.Vector3(1, 1, 1);
  private radius = 1;
  private beside = 0;
  private ratio: number | null = null; // pixels for each CSS pixel, while it is set
  private readonly upright = new THREE.Quaternion(); // from z to where up is

  constructor(label: string, up = new THREE.Vector3(0, 0, 1)) {
    this.canvas = h('canvas', { tabindex: 0, role: 'img', 'aria-label': label });
    this.triad = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
    this.triad.setAttribute('class', 'triad');
    this.triad.setAttribute('viewBox', '-36 -36 72 72');
    this.triad.setAttribute('aria-hidden', 'true');
    this.element = h('div', { class: 'stage' }, this.canvas, this.labelLayer, this.triad);
    this.renderer = new THREE.WebGLRenderer({ canvas: this.canvas, antialias: true, alpha: true });
    this.renderer.outputColorSpace = THREE.LinearSRGBColorSpace;
    this.renderer.setClearColor(0, 0);
    this.renderer.autoClear = false;
    this.camera.up.copy(up);
    if (up.z > -0.999) this.upright.setFromUnitVectors(new THREE.Vector3(0, 0, 1), up);
    else this.upright.set(1, 0, 0, 0); // z down: x stays where it is
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.enableDamping = false;
    this.controls.zoomToCursor = true;
    this.controls.addEventListener('change', () => this.draw());
    new ResizeObserver(() => this.resize()).observe(this.element);
    addEventListener('beforeprint', () => this.forPrint());
  }

  /** Asks for a picture soon. */
  draw(): void {
    if (this.queued) return;
    this.queued = true;
    requestAnimationFrame((now) => this.frame(now));
  }

  /** Draws now; needed before reading pixels. */
  drawNow(): void {
    const width = this.canvas.clientWidth;
    const height = this.canvas.clientHeight;
    this.renderer.setScissorTest(false);
    this.renderer.clear();
    const each = width / this.panes;
    this.fitCamera();
    this.renderer.setScissorTest(this.panes > 1);
    for (let pane = 0; pane < this.panes; ++pane) {
      this.renderer.setViewport(pane * each, 0, each, height);
      this.renderer.setScissor(pane * each, 0, each, height);
      this.preparePane(pane);
      this.renderer.render(this.scene, this.camera);
    }
    this.placeLabels();
    this.drawTriad();
    ++this.framesDrawn;
  }

  private frame(now: number): void {
    this.queued = false;
    const dt = this.last ? Math.min(0.1, (now - this.last) / 1000) : 0;
    const more = this.onFrame(dt);
    this.last = more ? now : 0;
    this.drawNow();
    if (more) this.draw();
  }

  private resize(): void {
    const { clientWidth: w, clientHeight: hh } = this.element;
    if (!w || !hh) return;
    this.renderer.setPixelRatio(this.ratio ?? Math.min(devicePixelRatio, 2));
    this.renderer.setSize(w, hh, false);
    this.drawNow();
  }

  /** What the views show: everything inside this box. */
  setExtent(box: THREE.Box3): void {
    box.getCenter(this.centre);
    box.getSize(this.halfExtent).multiplyScalar(0.5);
    this.radius = Math.max(1e-9, this.halfExtent.length());
    this.controls.minDistance = this.radius * 0.05;
    this.controls.maxDistance = this.radius * 60;
  }

  private fitCamera(): void {
    this.camera.aspect = this.element.clientWidth / this.panes / Math.max(1, this.element.clientHeight);
    const distance = this.camera.position.distanceTo(this.centre);
    this.camera.near = Math.max(distance - 6 * this.radius, distance * 0.005, this.radius * 1e-3);
    this.camera.far = distance + 12 * this.radius;
    const { clientWidth: w, clientHeight: hh } = this.element;
    if (this.beside > 0 && this.panes === 1) this.camera.setViewOffset(w, hh, this.beside / 2, 0, w, hh);
    else this.camera.clearViewOffset();
    this.camera.updateProjectionMatrix();
  }

  view(name: ViewName, box?: THREE.Box3): void {
    if (box) this.setExtent(box);
    const d = new THREE.Vector3(...directions[name]).normalize();
    if (name === 'iso') d.applyQuaternion(this.upright);
    // Exactly along the vertical the camera has no up: lean by a millionth, where z is up with +y up on the screen.
    if (Math.abs(d.dot(this.camera.up)) > 0.999) d.add(new THREE.Vector3(0, -1e-6, 0).applyQuaternion(this.upright)).normalize();
    const width = this.element.clientWidth;
    this.beside = this.panes === 1 && innerWidth < narrow ? Math.min(this.covered(), 0.3 * width) : 0;
    this.camera.position.copy(this.centre).addScaledVector(d, Math.max(this.fittingDistance(d), 1.2 * this.radius));
    this.controls.target.copy(this.centre);
    this.controls.update();
    this.draw();
  }

  /** From this far along d all corners of the extent are on the picture, with a margin of a tenth of it. */
  private fittingDistance(d: THREE.Vector3): number {
    const right = new THREE.Vector3().crossVectors(this.camera.up, d).normalize();
    const up = new THREE.Vector3().crossVectors(d, right);
    const width = this.element.clientWidth / this.panes - this.beside || 1;
    const tall = 0.9 * Math.tan(THREE.MathUtils.degToRad(this.camera.fov / 2));
    const wide = (tall * width) / (this.element.clientHeight || 1);
    let distance = 0;
    for (let i = 0; i < 8; ++i) {
      const c = new THREE.Vector3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1).multiply(this.halfExtent);
      distance = Math.max(distance, c.dot(d) + Math.max(Math.abs(c.dot(right)) / wide, Math.abs(c.dot(up)) / tall));
    }
    return distance;
  }

  /** Steps back (or closer) so that as much is seen after the width of a picture changed by this factor. */
  widen(factor: number): void {
    const out = this.camera.position.clone().sub(this.controls.target).multiplyScalar(factor);
    this.camera.position.copy(this.controls.target).add(out);
    this.controls.update();
    this.draw();
  }

  /** Moves camera and target together: the camera follows a body. */
  follow(shift: THREE.Vector3): void {
    this.camera.position.add(shift);
    this.controls.target.add(shift);
    this.centre.add(shift);
  }

  addLabel(element: HTMLElement, place: () => THREE.Vector3): void {
    this.labels.push({ element, place });
    this.labelLayer.append(element);
  }

  /** Place on the element [px], from its upper left corner, of a point in W; of the first pane. */
  project(p: THREE.Vector3, fitted = false): { x: number; y: number; behind: boolean } {
    if (!fitted) this.fitCamera();
    this.camera.updateMatrixWorld();
    const v = p.clone().project(this.camera);
    return { x: (v.x / 2 + 0.5) * (this.element.clientWidth / this.panes),
             y: (0.5 - v.y / 2) * this.element.clientHeight, behind: v.z > 1 };
  }

  private placeLabels(): void {
    for (const { element, place } of this.labels) {
      if (element.hidden) continue;
      const at = this.project(place(), true);
      element.style.transform = `translate(${at.x.toFixed(1)}px, ${at.y.toFixed(1)}px)`;
      element.style.visibility = at.behind ? 'hidden' : '';
    }
  }

  private drawTriad(): void {
    const turn = new THREE.Matrix3().setFromMatrix4(this.camera.matrixWorldInverse);
    const axes = (['x', 'y', 'z'] as const).map((name, i) => {
      const v = new THREE.Vector3(i === 0 ? 1 : 0, i === 1 ? 1 : 0, i === 2 ? 1 : 0).applyMatrix3(turn);
      return { name, x: 23 * v.x, y: -23 * v.y, z: v.z };
    });
    axes.sort((a, b) => a.z - b.z);
    this.triad.innerHTML = axes.map((a) => `<g class="axis-${a.name}"><line x2="${a.x.toFixed(2)}" y2="${a.y.toFixed(2)}"/>
      <text x="${(1.38 * a.x).toFixed(2)}" y="${(1.38 * a.y).toFixed(2)}">${a.name}</text></g>`).join('');
  }

  /** The picture with lines of text (the first is its title) and colour scales, on the theme's background: opaque. */
  paint(g: CanvasRenderingContext2D, lines: string[], legends: Legend[], scale: number): void {
    this.drawNow();
    const { width, height } = g.canvas;
    const ground = g.createLinearGradient(0, 0, 0, height);
    ground.addColorStop(0, cssColor('--stage-top') || '#fff');
    ground.addColorStop(1, cssColor('--stage-bottom') || '#fff');
    g.fillStyle = ground;
    g.fillRect(0, 0, width, height);
    g.drawImage(this.canvas, 0, 0, width, height);
    g.fillStyle = cssColor('--ink') || '#000';
    g.textBaseline = 'top';
    lines.forEach((line, i) => {
      // Beside the colour scale.
      g.font = `${i === 0 ? '600 15' : '14'}px system-ui, sans-serif`;
      const fits = Math.min(1, (width / scale - 150) / Math.max(1, g.measureText(line).width));
      g.font = `${i === 0 ? 600 : 400} ${(i === 0 ? 15 : 14) * scale * fits}px system-ui, sans-serif`;
      g.fillText(line, 16 * scale, (14 + 22 * i) * scale);
    });
    for (const legend of legends) legend.paint(g, width, scale);
  }

  /** The same as PNG, as large as on the screen. */
  async png(caption: string, legends: Legend[], more: (g: CanvasRenderingContext2D, scale: number) => void = () => {}): Promise<Blob> {
    const copy = h('canvas', { width: this.canvas.width, height: this.canvas.height });
    const g = copy.getContext('2d')!;
    const scale = this.canvas.width / (this.canvas.clientWidth || this.canvas.width);
    this.paint(g, [caption], legends, scale);
    more(g, scale);
    return new Promise((resolve, reject) =>
      copy.toBlob((blob) => (blob ? resolve(blob) : reject(new Error('the browser made no PNG'))), 'image/png'));
  }

  /** Draws in another size, out of sight, while `work` goes on; what was on the picture stays on it. */
  async whileSized<T>(width: number, height: number, work: () => Promise<T>): Promise<T> {
    const aspect = this.element.clientWidth / Math.max(1, this.element.clientHeight);
    const style = this.element.style.cssText;
    const back = Math.max(1, aspect / (width / height));
    this.element.style.cssText = `position: fixed; inset: 0 auto auto 0; width: ${width}px; height: ${height}px; visibility: hidden`;
    this.ratio = 1;
    this.resize();
    this.widen(back);
    try {
      return await work();
    } finally {
      this.element.style.cssText = style;
      this.ratio = null;
      this.widen(1 / back);
      this.resize();
    }
  }

  /** Projection times view, 16 numbers by columns, as the last picture was drawn. */
  matrix(): number[] {
    this.drawNow();
    return new THREE.Matrix4().multiplyMatrices(this.camera.projectionMatrix, this.camera.matrixWorldInverse).toArray();
  }

  /** RGBA of every CSS pixel of another scene from the same camera, rows from the bottom, without smoothing. */
  offscreen(scene: THREE.Scene): { width: number; height: number; data: Uint8Array } {
    const width = Math.max(1, this.canvas.clientWidth);
    const height = Math.max(1, this.canvas.clientHeight);
    const target = new THREE.WebGLRenderTarget(width, height, { generateMipmaps: false, minFilter: THREE.NearestFilter, magFilter: THREE.NearestFilter });
    const data = new Uint8Array(4 * width * height);
    this.fitCamera();
    this.renderer.setScissorTest(false);
    this.renderer.setRenderTarget(target);
    this.renderer.clear();
    this.renderer.render(scene, this.camera);
    this.renderer.readRenderTargetPixels(target, 0, 0, width, height, data);
    this.renderer.setRenderTarget(null);
    target.dispose();
    return { width, height, data };
  }

  /** RGBA of one pixel of the canvas, at CSS coordinates from the upper left corner. */
  pixel(x: number, y: number): number[] {
    this.drawNow();
    const g = this.renderer.getContext();
    const ratio = this.renderer.getPixelRatio();
    const out = new Uint8Array(4);
    g.readPixels(Math.round(x * ratio), Math.round(this.canvas.height - 1 - y * ratio), 1, 1, g.RGBA, g.UNSIGNED_BYTE, out);
    return [...out];
  }

  /** The picture without labels, as a data address of a PNG, drawn at this moment. */
  snapshot(): string {
    this.drawNow();
    return this.canvas.toDataURL('image/png');
  }

  /** WebGL pictures vanish from paper: an image takes their place. */
  private forPrint(): void {
    this.drawNow();
    let image = this.element.querySelector<HTMLImageElement>('img.print');
    if (!image) this.element.append((image = h('img', { class: 'print', alt: 'The picture above at this moment' })));
    image.src = this.canvas.toDataURL('image/png');
  }
}
