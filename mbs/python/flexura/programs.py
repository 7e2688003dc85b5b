# Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
"""The programs, run from Python.

They are looked for in the folder that the environment variable FLEXURA_BIN names, then on the PATH.  A refusal or
failure is raised as FlexuraError with the program's own sentence.
"""

import html
import json
import os
import shutil
import subprocess
import webbrowser
from pathlib import Path
from typing import Any, Dict, Iterable, Iterator, Mapping, Optional, Sequence, Union, cast

from .arrays import FilePath
from .results import Results, read_results
from .superelement import Superelement, read_superelement

Settings = Optional[Mapping[str, Any]]


class FlexuraError(RuntimeError):
    """A program refused its input (code 2) or failed (code 1)."""

    def __init__(self, message: str, code: int) -> None:
        super().__init__(message)
        self.code = code


def program(name: str = "flexura") -> str:
    """The path of a program of Flexura."""
    folder = os.environ.get("FLEXURA_BIN")
    found = shutil.which(name, path=folder) if folder else shutil.which(name)
    if not found:
        where = f"the folder FLEXURA_BIN names, {folder}" if folder else "the PATH; FLEXURA_BIN may name its folder"
        raise FlexuraError(f"the program {name} is not in {where}", 1)
    return found


def run(arguments: Iterable[object], name: str = "flexura") -> str:
    """Runs a program and returns what it printed."""
    done = subprocess.run([program(name), *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if done.returncode != 0:
        lines = [line for line in done.stderr.splitlines() if line.startswith("error: ")]
        raise FlexuraError(lines[0][len("error: "):] if lines else done.stderr.strip() or f"{name} failed", done.returncode)
    return done.stdout


def settings_as_options(settings: Settings) -> Iterator[str]:
    """--set KEY=VALUE for each."""
    for key, value in (settings or {}).items():
        if isinstance(value, Mapping):  # {"solver": {"tolerance": 1e-8}} as {"solver.tolerance": 1e-8}
            yield from settings_as_options({f"{key}.{inner}": one for inner, one in value.items()})
            continue
        if hasattr(value, "tolist"):  # numpy's arrays and numbers
            value = value.tolist()
        yield from ("--set", f"{key}={value if isinstance(value, str) else json.dumps(value)}")


def _file(path: FilePath, what: str) -> Path:
    if isinstance(path, Mapping):
        raise TypeError(f"a {what} is a file; flexura.write_toml(path, dictionary) writes one and returns its path")
    return Path(path)


def reduce(part: FilePath, output: Optional[FilePath] = None, settings: Settings = None) -> Superelement:
    """Makes a superelement of a part file (or beam model) and reads it.

    settings: keys of the part file to change, {"modes.count": 30}.  The default output stands beside the part file.
    """
    part = _file(part, "part")
    output = Path(output) if output else part.with_suffix(".se.h5")
    run([part, "-q", "-o", output, *settings_as_options(settings)], "flexura-reduce")
    return read_superelement(output)


def simulate(mechanism: FilePath, output: Optional[FilePath] = None, settings: Settings = None,
             runs: Union[str, Sequence[str], None] = None) -> Results:
    """Simulates a mechanism file and reads the results.

    settings: keys of the mechanism file to change, {"solver.end_time": "1 s"}; runs: names, or one name; default all of the file.
    """
    runs = [runs] if isinstance(runs, str) else runs or []
    mechanism = _file(mechanism, "mechanism")
    output = Path(output) if output else mechanism.with_suffix(".h5")
    chosen = [word for name in runs for word in ("--run", name)]
    run(["simulate", mechanism, "-q", "-o", output, *chosen, *settings_as_options(settings)])
    return read_results(output)


def modes(superelement: FilePath, *options: str) -> Dict[str, Any]:
    """What `flexura modes FILE --json OPTIONS` prints, as a dictionary."""
    return cast(Dict[str, Any], json.loads(run(["modes", superelement, "--json", *options])))


def eigen(mechanism: FilePath, *options: str, settings: Settings = None) -> Dict[str, Any]:
    """What `flexura eigen FILE --json OPTIONS` prints, as a dictionary: frequencies, damping and shapes of each run.

    flexura.eigen("rotor.toml", "--fixed-axes", settings={"parameters.speed": 100})["runs"][0]["modes"][0]["frequency_hz"]
    """
    return _json("eigen", mechanism, options, settings)


def statics(mechanism: FilePath, *options: str, settings: Settings = None) -> Dict[str, Any]:
    """What `flexura statics FILE --json OPTIONS` prints: the quantities of each run at its equilibrium."""
    return _json("statics", mechanism, options, settings)


def _json(command: str, mechanism: FilePath, options: Sequence[str], settings: Settings) -> Dict[str, Any]:
    arguments = [command, _file(mechanism, "mechanism"), "--json", *options, *settings_as_options(settings)]
    return cast(Dict[str, Any], json.loads(run(arguments)))


class Page:
    """A page for the browser (mbs/view/README.md). A notebook shows it in place."""

    def __init__(self, path: FilePath) -> None:
        self.path = Path(path)

    def open(self) -> bool:
        """In the system's browser."""
        return webbrowser.open(self.path.resolve().as_uri())

    def _repr_html_(self) -> str:
        text = html.escape(self.path.read_text(encoding="utf-8"))
        return f'<iframe title="{html.escape(self.path.stem)}" style="width:100%;height:640px;border:0" srcdoc="{text}"></iframe>'

    def __repr__(self) -> str:
        return f"<page {str(self.path)!r}>"


def page(file: FilePath, output: Optional[FilePath] = None, *options: str) -> Page:
    """The page of a superelement (its modes) or of results (the motion).

    options: of `flexura modes` or `flexura view`.  The default output stands beside the file.
    """
    file = Path(file)
    is_part = file.name.endswith(".se.h5")
    output = Path(output) if output else file.with_suffix("").with_suffix(".html") if is_part else file.with_suffix(".html")
    run(["modes", file, "-q", "--html", output, *options] if is_part else ["view", file, "-q", "-o", output, *options])
    return Page(output)
