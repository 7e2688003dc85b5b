#!/usr/bin/python3
# Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
"""gather.py ROOT OUT PROGRAMS MESSAGES: gathers the pages of the site in OUT, in the layout of the repository.

Every Markdown file stays where it belongs and stands in the site under its own path, so that one set of links serves
readers of the repository and of the site.  Three things are added: a page for each other file that a page links to (its
text), a page for each command (its --help), and links from names of source files in chapters (`joint.hpp`) to them.
A name of a source file that is none, or that is ambiguous, is an error: chapters name files, never folders that move.
"""
import os
import pathlib
import posixpath
import re
import shutil
import subprocess
import sys

LINK = re.compile(r"(!?\[[^\]\[]*(?:!\[[^\]]*\]\([^)]*\))?[^\]\[]*\])\(([^)\s#]+)(#[^)\s]*)?\)")
SOURCE_NAME = re.compile(r"(?<!\[)`([A-Za-z0-9_./]+\.(?:hpp|cpp|mjs|py|ts))`(?!\])")
NAMED_IN = ("docs/theory/", "docs/verification/", "docs/architecture")
LANGUAGE = {".hpp": "cpp", ".cpp": "cpp", ".toml": "toml", ".py": "python", ".mjs": "js", ".ts": "ts", ".sh": "bash",
            "": "bash", ".c": "c"}


class Site:
    def __init__(self, root, out, programs, messages_table):
        self.root, self.out, self.programs, self.messages_table = root, out, programs, messages_table
        listed = subprocess.run(["git", "-C", root, "ls-files", "-co", "--exclude-standard"], check=True,
                                capture_output=True, text=True).stdout.split("\n")
        self.files = {name for name in listed if name and (root / name).is_file()}
        self.by_name = {}
        for name in self.files:
            self.by_name.setdefault(posixpath.basename(name), []).append(name)
        self.shown = set()  # source files that a page links to
        self.errors = []

    def write(self, name, text):
        path = self.out / "pages" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)

    def source_page(self, name):
        self.shown.add(name)
        return "source/" + name + ".md"

    def find_source(self, page, written):
        found = [f for f in self.by_name.get(posixpath.basename(written), ())
                 if f == written or f.endswith("/" + written)]
        if len(found) != 1:
            self.errors.append(f"{page}: `{written}` names {'no file' if not found else ' and '.join(sorted(found))}")
            return None
        return found[0]

    def link(self, page, text, target, anchor):
        """What becomes of one link: a page, a picture, the page of a source file, or (a folder) its README or its name."""
        if "://" in target or target.startswith("mailto:"):
            return None
        folder = posixpath.dirname(page)
        name = posixpath.normpath(posixpath.join(folder, target))
        if name.startswith("docs/generated/") or name in ("docs/reference/commands.md", "docs/reference/messages.md"):
            return None
        relative = lambda to: posixpath.relpath(to, folder or ".")
        if name in self.files:
            if name.endswith(".md"):
                return None
            if re.search(r"\.(png|svg|jpg)$", name):
                self.copy(name)
                return None
            return f"{text}({relative(self.source_page(name))})"
        if f"{name}/README.md" in self.files:
            return f"{text}({relative(name + '/README.md')}{anchor or ''})"
        if any(f.startswith(name + "/") for f in self.files):
            return f"{text[1:-1]}"
        self.errors.append(f"{page}: link to {target}, which is not there")
        return None

    def copy(self, name):
        to = self.out / "pages" / name
        to.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(self.root / name, to)

    def convert(self, page, text):
        """The page with its links and names of source files resolved, outside of fenced and indented code."""
        lines, fence = [], None
        for line in text.split("\n"):
            mark = re.match(r"\s*(```+|~~~+)", line)
            if mark and (fence is None or line.strip().startswith(fence)):
                fence = None if fence else mark.group(1)
            elif fence is None and not line.startswith("    "):
                code = re.split(r"(`[^`]*`)", line)  # links in code spans are no links
                if line.startswith("|"):  # mkdocs shows in code what GitHub takes for an escape
                    code[1::2] = [part.replace("\\|", "|") for part in code[1::2]]
                    line = "".join(code)
                if not any("](" in part for part in code[1::2]):
                    line = LINK.sub(lambda m: self.link(page, m[1], m[2], m[3]) or m[0], line)
                if page.startswith(NAMED_IN):
                    line = SOURCE_NAME.sub(lambda m: self.named(page, m), line)
            if mark and "{" in line:  # marks for the runner of the consoles
                line = re.sub(r"\s*\{[^}]*\}\s*$", "", line)
            lines.append(line)
        return "\n".join(lines)

    def named(self, page, match):
        found = self.find_source(page, match[1])
        if not found:
            return match[0]
        return f"[`{match[1]}`]({posixpath.relpath(self.source_page(found), posixpath.dirname(page))})"

    def commands(self):
        """Pages from --help: one for each command, in the order of the program."""
        run = lambda *words: subprocess.run([self.programs / words[0], *words[1:]], check=True, capture_output=True,
                                            text=True, env={**os.environ, "COLUMNS": "80"}).stdout
        overview = run("flexura", "--help")
        names = re.findall(r"^  ([a-z]+)  +\S", overview.split("Commands:")[1].split('"flexura COMMAND')[0], re.M)
        text = "# Commands\n\nWhat `flexura --help` and `flexura COMMAND --help` print.\n\n```\n" + overview + "```\n"
        for name in names:
            text += f"\n## flexura {name}\n\n```\n{run('flexura', name, '--help').rstrip()}\n```\n"
        self.write("docs/reference/commands.md", text)

    def messages(self, table):
        """A page of every text that is thrown, from the table that tests/setup/check_messages.mjs makes of the sources."""
        subjects = {}
        for line in table.read_text().split("\n"):
            cells = re.split(r"(?<!\\) \| ", line.strip("| "))
            if len(cells) != 4 or ":" not in cells[0] or cells[3].startswith("exempt"):
                continue
            folder = posixpath.dirname(cells[0].split(":")[0])
            words = re.sub(r"[<>&]", lambda m: {"<": "&lt;", ">": "&gt;", "&": "&amp;"}[m[0]], cells[2])
            subjects.setdefault(folder, {})[re.sub(r"\{[^}]*\}", "…", words.replace(" \\| ", " "))] = None
        text = ("# Messages\n\nEvery text with which the programs refuse or stop, by the folder of the sources that says it; … stands "
                "for names and numbers. Each says what is wrong and what to do, or what the value must be; the programs put file, line "
                "and key before it. A test holds all of them to that.\n")
        for folder in sorted(subjects):
            text += f"\n## {folder}\n\n" + "".join(f"- {words}\n" for words in sorted(subjects[folder]))
        self.write("docs/reference/messages.md", text)

    def run(self):
        shutil.rmtree(self.out, ignore_errors=True)
        for name in sorted(f for f in self.files if f.endswith(".md") and not f.startswith("tests/found/")):
            text = (self.root / name).read_text()
            self.write(name, self.convert(name, text))
        name = "tests/found/README.md"
        self.write(name, self.convert(name, (self.root / name).read_text()))
        self.commands()
        self.messages(self.messages_table)
        for name in sorted(self.shown):
            text = (self.root / name).read_text()
            fence = "````" if "```" in text else "```"
            language = LANGUAGE.get(posixpath.splitext(name)[1], "")
            self.write("source/" + name + ".md", "---\nsearch:\n  exclude: true\n---\n"
                       f"# {posixpath.basename(name)}\n\n`{name}`\n\n{fence}{language}\n{text.rstrip()}\n{fence}\n")
        for name in ("main.html", "site.css"):
            (self.out / "overrides").mkdir(parents=True, exist_ok=True)
            shutil.copyfile(self.root / "docs/site/overrides" / name, self.out / "overrides" / name)
        (self.out / "pages/assets").mkdir(parents=True, exist_ok=True)
        shutil.copyfile(self.root / "docs/site/overrides/site.css", self.out / "pages/assets/site.css")
        shutil.copyfile(self.root / "docs/site/mkdocs.yml", self.out / "mkdocs.yml")
        for error in self.errors:
            print("error:", error, file=sys.stderr)
        return 1 if self.errors else 0


if __name__ == "__main__":
    sys.exit(Site(*(pathlib.Path(p).resolve() for p in sys.argv[1:5])).run())
