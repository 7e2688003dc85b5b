#!/usr/bin/python3
# Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
"""references_page.py TESTS PAGE COMMIT: runs the tests that compare with references (tests/reference.hpp) and writes the
page of the verification manual.  A comparison that fails stands first, in bold, and the exit code is 1."""
import datetime
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
    "flexible_test": "SimoVuQuocSpinUp.Peak*:RotatingCantilever.*",
    "case_tests": "Iftomm.*:Andrews.*:Bicycle.*",
}


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
    for source in dict.fromkeys(row[0] for row in rows):
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
    text += ("Differences and tolerances are relative to the reference; where that is zero, in its unit.\n\nIn the tests, not yet in "
             "this table: single joints against MSC ADAMS (`AdamsJoint`, 51 rows each, motion and reactions), the flexible "
             "slider-crank of Simeon (`SimeonSliderCrank`), Chrono's element 3243 (`ChronoElement3243`), MacPherson's exact "
             "kinematics, switches at their exact times, Laval's rotor against Jeffcott, patch tests and exact solutions of "
             "elements.\n")
    page.write_text(text)
    print(f"{len(rows)} comparisons, {len(failed)} out of tolerance: {page}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
