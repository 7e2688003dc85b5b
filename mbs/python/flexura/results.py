# Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
"""Results files of `flexura simulate`: runs with quantities, poses and modal coordinates over time."""

import json
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any, Dict, Iterator, List, Mapping, Optional, Tuple

import h5py
import numpy as np
import numpy.typing as npt

from .arrays import Array, FilePath, attribute, open_file, read_array, read_text


@dataclass(repr=False)
class Body:
    """The motion of a body in a run."""

    name: str
    position: Array  # n_t x 3: Bo in W [m]
    quaternion: Array  # n_t x 4: w x y z of R_WB
    modal: Optional[Array]  # n_t x m modal coordinates, None for a rigid body
    basis: Optional[Array]  # n_se x m: u_se = basis @ s

    def __repr__(self) -> str:
        kind = "rigid" if self.modal is None else f"{self.modal.shape[1]} modes"
        return f"<body {self.name!r}: {len(self.position)} rows, {kind}>"

    def superelement_coordinates(self) -> Array:
        """u_se over time: n_t x n_se."""
        if self.modal is None:
            raise ValueError(f"body {self.name!r} is rigid in this run")
        return Array(np.asarray(self.modal) @ np.asarray(self.basis).T, "u_se")

    def place(self, point: npt.ArrayLike) -> Array:
        """Where a point of the undeformed body, given in its frame, is in the world: n_t x 3 [m]."""
        w, v = np.asarray(self.quaternion)[:, :1], np.asarray(self.quaternion)[:, 1:]
        p = np.broadcast_to(np.asarray(point, dtype=float), v.shape)
        # R p = p + 2 v x (v x p + w p)
        turned = p + 2 * np.cross(v, np.cross(v, p) + w * p)
        return Array(np.asarray(self.position) + turned, f"{self.name}: point", "m")


class Run(Mapping[str, Array]):
    """A run: a mapping from the names of its quantities to arrays, beside its time, bodies and summary."""

    def __init__(self, name: str, group: h5py.Group) -> None:
        header = json.loads(read_text(group["header"]))
        self.name = name
        self.complete = bool(attribute(group, "complete", 0))
        self.stopped_because = attribute(group, "stopped_because")
        self.summary = json.loads(read_text(group["summary"]) or "{}") if "summary" in group else {}
        self.time = read_array(group["time"], "time")
        self._quantities: Dict[str, Array] = {}
        for q in header["quantities"]:
            self._quantities[q["name"]] = Array(group["quantities"][q["name"]][()], q["name"], q["unit"], q["doc"])
        self.bodies: Dict[str, Body] = {}
        for b in header["bodies"]:
            one = group["bodies"][b["name"]]
            pose = one["pose"][()]
            flexible = "modal" in one
            self.bodies[b["name"]] = Body(
                b["name"], Array(pose[:, :3], f"{b['name']}: position", "m"), Array(pose[:, 3:], f"{b['name']}: quaternion"),
                read_array(one["modal"]) if flexible else None, read_array(one["basis"]) if flexible else None)
        self.state_names: List[str] = header.get("states", [])
        self.states = read_array(group["states"]) if "states" in group else None

    def __getitem__(self, name: str) -> Array:
        try:
            return self._quantities[name]
        except KeyError:
            if name in ("t", "time"):
                raise KeyError(f"{name!r} is no quantity; the times of the rows are run.time") from None
            near = [q for q in self._quantities if name.split(".")[-1] in q] or get_close_matches(name, self._quantities)
            hint = f"; there are {', '.join(near)}" if near else "; list(run) names them all"
            raise KeyError(f"run {self.name!r} stored no quantity {name!r}{hint}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._quantities)

    def __len__(self) -> int:
        return len(self._quantities)

    def spectrum(self, name: str) -> Tuple[Array, Array]:
        """One-sided amplitude spectrum of a quantity: frequency [Hz] and amplitude, mean taken off, Hann window."""
        t, y = np.asarray(self.time), np.asarray(self[name])
        even = np.linspace(t[0], t[-1], len(t))
        window = np.hanning(len(t))
        values = (np.interp(even, t, y) - y.mean()) * window
        amplitude = 2 * np.abs(np.fft.rfft(values)) / window.sum()
        return (Array(np.fft.rfftfreq(len(t), even[1] - even[0]), "frequency", "Hz"),
                Array(amplitude, f"amplitude of {name}", self[name].unit))

    def __repr__(self) -> str:
        end = f" to {self.time[-1]:.6g} s" if len(self.time) else ""
        return f"<run {self.name!r}: {len(self.time)} rows{end}, {len(self)} quantities>"


@dataclass(repr=False, eq=False)
class Results(Mapping[str, Run]):
    """A results file, a mapping from the names of its runs to them: results["flexible"]["main.speed"]."""

    name: str
    created_by: str
    source: str
    bodies: List[Dict[str, Any]]  # name, kind, superelement
    connections: List[Dict[str, Any]]  # joints, constraints and forces with the bodies they join
    markers: List[Dict[str, Any]]  # name, body_1, p_1 and rotation (w, x, y, z) in the undeformed body
    runs: Dict[str, Run]

    def __getitem__(self, run: str) -> Run:
        try:
            return self.runs[run]
        except KeyError:
            of = [name for name in self.runs if run in self.runs[name]]
            hint = f"; it is a quantity of a run: results[{of[0]!r}][{run!r}]" if of else ""
            raise KeyError(f"no run is called {run!r}; there are {', '.join(self.runs)}{hint}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self.runs)

    def __len__(self) -> int:
        return len(self.runs)

    def __repr__(self) -> str:
        return f"<results {self.name!r}: runs {', '.join(self.runs)}>"


def read_results(path: FilePath) -> Results:
    """Reads a results file whole; also a FILE.part of a run that goes on or was killed.

    Raises OSError for a damaged file and ValueError for one that holds no results or is of a later version.
    """
    with open_file(path, "results") as file:
        header = json.loads(read_text(file["header"]))
        groups = sorted(file["runs"].items(), key=lambda item: int(item[1].attrs.get("order", 0)))
        drawn = json.loads(read_text(file["connections"]) or "[]")
        return Results(header["name"], header["created_by"], read_text(file["model"]), header["bodies"],
                       [c for c in drawn if c.get("kind") != "marker"], [c for c in drawn if c.get("kind") == "marker"],
                       {name: Run(name, group) for name, group in groups})
