// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Bundles the pages' scripts and style sheets:  node bundle.mjs OUT_DIR [WEB_DIR]  writes page.js, page.css (modes,
// motion), report.js and report.css (reports, a few kilobytes) to OUT_DIR.
import { build } from 'esbuild';
import { readFileSync } from 'node:fs';
import { dirname, join } from 'node:path';

const out = process.argv[2] ?? 'out';
const web = process.argv[3] ?? '.';

// Its licence wants its notice in every copy; its own comment is none that esbuild keeps.
const uplotNotice = {
  name: 'uplot-notice',
  setup(build) {
    build.onLoad({ filter: /uPlot\.esm\.js$/ }, ({ path }) => {
      const licence = readFileSync(join(dirname(path), '..', 'LICENSE'), 'utf8').replaceAll('*/', '* /');
      const code = readFileSync(path, 'utf8');
      return { contents: `/*! uPlot, by Leon Sorokin (author of uPlot)\n${licence}*/\n${code}`, loader: 'js' };
    });
  },
};
await build({
  entryPoints: { page: join(web, 'src/page.ts'), report: join(web, 'src/report.ts') },
  outdir: out,
  bundle: true,
  minify: true,
  format: 'iife',
  // What three's WebGL2 renderer needs anyway; the pages open in any browser since 2023 (DecompressionStream).
  target: ['chrome103', 'firefox113', 'safari16.4'],
  charset: 'ascii',
  legalComments: 'inline',
  logLevel: 'warning',
  plugins: [uplotNotice],
  nodePaths: [join(process.cwd(), 'node_modules')],
});
