#!/usr/bin/python3
# Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
"""consoles.py ROOT PROGRAMS PAGE...: does what the pages say and compares with what they show.

In a block fenced as ```console a line "$ COMMAND" is run, in the page's own folder of a copy of docs/ and cases/;
commands of a page follow one another as if typed in one shell.  The lines below a command have to come out, in this order:
"..." in a line of its own passes over any lines, "..." within a line over any text, spaces count as one, numbers agree to
1 %.  A command ends with 0 unless the page shows "error: ...", and then it does not.  Blocks fenced otherwise are not run.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?"
RELATIVE = 0.01  # of numbers: other libraries and other meshes than on the writer's machine


def blocks(text):
    """Pairs of a command and the lines shown below it."""
    inside, found = False, []
    for line in text.split("\n"):
        if line.startswith("```"):
            inside = line.startswith("```console") and not inside
        elif inside and line.startswith("$ "):
            found.append([line[2:], []])
        elif inside and found and found[-1][0].endswith("\\") and not found[-1][1]:
            found[-1][0] += "\n" + line
        elif inside and found:
            found[-1][1].append(line)
    return found


def same_word(shown, told):
    """Whether two words are the same but for numbers in them; "..." in a word is any text."""
    if "..." in shown:
        return re.fullmatch(re.escape(shown).replace(re.escape("..."), ".*"), told) is not None
    wanted, found = re.split(f"({NUMBER})", shown), re.split(f"({NUMBER})", told)
    if len(wanted) != len(found):
        return False
    texts = wanted[::2] == found[::2]
    return texts and all(abs(float(a) - float(b)) <= RELATIVE * abs(float(a)) for a, b in zip(wanted[1::2], found[1::2]))


def same(shown, told):
    """Whether a line is the shown one, both as lists of words."""
    if not shown or not told:
        return not told and all(word == "..." for word in shown)
    if shown[0] == "...":
        return any(same(shown[1:], told[i:]) for i in range(len(told) + 1))
    return same_word(shown[0], told[0]) and same(shown[1:], told[1:])


def missing(shown, told):
    """The first shown line that did not come out in its place, or None."""
    at, may_skip = 0, True
    for line in shown:
        if not line.strip():
            continue
        if line.strip() == "...":
            may_skip = True
            continue
        found = next((i for i in range(at, len(told)) if same(line.split(), told[i].split())), None)
        if found is None or (not may_skip and any(t.strip() for t in told[at:found])):
            return line
        at, may_skip = found + 1, False
    return None


def run_page(page, folder, environment):
    failures = 0
    where = folder / page.parent
    for command, shown in blocks((folder / page).read_text()):
        done = subprocess.run(["bash", "-c", command + "\ncode=$?; pwd >&9; exit $code"], cwd=where, env=environment,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, pass_fds=(9,))
        os.lseek(9, 0, os.SEEK_SET)
        where = os.read(9, 4096).decode().strip() or where  # a "cd" holds for what follows
        os.ftruncate(9, 0)
        os.lseek(9, 0, os.SEEK_SET)
        line = missing(shown, done.stdout.split("\n"))
        refused = any(text.startswith("error:") for text in shown)
        if line is not None or (done.returncode != 0) != refused:
            failures += 1
            print(f"{page}: {command}\n  " + (f"shown but not told: {line}" if line is not None else
                                              f"ended with {done.returncode}") + f"\n  told:\n{done.stdout}")
    return failures


def main():
    root, programs = (pathlib.Path(p).resolve() for p in sys.argv[1:3])
    environment = {**os.environ, "PATH": f"{programs}:{os.environ['PATH']}", "PYTHONPATH": str(root / "mbs/python"),
                   "MPLBACKEND": "Agg"}
    environment.pop("COLUMNS", None)  # tables of 80 columns, sentences on one line
    failures = 0
    with tempfile.TemporaryDirectory() as scratch, tempfile.TemporaryFile() as place:
        os.dup2(place.fileno(), 9)
        for page in sys.argv[3:]:
            folder = pathlib.Path(scratch) / "docs"
            shutil.rmtree(folder, ignore_errors=True)
            for part in ("docs", "cases"):
                shutil.copytree(root / part, pathlib.Path(scratch) / part, dirs_exist_ok=True,
                                ignore=shutil.ignore_patterns("*.h5", "*.html", "study.cache"))
            failures += run_page(pathlib.Path(page), folder, environment)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
