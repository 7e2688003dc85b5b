# Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
"""Runs a command on hostile files in a folder of their own and tells what it must not have done.

The judge knows nothing of the programs: a case is its files, its command line and the outputs that this declares.
"""

import os
import re
import resource
import shutil
import subprocess
import tempfile
import unicodedata
from dataclasses import dataclass, field
from pathlib import Path

BIN = Path(os.environ["FLEXURA_BIN"])
TEXTS = {".toml", ".html", ".md", ".csv", ".json", ".m", ".mtx", ".svg", ".inp", ".bdf", ".dat", ".sid", ".xml", ".urdf",
         ".vtp", ".pvd", ".gltf", ".msh", ".section"}
# What a text of texts.py would be where it is written as it stands: markup, a command, a formula, by the ending of the output.
FORGED = {".html": rb"<img src=x|<script>(x\(\)|touch)", ".svg": rb"<img src=x|<script>(x\(\)|touch)", ".md": rb"(?<!\\)<(img src=x|script)|[^\\]\]\(http://x\)",
          ".m": rb"(?m)^system", ".csv": rb"(?m)(^|,)\"?[=@]", ".bdf": rb"(?m)^(\*NODE|system)", ".sid": rb"(?m)^(\*NODE|system)", ".mtx": rb"(?m)^(\*NODE|system)"}
SECONDS, BYTES = 60, 4 << 30  # of a case that takes a tenth of a second, of programs that take a tenth of that
RUNS_ALONE = [".gmshrc", ".gmsh-options", ".gmsh", "gmshrc", ".octaverc", ".bashrc", ".profile", "startup.m", "sitecustomize.py"]


@dataclass
class Case:
    """Files by their paths in the case's folder, the words of the command, and globs and folders of what it may write when it ends with 0."""

    words: list
    files: dict = field(default_factory=dict)
    outputs: list = field(default_factory=list)
    name: str = ""


def is_harmful(letter, lines=True):
    """Whether a terminal or a reader of a text obeys it instead of showing it."""
    if letter in "\n\t" and lines:
        return False
    kind, direction = unicodedata.category(letter), unicodedata.bidirectional(letter)
    turns = direction in {"LRE", "RLE", "LRO", "RLO", "PDF", "LRI", "RLI", "FSI", "PDI"} or letter in "\u200e\u200f\u061c"
    return kind in {"Cc", "Zl", "Zp"} or turns or letter == "\ufeff" or 0xE0000 <= ord(letter) <= 0xE007F


def harm_in(data):
    """The first harmful character of bytes that are to be a text; None where there is none."""
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError as error:
        return f"no UTF-8: {data[error.start:error.start + 4]!r}"
    found = next((letter for letter in text if is_harmful(letter)), None)
    return None if found is None else f"U+{ord(found):04X}"


def contents(folder):
    found = {}
    for path in sorted(folder.rglob("*")):
        name = str(path.relative_to(folder))
        found[name] = os.readlink(path) if path.is_symlink() else path.read_bytes() if path.is_file() else None
    return found


def limits():
    resource.setrlimit(resource.RLIMIT_AS, (BYTES, BYTES))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


class Folder:
    """Of one case: home, temporary folder and working folder are in it, with what programs run without being asked."""

    def __init__(self):
        self.path = Path(tempfile.mkdtemp(prefix="flexura-hostile-", dir="/dev/shm" if Path("/dev/shm").is_dir() else None))
        for name in ("home", "tmp", "in", "out"):
            (self.path / name).mkdir()

    def write(self, files):
        for name, data in files.items():
            path = self.path / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data if isinstance(data, bytes) else data.encode("utf-8", "surrogateescape"))

    def run(self, words):
        environment = {"PATH": os.environ["PATH"], "HOME": str(self.path / "home"), "TMPDIR": str(self.path / "tmp"),
                       "OPENBLAS_NUM_THREADS": "1", "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
                       "LC_ALL": "C.UTF-8"}
        return subprocess.run([BIN / words[0], *words[1:]], cwd=self.path / "in", env=environment, stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=SECONDS, preexec_fn=limits, check=False)

    def remove(self):
        shutil.rmtree(self.path, ignore_errors=True)


def verdicts(case, folder):
    """All that is wrong with what the command did."""
    folder.write(case.files)
    before = contents(folder.path)
    try:
        done = folder.run(case.words)
    except subprocess.TimeoutExpired:
        return [f"did not end in {SECONDS} s"]
    after = contents(folder.path)
    wrong = []
    if done.returncode not in (0, 1, 2):
        wrong.append(f"ended with {done.returncode}")
    if "mistake of the program" in done.stderr.decode("utf-8", "replace"):
        wrong.append("calls itself mistaken")
    for stream in ("stdout", "stderr"):
        if harm := harm_in(getattr(done, stream)):
            wrong.append(f"{stream} holds {harm}")
    if done.returncode == 2 and done.stderr.count(b"\nerror: ") + done.stderr.startswith(b"error: ") != 1:
        wrong.append("a refusal is not one sentence")
    for name in sorted({*before, *after}):
        if before.get(name, b"-") == after.get(name, b"-"):
            continue
        path = Path(name)
        if path.name.startswith("CANARY"):
            wrong.append(f"ran: {name}")
        elif not (done.returncode == 0 and any(path.match(glob) or Path(glob) in path.parents for glob in case.outputs)):
            wrong.append(f"{'changed' if name in before else 'made'}: {name}")
        elif path.suffix in TEXTS and after[name] and (harm := harm_in(after[name])):
            wrong.append(f"{name} holds {harm}")
        elif after.get(name) and (forged := re.search(FORGED.get(path.suffix, rb"(?!)"), after[name])):
            wrong.append(f"{name} holds {forged[0]!r}")
    if wrong:
        wrong.append(f"exit {done.returncode}: {(done.stderr or done.stdout)[-300:]!r}")
    return wrong
