// check_messages.mjs ROOT [TABLE]: every text that the sources throw or refuse with, held against the rules of the house:
// a sentence of at most 400 letters (what it echoes is bounded where it is printed: mbs/input/shown_text.hpp), without the
// words of a library and without "internal", without a line break in a refusal.  With TABLE the list goes there as Markdown:
// place, kind (key: with file, line, key and value by Section::refuse), words, whether a remedy follows.
import { readdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join, relative } from 'node:path';

const [root, table] = process.argv.slice(2);
const opening = /\b(?:throw\s+(?:[\w:]+::)?(InputError|invalid_argument|runtime_error|BadFile|Error|TryFailed|PartRefused|WorkerCrashed|IntegrationError|AssemblyError)|(?:[\w.]+(?:\.|->))?(refuse))\s*\(/g;

function sources(folder) {
  return readdirSync(folder, { withFileTypes: true }).flatMap((entry) => {
    const path = join(folder, entry.name);
    if (entry.isDirectory()) return sources(path);
    return /\.[ch]pp$/.test(entry.name) ? [path] : [];
  });
}

// The literals of the call that opens before `at`, in order; {} of a format stays.
function literals(text, at) {
  let depth = 1, words = '';
  while (at < text.length && depth > 0) {
    const c = text[at];
    if (c === '"') {
      let end = at + 1;
      while (end < text.length && text[end] !== '"') end += text[end] === '\\' ? 2 : 1;
      words += text.slice(at + 1, end).replace(/\\(.)/g, (_, e) => (e === 'n' ? '\n' : e));
      at = end + 1;
      continue;
    }
    if (c === "'") {
      at += text[at + 1] === '\\' ? 4 : 3;
      continue;
    }
    if (text.startsWith('//', at)) {
      at = text.indexOf('\n', at);
      continue;
    }
    depth += c === '(' ? 1 : c === ')' ? -1 : 0;
    ++at;
  }
  return words;
}

const rows = [], wrong = [];
for (const folder of ['beam', 'mbs', 'mesh', 'reduce'])
  for (const path of sources(join(root, folder))) {
    const text = readFileSync(path, 'utf8');
    for (const match of text.matchAll(opening)) {
      const words = literals(text, match.index + match[0].length);
      if (!/[a-z]{2}/.test(words)) continue; // the words of another are passed on
      const place = `${relative(root, path)}:${text.slice(0, match.index).split('\n').length}`;
      const remedy = /;|did you mean|; known|give |take |make |write |choose |check |use |compile |wait |export |free /.test(words);
      rows.push({ place, kind: match[2] ? 'key' : match[1], words, remedy });
      const bad = [];
      if (words.length > 400) bad.push(`${words.length} letters, 400 are allowed`);
      if (/\binternal\b|json\.exception|std::|vector::|bad_alloc/.test(words)) bad.push('words that tell the user nothing');
      if (match[2] && words.includes('\n')) bad.push('a line break in a refusal');
      if (bad.length > 0) wrong.push(`${place}: ${bad.join(', ')}: "${words.slice(0, 80)}"`);
    }
  }

if (table)
  writeFileSync(table, '# Every text that is thrown\n\n| place | kind | words | remedy |\n|---|---|---|---|\n' +
    rows.map((r) => `| ${r.place} | ${r.kind} | ${r.words.replace(/\n/g, ' ').replace(/\|/g, '\\|')} | ${r.remedy ? 'yes' : ''} |`).join('\n') + '\n');
for (const line of wrong) console.log(line);
console.log(`${rows.length} texts, ${rows.filter((r) => r.kind === 'key').length} of them with key, line and value; ` +
  `${rows.filter((r) => r.remedy).length} with a remedy; ${wrong.length} against the rules`);
if (rows.length < 300) console.log('too few: does the pattern still fit the sources?');
process.exit(wrong.length === 0 && rows.length >= 300 ? 0 : 1);
