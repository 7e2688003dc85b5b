#!/usr/bin/python3
# Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
"""shell_blocks.py ROOT PROGRAMS: runs every command of flexura that the pages show without its answer.

Those are the lines of blocks fenced as ```sh and of indented blocks, in README.md, docs/ and cases/*/README.md, in the order of
their page, in a folder where the files that they name stand ("part.step", "engine.toml": FILES); all have to end with 0.  (Blocks
fenced as ```console are run and compared by consoles.py; what builds the project or this site is not run from within its test.)
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

# What the pages call the reader's own files.
FILES = {"part.step": "cases/steam_engine/conrod.step", "conrod.step": "cases/steam_engine/conrod.step",
         "conrod.toml": "cases/steam_engine/conrod.toml", "engine.toml": "cases/steam_engine/engine.toml",
         "engine.step": "cases/assembly/engine.step", "bracket.toml": "docs/tutorials/bracket/bracket.toml",
         "bracket.step": "docs/tutorials/bracket/bracket.step", "robot.urdf": "tests/import/data/arm.urdf"}
COARSE = ["--set", 'mesh.size="20 mm"', "--set", "modes.count=4"]


def commands(text):
    """Lines that begin with flexura, of ```sh blocks and of indented ones, without their comments."""
    fence = None
    for line in text.replace("\\\n", " ").split("\n"):
        mark = re.match(r"\s*```(\w*)", line)
        if mark:
            fence = None if fence is not None else mark[1]
        elif (fence == "sh" and line.startswith("flexura")) or (fence is None and line.startswith("    flexura ")):
            yield re.sub(r"\s{2,}#.*$", "", line.strip())


def prepare(root, folder, run):
    for name, source in FILES.items():
        if (root / source).is_file():
            shutil.copyfile(root / source, folder / name)
    (folder / "part.toml").write_text((folder / "conrod.toml").read_text().replace("conrod.step", "part.step"))
    run(["flexura", "reduce", "part.toml", "-q", *COARSE])
    run(["flexura", "reduce", "conrod.toml", "-q", *COARSE])
    run(["flexura", "new", "mechanism", "-q"])
    (folder / "PART.toml").write_text((folder / "part.toml").read_text())


def main():
    root, programs = (pathlib.Path(p).resolve() for p in sys.argv[1:3])
    environment = {**os.environ, "PATH": f"{programs}:{os.environ['PATH']}", "COLUMNS": "80"}
    pages = [root / "README.md", *sorted(root.glob("docs/**/*.md")), *sorted(root.glob("cases/*/README.md"))]
    failures = count = 0
    with tempfile.TemporaryDirectory() as scratch:
        start = pathlib.Path(scratch) / "start"
        start.mkdir()
        run = lambda words: subprocess.run(words, cwd=start, env=environment, check=True, stdout=subprocess.DEVNULL)
        prepare(root, start, run)
        for page in pages:
            shown = list(commands(page.read_text()))
            if not shown:
                continue
            folder = pathlib.Path(scratch) / f"page{count}"
            shutil.copytree(start, folder)
            for command in shown:
                count += 1
                # Quick is enough: what is asked is whether the command is taken and does what it says.
                done = subprocess.run(["bash", "-c", "set -o pipefail; " + command], cwd=folder, env=environment, text=True,
                                      stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
                if done.returncode != 0:
                    failures += 1
                    print(f"{page.relative_to(root)}: {command}\n  ended with {done.returncode}:\n{done.stdout[-1500:]}")
    print(f"{count} commands run, {failures} failed")
    return 1 if failures or count < 20 else 0


if __name__ == "__main__":
    sys.exit(main())
