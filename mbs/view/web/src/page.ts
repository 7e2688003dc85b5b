// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Every page starts here: the header says which one it is.
import 'uplot/dist/uPlot.min.css';
import './theme.css';
import './style.css';
import { readHeader } from './data';
import { modesPage, type ModesHeader } from './modes';
import { motionPage, type MotionHeader } from './motion';
import { partsPage } from './parts';
import type { PartsHeader } from './parts_data';
import { h } from './ui';

async function start(): Promise<void> {
  const app = document.getElementById('app')!;
  try {
    if (typeof DecompressionStream === 'undefined') {
      throw new Error('this browser is too old: Chrome 103, Firefox 113, Safari 16.4 or newer show this page');
    }
    const header = readHeader<ModesHeader | MotionHeader | PartsHeader>();
    if (header.format !== 1) throw new Error(`this page has the unknown format ${String(header.format)}`);
    if (header.page === 'modes') await modesPage(app, header);
    else if (header.page === 'parts') await partsPage(app, header);
    else await motionPage(app, header);
    document.documentElement.dataset.ready = 'true';
  } catch (error) {
    console.error(error);
    const text = error instanceof Error ? error.message : String(error);
    const hint = /webgl/i.test(text) ? ' The page draws with WebGL 2: switch hardware acceleration on.' : '';
    app.replaceChildren(h('div', { class: 'failure', role: 'alert' }, h('h1', {}, 'This page cannot be shown'),
                          h('p', {}, text + '.' + hint)));
    document.documentElement.dataset.ready = 'failed';
  }
}

void start();
