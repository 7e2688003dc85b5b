// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// node case_pictures.mjs ROOT [PATTERN]: the pictures (those whose name fits) of the cases' READMEs from their pages in $FLEXURA_PAGES/NAME (see "pictures").
import { existsSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { launch, open, pages } from './browser.mjs';

const root = process.argv[2];

/** Page, picture, and what to show: a part of the motion, or a mode. */
const pictures = [
  ['adams_joints/universal_case01.html', 'adams_joints/universal_case01.png', { at: 0.3 }],
  ['andrews/andrews.html', 'andrews/andrews.png', { at: 0.6, view: '+z' }],
  ['assembly/engine.html', 'assembly/engine.png', { at: 0.3 }],
  ['bicycle/bicycle.html', 'bicycle/bicycle.png', { at: 0, view: '+y' }],
  ['cad_parts/hip.html', 'cad_parts/hip.png', {}],
  ['clip/clip.html', 'clip/clip.png', { at: 0.03 }],
  ['crane_girder/crane.html', 'crane_girder/crane.png', { at: 0.2 }],
  ['iftomm/a05_governor.html', 'iftomm/a05_governor.png', { at: 0.3 }],
  ['jib_crane/crane.html', 'jib_crane/crane.png', { mode: 10 }],
  ['leaf_spring/spring.html', 'leaf_spring/leaf_spring.png', { at: 0.5 }],
  ['macpherson/macpherson.html', 'macpherson/macpherson.png', { at: 0.25 }],
  ['simbeam_shaft/shaft.html', 'simbeam_shaft/shaft.png', { mode: 9 }],
  ['stiff_rod/engine.html', 'stiff_rod/engine.png', { at: 0.8 }],
  ['switches/backlash.html', 'switches/backlash.png', { at: 0.3, view: '+z' }],
  ['user_elements/magnets.html', 'user_elements/magnets.png', { at: 0.3 }],
];

const browser = await launch();
for (const [page, file, show] of pictures.filter(([, name]) => name.match(process.argv[3] ?? ''))) {
  if (!existsSync(join(pages, page))) {
    console.log(`${file} is left as it is: there is no ${page}`);
    continue;
  }
  const tab = await open(browser, page, { viewport: { width: 1160, height: 660 } });
  await tab.evaluate(async ({ at, mode, view }) => {
    if (flexura.page === 'motion') flexura.setTime(flexura.start + at * (flexura.end - flexura.start));
    else {
      flexura.setPlaying(false);
      if (mode) await flexura.setMode(mode);
      flexura.setPhase(0);
    }
    if (view) flexura.view(view);
  }, show);
  await tab.waitForTimeout(500);
  await tab.screenshot({ path: join(root, 'cases', file) });
  console.log(file);
  await tab.context().close();
}
await browser.close();
