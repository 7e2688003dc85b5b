// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// node finish.cjs SITE: renders the equations of the built pages (so that reading them runs no script) and hands the
// search its index as a script, since a page opened from a folder may not fetch one.
const fs = require('node:fs');
const path = require('node:path');
const katex = require('katex');

const site = process.argv[2];
const plain = (html) =>
  html.replace(/&lt;/g, '<').replace(/&gt;/g, '>').replace(/&quot;/g, '"').replace(/&#39;/g, "'").replace(/&amp;/g, '&');
let failures = 0;
const ids = new Map(); // of each page; mkdocs checks that pages exist, not places in them
const idsOf = (page) => {
  if (!ids.has(page)) {
    const text = fs.existsSync(path.join(site, page)) ? fs.readFileSync(path.join(site, page), 'utf8') : '';
    ids.set(page, new Set([...text.matchAll(/\bid="([^"]+)"/g)].map((found) => plain(found[1]))));
  }
  return ids.get(page);
};
let equations = 0;
const files = fs.readdirSync(site, { recursive: true, encoding: 'utf8' });
const pages = (files.some((file) => file.includes(path.sep)) ? files : walk('')).filter((file) => file.endsWith('.html'));
function walk(folder) {
  // Debian's node 18.13 knows no recursive readdir.
  return fs.readdirSync(path.join(site, folder), { withFileTypes: true }).flatMap((entry) => {
    const inside = path.join(folder, entry.name);
    return entry.isDirectory() ? walk(inside) : [inside];
  });
}
for (const page of pages) {
  const file = path.join(site, page);
  const before = fs.readFileSync(file, 'utf8');
  const after = before.replace(/<(span|div) class="arithmatex">([\s\S]*?)<\/\1>/g, (whole, tag, text) => {
    const tex = plain(text).trim().replace(/^\\[([]/, '').replace(/\\[)\]]$/, '');
    equations += 1;
    try {
      return `<${tag} class="equation"${tag === 'div' ? ' tabindex="0"' : ''}>${katex.renderToString(tex, { displayMode: tag === 'div', strict: 'error' })}</${tag}>`;
    } catch (error) {
      failures += 1;
      console.error(`error: ${page}: ${error.message}`);
      return whole;
    }
  })
    // What the theme leaves out for the keyboard and for screen readers (tests/view/browser/every_page.test.mjs).
    .replace('<div class="md-search" data-md-component="search" role="dialog">', '<div class="md-search" data-md-component="search" role="dialog" aria-label="Search">')
    .replace('<div class="md-search__scrollwrap"', '<div class="md-search__scrollwrap" tabindex="0"')
    .replaceAll('<pre><span></span><code>', '<pre><span></span><code tabindex="0">')
    .replace(/<th([^>]*)><\/th>/g, '<td$1></td>');
  const body = before.slice(before.indexOf('<article'), before.indexOf('</article>'));
  for (const [, target] of body.matchAll(/<a [^>]*href="([^"]+)"/g)) {
    const [to, place] = plain(target).split('#');
    if (!place || to.includes(':')) continue;
    const other = to === '' ? page : path.normalize(path.join(path.dirname(page), decodeURIComponent(to)));
    if (idsOf(other).has(decodeURIComponent(place))) continue;
    failures += 1;
    console.error(`error: ${page}: link to ${target}, where there is no such place`);
  }
  if (after !== before) fs.writeFileSync(file, after);
}
const index = JSON.parse(fs.readFileSync(path.join(site, 'search/search_index.json'), 'utf8'));
// Texts of source files, the record of defects and tables of figures would hide what readers look for.
index.docs = index.docs.filter((doc) => !/^(source|tests|cases\/cad_parts)\/|^beam\/EXTREMES/.test(doc.location));
fs.writeFileSync(path.join(site, 'search/search_index.json'), JSON.stringify(index));
fs.writeFileSync(
  path.join(site, 'assets/search_index.js'),
  `window.__search = { index: Promise.resolve(${JSON.stringify(index)}) };\n`,
);
console.log(`${pages.length} pages, ${equations} equations, ${index.docs.length} sections to search`);
process.exit(failures ? 1 : 0);
