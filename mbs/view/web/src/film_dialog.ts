// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// What is asked before a film is made, and the film of a page: its picture with title, time and colour scale.
import { encodeFilm, filmFormats, writableFormats, type FilmFormat } from './film';
import type { Legend } from './legend';
import type { Stage, ViewName } from './stage';
import { download, h, say } from './ui';

export interface Filmed {
  stage: Stage;
  legends: Legend[];
  title: () => string;
  /** Of the file, without its ending. */
  name: () => string;
  /** Length that is proposed [s]. */
  seconds: () => number;
  /** It ends where it began: the last frame is not the first again. */
  isPeriodic: boolean;
  /** Shows the instant at this part of the film (0 to 1) and says it in words: "t = 0.5 s". */
  show: (part: number) => string;
  look: (view: ViewName) => void;
  /** Before and after: stops, and goes on where it was. */
  hold: () => () => void;
}

export interface FilmWish { format: FilmFormat; width?: number; height?: number; fps?: number; seconds?: number; view?: ViewName }

const mostFrames = 6000;

/** What is wrong with a wish, or null. */
export function refusal({ width, height, fps, seconds }: Required<Omit<FilmWish, 'format' | 'view'>>): string | null {
  if (!(fps >= 1 && fps <= 60)) return 'frames per second are 1 to 60';
  if (!(seconds > 0 && seconds * fps <= mostFrames)) return `a film has 1 to ${mostFrames} frames: choose fewer seconds, or fewer frames a second`;
  if (![width, height].every((x) => x >= 64 && x <= 4096)) return 'a film is 64 to 4096 pixels wide and high';
  return null;
}

export async function makeFilm(page: Filmed, wish: FilmWish, progress: (part: number) => void = () => {}, stop?: AbortSignal): Promise<Blob> {
  const { stage } = page;
  // Video codecs take even sizes.
  const even = (x: number) => 2 * Math.round(x / 2);
  const full = { width: even(wish.width ?? stage.element.clientWidth), height: even(wish.height ?? stage.element.clientHeight),
                 fps: wish.fps ?? 25, seconds: wish.seconds ?? page.seconds() };
  const wrong = refusal(full);
  if (wrong) throw new Error(wrong);
  const frames = Math.max(1, Math.round(full.fps * full.seconds));
  const release = page.hold();
  try {
    return await stage.whileSized(full.width, full.height, () => {
      if (wish.view) page.look(wish.view);
      return encodeFilm({ format: wish.format, width: full.width, height: full.height, fps: full.fps, frames }, (g, i) => {
        const when = page.show(page.isPeriodic ? i / frames : frames > 1 ? i / (frames - 1) : 0);
        stage.paint(g, [page.title(), when], page.legends, Math.max(0.8, full.height / 640));
      }, progress, stop);
    });
  } finally {
    release();
  }
}

/** For scripts: the film as base64. */
export async function filmText(page: Filmed, wish: FilmWish): Promise<string> {
  const film = await makeFilm(page, wish);
  return new Promise((resolve, reject) => {
    const reader = new FileReader();
    reader.onload = () => resolve((reader.result as string).split(',')[1]);
    reader.onerror = () => reject(new Error('the film could not be read back'));
    reader.readAsDataURL(film);
  });
}

const formatNames: Record<FilmFormat, string> = { mp4: 'MP4 (presentations, phones)', webm: 'WebM (browsers)', gif: 'GIF (everywhere, larger)' };

export class FilmDialog {
  readonly element: HTMLDialogElement;
  private readonly format = h('select', { id: 'film-format' }, ...filmFormats.map((f) => h('option', { value: f }, formatNames[f])));
  private readonly size = h('select', { id: 'film-size' });
  private readonly seconds = h('input', { id: 'film-seconds', type: 'number', min: 0.1, step: 'any' });
  private readonly fps = h('input', { id: 'film-fps', type: 'number', min: 1, max: 60, value: 25 });
  private readonly bar = h('progress', { max: 1, value: 0, hidden: true, 'aria-label': 'Progress' });
  private readonly save = h('button', { class: 'plain', type: 'button', id: 'film-save', onclick: () => void this.make() }, 'Save');
  private stop: AbortController | null = null;

  constructor(private readonly page: Filmed) {
    const field = (name: string, input: HTMLElement) => h('label', {}, h('span', {}, name), input);
    this.element = h('dialog', { class: 'film', 'aria-label': 'Film' }, h('h2', {}, 'Film'),
      field('Format', this.format), field('Size', this.size), field('Length [s]', this.seconds), field('Frames a second', this.fps), this.bar,
      h('form', { method: 'dialog' }, this.save, ' ', h('button', { class: 'plain', id: 'film-cancel' }, 'Cancel')));
    this.element.addEventListener('close', () => this.stop?.abort());
    document.body.append(this.element);
  }

  async open(): Promise<void> {
    if (this.element.open) return;
    const { clientWidth: w, clientHeight: hh } = this.page.stage.element;
    this.size.replaceChildren(h('option', { value: `${w}x${hh}` }, `as on the page, ${w} × ${hh}`),
                              ...['1280x720', '1920x1080', '800x450'].map((s) => h('option', { value: s }, s.replace('x', ' × '))));
    this.seconds.value = String(Number(this.page.seconds().toPrecision(3)));
    const can = await writableFormats(1280, 720);
    Array.from(this.format.options).forEach((option) => { option.disabled = !can.includes(option.value as FilmFormat); });
    if (!can.includes(this.format.value as FilmFormat)) this.format.value = can[0];
    this.element.showModal();
  }

  private async make(): Promise<void> {
    const [width, height] = this.size.value.split('x').map(Number);
    const format = this.format.value as FilmFormat;
    this.stop = new AbortController();
    this.save.disabled = true;
    this.bar.hidden = false;
    try {
      const film = await makeFilm(this.page, { format, width, height, fps: Number(this.fps.value), seconds: Number(this.seconds.value) },
                                  (part) => { this.bar.value = part; }, this.stop.signal);
      download(`${this.page.name()}.${format}`, film);
      this.element.close();
    } catch (error) {
      if (!this.stop.signal.aborted) say(error instanceof Error ? error.message : String(error));
    } finally {
      this.stop = null;
      this.save.disabled = false;
      this.bar.hidden = true;
    }
  }
}
