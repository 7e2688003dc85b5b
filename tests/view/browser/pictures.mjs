// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// node pictures.mjs ROOT: screenshots of the pages in $FLEXURA_PAGES for the documentation (see the script "pictures").
import { existsSync } from 'node:fs';
import { join } from 'node:path';
import { launch, open, pages } from './browser.mjs';

const root = process.argv[2];
const scene = { viewport: { width: 1400, height: 900 } };
const paper = { viewport: { width: 1360, height: 860 } };

/** Page, picture, window and what to show on it. */
const pictures = [
  ['conrod.html', 'cases/steam_engine/conrod.png', scene, () => {
    flexura.setPlaying(false);
    flexura.setPhase(0);
  }],
  ['engine.html', 'cases/steam_engine/engine.png', scene, () => {
    // The piston pushes and the rod is bent as far as it goes.
    const start = flexura.end - (flexura.end - flexura.start) / 12;
    return flexura.quantity(flexura.runs.at(-1), 'rod_deflection').then((values) => {
      const times = flexura.times(flexura.runs.at(-1));
      let at = times.findIndex((t) => t >= start);
      for (let i = at; i < times.length; ++i) if (Math.abs(values[i]) > Math.abs(values[at])) at = i;
      flexura.setTime(times[at]);
    });
  }],
  ['report.html', 'mbs/view/pictures/report.png', paper, () => {}],
  ['study.html', 'mbs/view/pictures/study.png', paper, () => { document.querySelector('.plot-card').scrollIntoView(); }],
  ['extremes.html', 'mbs/view/pictures/extremes.png', paper, () => {}],
];

const browser = await launch();
for (const [page, file, window, show] of pictures) {
  if (!existsSync(join(pages, page))) {
    console.log(`${file} is left as it is: there is no ${page}`);
    continue;
  }
  const tab = await open(browser, page, window);
  await tab.evaluate(show);
  await tab.waitForTimeout(500); // plots are drawn in the next frame
  await tab.screenshot({ path: join(root, file) });
  console.log(file);
  await tab.context().close();
}
await browser.close();
