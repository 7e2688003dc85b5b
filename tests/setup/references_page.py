#!/usr/bin/python3
# Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
"""references_page.py TESTS PAGE COMMIT: runs the tests that compare with references (tests/reference.hpp) and writes the
page of the verification manual.  A comparison that fails stands first, in bold, and the exit code is 1."""
import datetime
import html
import math
import pathlib
import re
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree

# Which tests hold references, by program: the page says what to run.
PROGRAMS = {
    "beam_test": "SimpackShaft.*:BeamFrequencies.NafemsFV5DeepBeam",
    "ancf_tests": "AncfStatics.*Elastica:AncfStatics.HangingCable*:AncfStatics.Princeton*",
    "test_reduce": "Nafems.*:AbaqusBlock.CraigBampton*",
    "test_shells": "*RunTheObstacleCourse*:*CarryTheTwistedBeam*",
    "found_decks_shells_test": "DeckShells.Nafems*",
    "found_fedem_test": "Fedem.*",
    "flexible_test": "SimoVuQuocSpinUp.Peak*:RotatingCantilever.*:SimeonSliderCrank.Ends*",
    "case_tests": "Iftomm.*:Andrews.*:Wheelset.*:Bicycle.*:*AdamsJoint.*",
    "element_tests": "Hertz.*:Bearings.LargestLoad*:Bearings.ThrustOfA218*:JournalBearings.LoadIs*:Involute.Geometry*",
    "exact_beam_body_test": "ExactBeamPublished.*:ExactBeamStatics.*:PlanarSpaghetti.*",
    "moving_test": "MovingLoads.ForceCrosses*",
    "surfaces_test": "HertzContact.*:BentPlane.*",
}


def plot(rows, sources):
    """A line for each source: how much of its tolerance each comparison takes.  Greys that both themes show."""
    left, right, top, step, low = 390, 30, 34, 19, -8
    width, height = 960, top + step * len(sources) + 30
    x = lambda share: left + (width - left - right) * (max(low, min(0.5, math.log10(share) if share > 0 else low)) - low) / (0.5 - low)
    grey, red, dots = 'stroke="#8a94a0" stroke-opacity=".45"', 'stroke="#d0542b" stroke-width="1.5"', []
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="12" fill="#7b8794">',
           "<title>Differences over tolerances, by source</title>",
           f'<text x="{left}" y="14">difference / tolerance of each comparison; the line at 1 is the tolerance</text>']
    for power in range(low, 1, 2):
        at = x(10.0 ** power)
        label = f"≤ 1e{low}" if power == low else "1" if power == 0 else f"1e{power}"
        out.append(f'<line x1="{at:.1f}" y1="{top - 8}" x2="{at:.1f}" y2="{height - 22}" {grey if power else red}/>'
                   f'<text x="{at:.1f}" y="{height - 6}" text-anchor="middle">{label}</text>')
    for i, source in enumerate(sources):
        y = top + step * i + 8
        short = source if len(source) <= 52 else source[:50].rstrip(" ,(") + " ..."
        out.append(f'<text x="{left - 8}" y="{y + 4}" text-anchor="end">{html.escape(short)}</text>'
                   f'<line x1="{left}" y1="{y}" x2="{width - right}" y2="{y}" {grey}/>')
        for row in rows:
            if row[0] == source:
                share = abs(row[3] - row[4]) / row[5] if row[5] else 0.0
                dots.append(f'<circle cx="{x(share):.1f}" cy="{y}" r="4" fill="#2f7fd8" fill-opacity=".55"/>')
    return "\n".join(out + dots + ["</svg>"]) + "\n"


def main():
    tests, page = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    rows = []  # source, what, unit, ours, reference, tolerance, why, test
    with tempfile.TemporaryDirectory() as folder:
        for program, names in PROGRAMS.items():
            report = pathlib.Path(folder) / "report.xml"
            done = subprocess.run([tests / program, f"--gtest_filter={names}", f"--gtest_output=xml:{report}"],
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
            if not report.exists():
                sys.exit(f"error: {program} wrote no report; its last words: {done.stdout[-500:]}")
            for case in ElementTree.parse(report).iter("testcase"):
                found = 0
                for entry in case.iter("property"):
                    if not entry.get("name").startswith("reference_"):
                        continue
                    what, unit, ours, reference, tolerance, source, why = entry.get("value").split("\t")
                    rows.append((source, what, unit, float(ours), float(reference), float(tolerance), why,
                                 f"{case.get('classname')}.{case.get('name')}"))
                    found += 1
            report.unlink()
    if len(rows) < 100:
        sys.exit(f"error: only {len(rows)} comparisons came out of the tests")
    failed = [row for row in rows if not abs(row[3] - row[4]) <= row[5]]
    commit = f" at commit {sys.argv[3]}" if len(sys.argv) > 3 else ""
    text = (f"# Against references\n\nMade by `tests/run verification` on {datetime.date.today()}{commit}: {len(rows)} "
            f"comparisons, {len(failed)} of them out of tolerance. Each is a test of the quick suite, which fails where the "
            "difference is larger than the tolerance; the reason for the tolerance stands beside it.\n\n")
    if failed:
        text += "**Out of tolerance:** " + "; ".join(f"{row[0]}: {row[1]}" for row in failed) + "\n\n"
    sources = list(dict.fromkeys(row[0] for row in rows))
    page.with_suffix(".svg").write_text(plot(rows, sources))
    text += f"![How much of its tolerance each comparison takes, by source]({page.stem}.svg)\n\n"
    for source in sources:
        mine = [row for row in rows if row[0] == source]
        names = ", ".join(dict.fromkeys(re.sub(r"/\d+$", "", f"`{row[7]}`") for row in mine))
        whys = "; ".join(dict.fromkeys(row[6] for row in mine))
        text += f"## {source[0].upper()}{source[1:]}\n\nTest {names}. Tolerance: {whys}.\n\n"
        text += "| what | reference | ours | difference | tolerance |\n|---|---|---|---|---|\n"
        for _, what, unit, ours, reference, tolerance, _, _ in mine:
            unit = f" {unit}" if unit else ""
            difference, allowed = f"{abs(ours - reference):.1e}{unit}", f"{tolerance:.1e}{unit}"
            if reference:
                difference, allowed = f"{abs(ours / reference - 1):.1e}", f"{tolerance / abs(reference):.1e}"
            text += f"| {what} | {reference:.8g}{unit} | {ours:.8g}{unit} | {difference} | {allowed} |\n"
        text += "\n"
    text += ("Differences and tolerances are relative to the reference; where that is zero, in its unit.\n\nIn the tests besides, "
             "as whole curves or matrices: velocities and reactions of ADAMS' joints, Chrono's element 3243 (`ChronoElement3243`), linear coefficients and "
             "threshold of journal bearings, MacPherson's exact kinematics, switches at their exact times, Laval's rotor against Jeffcott, patch tests and exact solutions of "
             "elements.\n")
    page.write_text(text)
    print(f"{len(rows)} comparisons, {len(failed)} out of tolerance: {page}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
