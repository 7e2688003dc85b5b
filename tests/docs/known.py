#!/usr/bin/python3
# Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
"""known.py ROOT PROGRAMS: what the documentation names is there.

Every command of flexura and every option beside it in a Markdown file is in the program's --help; every link to a file
leads to one, and one into a page to a heading of it; every name of a source file in a chapter (`joint.hpp`) belongs to one file (docs/site/gather.py).  (Commands in ```console blocks of docs/ are run and compared by consoles.py.)
"""
import pathlib
import re
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "docs/site"))
sys.dont_write_bytecode = True
import gather  # noqa: E402

LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s#]*)(?:#([^)\s]*))?\)")
# flexura COMMAND and what follows it on its line (also flexura-reduce), up to the end of the code span or a pipe
CALL = re.compile(r"(?<![\w/.-])(?<!from )flexura(?:-reduce| ([a-z]+))((?: [^\n`|;&#)]*)?)")
# Fenced blocks, indented ones, spans.  Prose may say "flexura reads".
IN_CODE = re.compile(r"^```[a-z]*\n(.*?)^```|^    (.*?)$|`([^`\n]+)`", re.M | re.S)
MADE = {"commands.md", "messages.md"}  # by docs/build, in docs/reference
OWN = {"man", "completion", "help"}  # commands of the terminal itself


def places(page):
    """The places in a page that links can name: its headings, as GitHub and the site (docs/site/mkdocs.yml) write them."""
    text = re.sub(r"^```.*?^```", "", page.read_text(), flags=re.M | re.S)
    plain = lambda heading: re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", heading)  # of a link its text
    return {re.sub(r"[^\w\- ]", "", plain(heading).strip().lower()).replace(" ", "-")
            for heading in re.findall(r"^#+ +(.*?)#*$", text, re.M)}


def main():
    root, programs = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    helped = lambda *words: subprocess.run([programs / "flexura", *words, "--help"], capture_output=True, text=True,
                                           check=True).stdout
    commands = re.findall(r"^  ([a-z]+)  +\S", helped().split("Commands:")[1].split('"flexura COMMAND')[0], re.M)
    options = {c: set(re.findall(r"(?<![\w-])(--?[a-z][a-z-]*)", helped(c))) for c in commands}
    listed = subprocess.run(["git", "-C", root, "ls-files", "-co", "--exclude-standard", "*.md"], capture_output=True,
                            text=True, check=True).stdout.split()
    failures = calls = links = 0
    site = gather.Site(root, root, programs, None)
    for name in listed:
        if not (root / name).is_file():
            continue
        text = (root / name).read_text()
        if name.startswith(gather.NAMED_IN):
            for match in gather.SOURCE_NAME.finditer(text):
                site.find_source(name, match[1])
        # What was found by trying, and what changed, names options that there no longer are.
        if name.startswith("tests/found/") or name == "CHANGELOG.md":
            text = ""
        code = "\n".join("".join(found) for found in IN_CODE.findall(text))
        for match in CALL.finditer(code.replace("\\\n", " ")):
            command = match[1] or "reduce"
            if command in OWN or match[0].startswith("flexura COMMAND"):
                continue
            calls += 1
            if command not in options:
                failures += 1
                print(f"{name}: flexura has no command '{command}' ({match[0].strip()})")
                continue
            quoted = re.sub(r'"[^"]*"', '""', match[2])
            for option in re.findall(r"(?<=\s)(--?[a-z][a-z-]*)", quoted):
                if option not in options[command] and option not in ("--help", "--version"):
                    failures += 1
                    print(f"{name}: flexura {command} has no option {option}")
        for match in LINK.finditer(re.sub(r"`[^`\n]*`", "", re.sub(r"^```.*?^```", "", text, flags=re.M | re.S))):
            target = match[1]
            if "://" in target or target.startswith("mailto:") or target in MADE:
                continue
            links += 1
            page = (root / name).parent.joinpath(target) if target else root / name
            if not page.exists():
                failures += 1
                print(f"{name}: link to {target}, which is not there")
            elif match[2] and page.suffix == ".md" and match[2] not in places(page):
                failures += 1
                print(f"{name}: link to {target}#{match[2]}, where there is no such heading")
    cases = (root / "cases/README.md").read_text()
    for run in sorted(root.glob("cases/*/run")):
        if not re.search(rf"^\| \[?{run.parent.name}\b", cases, re.M):
            failures += 1
            print(f"cases/README.md: no row for the case {run.parent.name}: what it asks, what to look at, against what")
        readme = run.parent / "README.md"
        text = readme.read_text() if readme.is_file() else ""
        lacking = [what for what, pattern in (("a question in its first paragraph", r"\A# [^\n]+\n\n[^\n#]+"),
                                              ("a picture", r"!\[[^\]]+\]\([^)]+\.(png|svg)\)"),
                                              ("what to look at", r"\*\*What to look at\.\*\*"),
                                              ("what it costs", r"\*\*What it costs\.\*\* [A-Z][a-z]"))
                   if not re.search(pattern, text)]
        if lacking:
            failures += 1
            print(f"cases/{run.parent.name}/README.md: lacks {', '.join(lacking)}")
    # One version: of the programs, of the Python package, and the newest of the changelog.
    versions = {name: re.search(pattern, (root / name).read_text(), re.M)[1] for name, pattern in (
        ("CMakeLists.txt", r"^project\(flexura VERSION ([\d.]+)"), ("mbs/python/pyproject.toml", r'^version = "([\d.]+)"'),
        ("mbs/python/flexura/__init__.py", r'^__version__ = "([\d.]+)"'), ("CHANGELOG.md", r"^## \[(\d[\d.]*)\]"))}
    if len(set(versions.values())) != 1:
        failures += 1
        print(f"versions differ: {versions}")
    for error in site.errors:
        failures += 1
        print(f"{error}; name it with as much of its folder as tells it apart")
    print(f"{len(listed)} pages, {calls} commands, {links} links")
    return 1 if failures or calls < 20 else 0


if __name__ == "__main__":
    sys.exit(main())
