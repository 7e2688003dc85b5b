# Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
"""Plots with matplotlib (an optional dependency, imported only here)."""

from typing import Any, List, Sequence, Union

import numpy as np
import numpy.typing as npt

from .results import Results, Run
from .superelement import Superelement

Names = Union[str, Sequence[str], None]


def _chosen(results: Results, runs: Names) -> List[Run]:
    """The named runs (one name or several), or all."""
    if runs is None:
        return list(results.values())
    return [results[name] for name in ([runs] if isinstance(runs, str) else runs)]


def quantities(results: Results, *quantity: Union[str, Sequence[str]], runs: Names = None, axes: Any = None) -> Any:
    """Quantities over time (names, or lists of them), all runs (or those named) in one picture; names share an axis.

    Returns the matplotlib axes.
    """
    import matplotlib.pyplot as plt

    names = [name for given in quantity for name in ([given] if isinstance(given, str) else given)]
    axes = axes or plt.subplots(figsize=(8, 3.6), layout="constrained")[1]
    chosen = _chosen(results, runs)
    for i, run in enumerate(chosen):
        for j, name in enumerate(names):
            if name in run:
                label = run.name if len(names) == 1 else f"{run.name}: {name}"
                axes.plot(run.time, run[name], color=f"C{i}", linestyle=["-", "--", ":", "-."][j % 4], label=label)
    first = next((run[name] for run in chosen for name in names if name in run), None)
    if first is None:
        if len(names) == 1 and chosen:
            chosen[0][names[0]]  # its refusal says what is near
        raise KeyError(f"no run stored {' or '.join(names)}")
    axes.set_xlabel("time [s]")
    axes.set_ylabel(first.label if len(names) == 1 else f"[{first.unit}]")
    axes.grid(alpha=0.3)
    axes.legend()
    return axes


def spectra(results: Results, name: str, runs: Names = None, axes: Any = None) -> Any:
    """Amplitude spectra of a quantity on a logarithmic axis.  Returns the matplotlib axes."""
    import matplotlib.pyplot as plt

    axes = axes or plt.subplots(figsize=(8, 3.6), layout="constrained")[1]
    for run in _chosen(results, runs):
        frequency, amplitude = run.spectrum(name)
        axes.semilogy(frequency[1:], amplitude[1:], label=run.name)
    axes.set_xlabel("frequency [Hz]")
    axes.set_ylabel(amplitude.label)
    axes.grid(alpha=0.3)
    axes.legend()
    return axes


def mode_shape(superelement: Superelement, u_se: npt.ArrayLike, amplitude: float = 0.08, stress: bool = False,
               axes: Any = None) -> Any:
    """The surface deformed by superelement coordinates, its largest displacement drawn as a part of its size.

    Coloured by displacement, or by the von Mises stress where the superelement has stress modes at all vertices.
    Returns the matplotlib axes.
    """
    import matplotlib.pyplot as plt
    from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

    vertices, u = np.asarray(superelement.vertices), np.asarray(superelement.displacement(u_se))
    size = np.linalg.norm(np.ptp(vertices, axis=0))
    length = np.linalg.norm(u, axis=1)
    drawn = vertices + (amplitude * size / length.max() if length.max() > 0 else 0.0) * u
    axes = axes or plt.figure(figsize=(8, 5), layout="constrained").add_subplot(projection="3d")
    triangles = np.asarray(superelement.triangles)
    if len(triangles):
        field = length / length.max() if length.max() > 0 else length
        if stress:
            values = np.asarray(superelement.von_mises(superelement.stress(u_se)))
            field = np.full(len(vertices), np.nan)
            field[np.asarray(superelement.stress_vertices)] = values / values.max()
        faces = Poly3DCollection(drawn[triangles])
        faces.set_facecolor(plt.get_cmap("viridis")(np.nanmean(field[triangles], axis=1)))
        axes.add_collection3d(faces)
    edges = np.asarray(superelement.edges)
    if len(edges):
        axes.add_collection3d(Line3DCollection(drawn[edges], colors="k", linewidths=0.5))
    low, high = drawn.min(axis=0), drawn.max(axis=0)
    middle, half = (low + high) / 2, max((high - low).max() / 2, 1e-12)
    axes.set(xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half, middle[1] + half),
             zlim=(middle[2] - half, middle[2] + half), xlabel="x [m]", ylabel="y [m]", zlabel="z [m]")
    axes.set_box_aspect((1, 1, 1))
    return axes
