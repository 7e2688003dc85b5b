// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Bundles the page's script and style sheet:  node bundle.mjs OUT_DIR [WEB_DIR]  writes OUT_DIR/page.js and page.css.
import { build } from 'esbuild';
import { join } from 'node:path';

const out = process.argv[2] ?? 'out';
const web = process.argv[3] ?? '.';
await build({
  entryPoints: { page: join(web, 'src/page.ts') },
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
