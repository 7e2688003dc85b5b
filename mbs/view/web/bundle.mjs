// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Bundles the pages' scripts and style sheets:  node bundle.mjs OUT_DIR [WEB_DIR]  writes page.js, page.css (modes,
// motion), report.js and report.css (reports, a few kilobytes) to OUT_DIR.
import { build } from 'esbuild';
import { join } from 'node:path';

const out = process.argv[2] ?? 'out';
const web = process.argv[3] ?? '.';
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
  nodePaths: [join(process.cwd(), 'node_modules')],
});
