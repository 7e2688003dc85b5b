# Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
"""What the pages of the shipped cases must show, computed from the cases' files by numpy and h5py:

    expected.py FOLDER      writes FOLDER/CASE/PAGE.expected.json beside each page FOLDER/CASE/PAGE.html

Natural modes come from K_se and M_se by the package's own eigenproblem, places of bodies and vertices from poses, modal
coordinates and shapes: nothing here has seen the programs that write pages.
"""

import json
import sys
from pathlib import Path

import flexura
import numpy as np

# Pages that are not called like the file they were made of, by case and page.
SOURCES = {"andrews/andrews": "andrews_1e-10.h5", "assembly/engine": "flexible.h5", "oil_whirl/oil_whirl": "whirl_1.07.h5",
           "rattle/rattle": "rattle_2.h5", "swinging_cable/swinging_cable": "cable_16.h5"}
MOST_ROWS = 4000


def modes_of(file):
    se = flexura.read_superelement(file)
    vertices = np.asarray(se.vertices)
    sets = {}
    for name, held in [("Free body", []), ("Interfaces held", [i.name for i in se.interfaces])]:
        if held and not se.n_q:
            continue
        modes = se.natural_modes(held=held, count=30)
        frequency = np.asarray(modes.frequency)
        shown = []
        for j, f in enumerate(frequency[:-1]):
            # Shapes of modes that lie closer together (round shafts have pairs) are a matter of choice.
            if min(abs(frequency[k] / f - 1) for k in range(len(frequency)) if k != j) < 0.01:
                continue
            u = np.asarray(se.displacement(modes.shapes[:, j]))
            length = np.linalg.norm(u, axis=1)
            picks = [int(np.argmax(length)), int(np.argmax(np.abs(u[:, 2]))), len(vertices) // 2]
            shown.append({"elastic": j, "vertices": picks, "u": (u[picks] / length.max()).tolist()})
            if len(shown) == 3:
                break
        sets[name] = {"frequencies": frequency.tolist(), "shapes": shown}
    return {"page": "modes", "size": float(np.linalg.norm(np.ptp(vertices, axis=0))), "vertices": vertices.shape[0],
            "positions": {str(v): vertices[v].tolist() for s in sets.values() for m in s["shapes"] for v in m["vertices"]},
            "sets": sets}


def turned(q, p):
    """R p for quaternions w x y z, one a row."""
    w, v = q[:, :1], q[:, 1:]
    return p + 2 * np.cross(v, np.cross(v, p) + w * p)


def motion_of(file):
    results = flexura.read_results(file)
    pictures = {b["name"]: file.parent / b["superelement"] for b in results.bodies if b.get("superelement")}
    runs = {}
    for name, run in results.runs.items():
        rows = np.arange(len(run.time))[:MOST_ROWS]
        quantities = list(run)[:: max(1, len(run) // 12)]
        entry = {"time": np.asarray(run.time)[rows].tolist(),
                 "quantities": {q: {"unit": run[q].unit, "values": np.asarray(run[q])[rows].tolist()} for q in quantities},
                 "poses": {}, "vertices": {}, "sections": {}}
        some = rows[:: max(1, len(rows) // 40)]
        entry["rows"] = some.tolist()
        for body in run.bodies.values():
            pose = np.hstack([np.asarray(body.position), np.asarray(body.quaternion)])
            entry["poses"][body.name] = pose[some].tolist()
            if body.modal is None or body.name not in pictures:
                continue
            se = flexura.read_superelement(pictures[body.name])
            u_se = np.asarray(body.superelement_coordinates())[some]
            u = np.einsum("tk,kv->tv", u_se, np.asarray(se.surface_shapes)).reshape(len(some), -1, 3)
            v = int(np.argmax(np.linalg.norm(u, axis=2).max(axis=0)))
            p, q = pose[some, :3], pose[some, 3:]
            entry["vertices"][body.name] = {
                "vertex": v, "rest": np.asarray(se.vertices)[v].tolist(), "u": u[:, v].tolist(),
                # drawn 1 and 20 times as deformed
                "at": {str(m): (p + turned(q, np.asarray(se.vertices)[v] + m * u[:, v])).tolist() for m in (1, 20)}}
            if se.section_forces is not None:
                forces = np.asarray(se.section_forces.at(u_se))
                entry["sections"][body.name] = forces.tolist()
        runs[name] = entry
    return {"page": "motion", "runs": runs}


def main(folder):
    for page in sorted(Path(folder).glob("*/*.html")):
        superelement = page.with_suffix(".se.h5")
        results = page.parent / SOURCES.get(f"{page.parent.name}/{page.stem}", page.stem + ".h5")
        if superelement.exists():
            told = modes_of(superelement)
        elif results.exists():
            told = motion_of(results)
        else:
            told = {"page": "report"}  # tables and plots of a program's own: opened only
        page.with_suffix(".expected.json").write_text(json.dumps(told), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1])
