# Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
"""What a study measured: its choices, their errors and times, and the results of each."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Dict, Iterator, List, Optional

from .arrays import FilePath
from .programs import Settings, run, settings_as_options
from .results import Results, read_results


@dataclass(repr=False)
class Choice:
    """One choice of a study's ladder.  Errors are relative, those of the quantities by their names; None where it failed."""

    name: str
    settings: List[str]  # "key=value", of the mechanism and of parts
    error: Optional[float]  # the largest of `errors`, against the reference
    errors: Dict[str, Optional[float]]
    estimated_error: Optional[float]  # what the run itself said
    wall_time: float  # [s], median of the whole program
    cpu_time: float  # [s]
    steps: int
    on_front: bool  # nothing else is better in both time and error
    failure: str  # why it did not run through; empty where it did
    file: Path  # of the results, in the study's cache
    # Of designs ([want] least, greatest): the quantities by their names, SI, and how far they are known (None: unknown).
    values: Dict[str, Optional[float]] = field(default_factory=dict)
    uncertainty: Dict[str, Optional[float]] = field(default_factory=dict)

    def results(self) -> Results:
        """The choice's results; OSError where the study's cache has been cleared."""
        return read_results(self.file)

    def __repr__(self) -> str:
        if self.values and not self.failure:
            return f"<choice {self.name!r}: {', '.join(f'{label} {value:.4g}' for label, value in self.values.items())}>"
        told = self.failure or ("unknown error" if self.error is None else f"error {100 * self.error:.3g} %")
        return f"<choice {self.name!r}: {told}, {self.wall_time:.3g} s>"


@dataclass(repr=False, eq=False)
class Study(Mapping[str, Choice]):
    """A finished study, a mapping from the names of its choices to them: study["tolerance 1e-5"].error."""

    name: str
    quantities: List[Dict[str, Any]]  # label, of (the quantity of the results), norm, uncertainty of the reference
    choices: Dict[str, Choice]
    answers: List[str]  # in words, to what [want] asks
    notes: List[str]

    def __getitem__(self, choice: str) -> Choice:
        try:
            return self.choices[choice]
        except KeyError:
            raise KeyError(f"no choice is called {choice!r}; there are {', '.join(self.choices)}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self.choices)

    def __len__(self) -> int:
        return len(self.choices)

    @property
    def front(self) -> List[Choice]:
        """The choices that nothing else beats in both time and error, cheapest first."""
        return sorted((c for c in self.choices.values() if c.on_front), key=lambda c: c.wall_time)

    def __repr__(self) -> str:
        return f"<study {self.name!r}: {len(self)} choices, {', '.join(self.choices)}>"


def _part_settings(parts: Optional[Dict[str, List[str]]]) -> List[str]:
    """As a study file has them: "part.NAME.key=value"."""
    return [f"part.{name}.{pair}" for name, pairs in (parts or {}).items() for pair in pairs]


def read_study(path: FilePath) -> Study:
    """Reads STEM.json, which `flexura study` writes."""
    told = json.loads(Path(path).read_text(encoding="utf-8"))
    if not isinstance(told, dict) or "choices" not in told:
        raise ValueError(f"{path}: holds no study; give the .json that flexura study wrote")
    labels = [q["label"] for q in told["quantities"]]
    choices = {
        c["name"]: Choice(c["name"], c["set"] + _part_settings(c["part_set"]), c.get("error"), dict(zip(labels, (e[0] for e in c.get("errors") or []))),
                          c.get("estimated_error"), c.get("median_wall", 0.0), c.get("median_cpu", 0.0), c["steps"],
                          c.get("on_front", False), c["failure"], Path(c["results"]), dict(zip(labels, c.get("values") or [])),
                          dict(zip(labels, c.get("uncertainty") or [])))
        for c in told["choices"]}
    return Study(told["name"], told["quantities"], choices, told["answers"], told["notes"])


def study(file: FilePath, output: Optional[FilePath] = None, settings: Settings = None) -> Study:
    """Runs a study file (what its cache has is not run again) and reads what it measured.

    output: the stem of the tables and pictures, by default the study file's name.  settings: keys of the study file to change.
    """
    stem = Path(output) if output else Path(file).with_suffix("")
    run(["study", file, "-q", "-o", stem, *settings_as_options(settings)])
    return read_study(stem.with_name(stem.name + ".json"))
