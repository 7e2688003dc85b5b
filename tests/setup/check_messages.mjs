// check_messages.mjs ROOT [TABLE]: every text that the sources throw or refuse with, held against the rules of the house:
// a sentence of at most 400 letters (what it echoes is bounded where it is printed: mbs/base/documents/shown_text.hpp), without the
// words of a library and without "internal", without a line break in a refusal.  With TABLE the list goes there as Markdown:
// place, kind (key: with file, line, key and value by Section::refuse), words, and what the user can do:
//   remedy   an instruction, or the names that are known
//   rule     what the value must be, beside the value: nothing else is to be done
//   place    what is wrong in a file of others', with the place in it: it is mended there
//   passed   a place before the sentence of another text of this table
//   exempt   no input leads there, or it is a part of a sentence that says it: EXEMPT, each with its reason
// A text that is none of these is refused, but for the OPEN ones, which become fewer.
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
    if (c === ',' && depth === 1 && words !== '' && !words.endsWith(' | ')) words += ' | ';
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

const verbs = 'add|allow|ask|begin|build|call|check|choose|close|compile|copy|correct|cut|describe|divide|draw|drive|exclude|export|free|' +
  'fuse|give|go on|have|heal|hold|install|join|keep|lead|leave|let|list|lower|make|mesh|move|name|number|place|put|raise|reduce|refine|release|' +
  'remove|repair|save|say|see|separate|set|simulate|split|start|state|swap|take|tie|try|turn|use|wait|write';
// An instruction: behind a stop, or an argument of its own.
const instruction = new RegExp(`(^|[;:,|(.]|\\bor|\\band|\\bthen)\\s*\\(?(${verbs})\\b|did you mean|; known|one of (the two|them|each)|\\{\\}$|simulate first`);
const rule = new RegExp('\\bmust\\b|\\b(is|are) wanted\\b|\\bwants?\\b|\\bneeds?\\b|\\btakes?\\b|\\bat (least|most)\\b|\\bonly\\b|not go with|exclude each other|' +
  '\\bgoes? with\\b|\\bis for\\b|\\binstead of\\b|\\bare (allowed|tabulated)\\b|lies? (between|outside|beyond)|\\bhas \\{\\}|there (are|is) \\{\\}|\\bbetween\\b|' +
  '\\btwice\\b|\\bbelow\\b|\\babove\\b|\\bgreatest|\\blargest|\\bleast\\b|\\bnot (negative|allowed)\\b|\\bends? at\\b|\\bmore than\\b|\\bno more\\b|outside \\d|\\beach once\\b|\\bboth\\b|\\bascend|\\bnot finite\\b|not symmetric|not positive definite|the decimal sign is|\\bmay\\b|\\bjoins? two|goes on from there|shows it|\\bhas {} there|is needed|tetrahedra, hexahedra|no key of ours|the parts? of a whole');
// Decks, meshes, matrices and CAD of others: what is wrong and where; superelements against their own contents.
const places = /^(mesh\/(import|gmsh)\/|reduce\/part\/read_matrices|mbs\/superelement\/(validate|file)|mbs\/base\/hdf5\/|mbs\/results\/read_results)/;
const names = /\{\}|: | is | are | has | holds? |missing|cannot/;
const passes = /^[\s|]*(("?\w*"?:?\s*)?["']?\{\}["']?[^a-z]*|(file|points|superelement|element|beam|member|section|run|body|interface|choice|line|solver|part|:|,|;|\.|\s|\||"|'|\{\})*)$/;

// No input leads there, only a mistake of ours or a machine that is out of order, or it is a part of a sentence that has its
// remedy elsewhere; each with its reason.
const EXEMPT = [
  ['beam/ancf/', 'the library of planar and spatial lines is called by programs and tests; mechanism files go through mbs/bodies'],
  ['beam/model/mechanism.cpp', 'called with what model.cpp has checked'],
  ['mesh/model/', 'the library: numbers of cells and points that readers have checked'],
  ['reduce/elements/', 'cells that the readers do not make'],
  ['reduce/linalg/', 'solvers that do not converge on matrices that are checked to be finite, and libraries that do not start'],
  ['reduce/assembly/', 'structures that the readers have checked'],
  ['reduce/beams/', 'structures that the readers have checked'],
  ['reduce/cms/', 'options and vectors that the readers have checked, and what would be wrong numbers'],
  ['mbs/view/', 'results and superelements that their readers have checked'],
  ['mbs/results/writer.cpp', 'rows that the recorder makes'],
  ['mbs/solver/integrators/ida/ida.cpp', 'what SUNDIALS says of itself; the steps where a force jumps are named with what to do in integrator.hpp'],
  ['mbs/solver/run/bookkeeper.cpp', 'what is added to the sentence of a run that grows: which speed'],
  ['mbs/solver/run/make_integrator.cpp', 'names that options.cpp has checked'],
  ['mbs/solver/accuracy/integrator_kind.cpp', 'names that options.cpp has checked'],
  ['mbs/solver/integrators/sequence.cpp', 'the place before the sentence of an integrator'],
  ['mbs/solver/position/assemble.cpp', 'the place before the sentence of what contradicts'],
  ['mbs/bodies/modal_body.cpp', 'superelements that are validated when read'],
  ['mbs/bodies/modal_problem.cpp', 'superelements that are validated when read'],
  ['mbs/bodies/stress_field.cpp', 'superelements that are validated when read'],
  ['mbs/mechanism/user_element.hpp', 'what a user library asks of its own keys: its words'],
  ['mbs/app/run/checkpoint.cpp', 'parts of "there is no checkpoint to go on from (...); leave --continue out"'],
  ['mbs/app/run/mechanism_runs.cpp', 'what is added to a sentence of the solver'],
  ['mbs/app/simulate.cpp', 'what is added to the sentence of a run that stopped: where its rows are'],
  ['beam/element/releases.cpp', 'parts of "its releases let it ... by itself; release fewer directions"'],
  ['mbs/base/documents/check.cpp', 'the second argument is what is known or wanted'],
  ['mbs/base/documents/content_hash.cpp', 'files that a reader has read a moment before'],
  ['mbs/base/documents/units.cpp', 'a part of "is ... where ... is wanted"'],
  ['mbs/study/cache/child_process.cpp', 'programs of ours that are not there or may not be run: the words of the system'],
  ['mbs/study/study_file.cpp', 'the second argument is what is known'],
  ['mbs/base/math/rotation.cpp', 'axes that readers have checked'],
  ['mbs/joints/make_joint.cpp', 'types that the schema has checked'],
  ['mbs/bodies/body_node.cpp', 'superelements of this program hold all six motions'],
  ['mbs/solver/position/row_watch.cpp', 'what is added to the warning of a constraint that opens'],
  ['mbs/solver/statics/statics.cpp', 'nothing moves: there is nothing to search'],
  ['mbs/study/estimate/integrator_check.cpp', 'the sentence of the second run, with what it was run with'],
  ['mbs/solver/run/run_memory.cpp', 'of a state file whose checksum fits: changed by hand'],
  ['mbs/formulas/expression.cpp', 'what a formula is at a time; behind it stands where the rows before it are'],
  ['beam/section/section.cpp', 'the entry and what it is to be'],
  ['reduce/library/request.cpp', 'the key before the sentence of the modes that are struck'],
  ['reduce/library/attempt.cpp', 'before the sentence of the sizes that were out of reach'],
  ['reduce/file/part_file.cpp', 'the key before the sentence of PETSc\'s options'],
  ['mesh/gmsh/worker/read_mesh.cpp', 'damaged meshes: the child\'s words, before which the file stands'],
  ['mbs/superelement/validate.cpp', 'damaged superelements, held against themselves'],
  ['mesh/partition/', 'METIS on a mesh that is one piece'],
  ['mesh/gmsh/worker', 'the child\'s words, before which ask.cpp puts the file and behind which what to do'],
  ['mesh/gmsh/sheet.cpp', 'why a recipe for a sheet failed: the message that follows names the file and what to do'],
  ['mesh/gmsh/child.cpp', 'a system without pipes or descriptors'],
];
const OPEN = 0;  // texts of no kind that are allowed: never raised

function kindOf(path, kind, words) {
  const file = relative(root, path);
  const parts = words.split(' | ').filter((part) => /[a-z]{2}/.test(part));
  if (instruction.test(words) || (kind === 'key' && parts.length > 1)) return 'remedy';
  if (rule.test(words)) return 'rule';
  if (passes.test(words)) return 'passed';
  if (places.test(file) && names.test(words)) return 'place';
  return EXEMPT.some(([start]) => file.startsWith(start)) ? 'exempt' : '';
}

const rows = [], wrong = [], open = [];
for (const folder of ['beam', 'import', 'mbs', 'mesh', 'reduce'])
  for (const path of sources(join(root, folder))) {
    const text = readFileSync(path, 'utf8');
    for (const match of text.matchAll(opening)) {
      const words = literals(text, match.index + match[0].length);
      if (!/[a-z]{2}/.test(words)) continue; // the words of another are passed on
      const place = `${relative(root, path)}:${text.slice(0, match.index).split('\n').length}`;
      const kind = match[2] ? 'key' : match[1];
      const does = kindOf(path, kind, words);
      rows.push({ place, kind, words, does });
      const bad = [];
      if (words.length > 400) bad.push(`${words.length} letters, 400 are allowed`);
      if (/\binternal\b|json\.exception|std::|vector::|bad_alloc/.test(words)) bad.push('words that tell the user nothing');
      if (match[2] && words.includes('\n')) bad.push('a line break in a refusal');
      if (does === '') open.push(`${place}: neither remedy nor rule: "${words.slice(0, 120)}"`);
      if (bad.length > 0) wrong.push(`${place}: ${bad.join(', ')}: "${words.slice(0, 80)}"`);
    }
  }

if (table)
  writeFileSync(table, '# Every text that is thrown\n\n| place | kind | words | the user can |\n|---|---|---|---|\n' +
    rows.map((r) => `| ${r.place} | ${r.kind} | ${r.words.replace(/\n/g, ' ').replace(/\|/g, '\\|')} | ${r.does} |`).join('\n') + '\n');
if (open.length > OPEN) wrong.push(...open);
if (open.length < OPEN) console.log(`${open.length} texts are open, ${OPEN} are allowed: lower OPEN in this file`);
for (const line of wrong) console.log(line);
const counts = ['remedy', 'rule', 'place', 'passed', 'exempt', ''].map((does) => `${rows.filter((r) => r.does === does).length} ${does || 'open'}`);
console.log(`${rows.length} texts, ${rows.filter((r) => r.kind === 'key').length} of them with key, line and value: ${counts.join(', ')}; ${wrong.length} against the rules`);
if (rows.length < 300) console.log('too few: does the pattern still fit the sources?');
process.exit(wrong.length === 0 && rows.length >= 300 ? 0 : 1);
