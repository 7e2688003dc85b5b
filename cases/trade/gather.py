#!/usr/bin/env python3
"""The trade of all scenes in one table: gather.py FOLDER prints what the studies' JSON files there say of the choices."""
import json
import sys
from pathlib import Path
from statistics import median

ratios, effects, met, wanted = [], [], 0, 0
print("| scene | wanted | true error | met | estimated over true | cost [s] | cheapest rung that meets it | ratio |")
print("|---|---|---|---|---|---|---|---|")
for file in sorted(Path(sys.argv[1]).glob("*.json")):
    study = json.loads(file.read_text())
    rungs = [c for c in study["choices"] if not c["wanted"] and c["complete"] and c["error"] is not None]
    for choice in (c for c in study["choices"] if c["wanted"]):
        wanted += 1
        if not choice["complete"]:
            print(f"| {study['name']} | {100 * choice['wanted']:g} % | failed: {choice['failure'][:60]} | **no** | | | | |")
            continue
        is_met = choice["error"] is not None and choice["error"] <= choice["wanted"]
        met += is_met
        fits = [c for c in rungs if c["error"] <= choice["wanted"]]
        best = min(fits, key=lambda c: c["median_cpu"], default=None)
        ratio = choice["median_cpu"] / best["median_cpu"] if best else None
        if ratio:
            ratios.append(ratio)
        # Of what runs of one study differ in: the mesh, which all share, is left out.
        told = choice["estimated_error"]
        effect = None
        if told and choice["error"] and choice["error"] > 3 * study["uncertainty"]:
            effect = told / choice["error"]
            effects.append(effect)
        print(f"| {study['name']} | {100 * choice['wanted']:g} % | {100 * choice['error']:.3g} % | {'yes' if is_met else '**no**'} | "
              f"{'' if effect is None else format(effect, '.2g')} | {choice['median_cpu']:.3g} | "
              f"{best['name'] if best else 'none'} | {format(ratio, '.3g') if ratio else ''} |")
print(f"\nMet in {met} of {wanted}.", end="")
if ratios:
    print(f" Cost over the cheapest rung that meets it: median {median(ratios):.2g}, at most {max(ratios):.3g}.", end="")
if effects:
    inside = sum(0.5 <= e <= 3 for e in effects)
    print(f" Estimate over true error within 0.5 to 3 in {inside} of {len(effects)} that the reference can tell.", end="")
print()
