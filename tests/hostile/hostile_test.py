# Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
"""Hostile files through every reader: nothing runs, nothing moves the terminal, nothing but the declared outputs changes.

FLEXURA_SEED and FLEXURA_CASES change which cases are drawn and how many; a failing one is named by its seed, and
`FLEXURA_KEEP=1` leaves its folder. README.md tells what is covered.
"""

import os
import random
import unittest
from concurrent.futures import ThreadPoolExecutor

import judge
import scripts
import texts

SEED = int(os.environ.get("FLEXURA_SEED", "1"))
CASES = int(os.environ.get("FLEXURA_CASES", "200"))


def tried(draw, seed):
    """What was wrong with one case, in words; empty where nothing was."""
    folder = judge.Folder()
    try:
        case = draw(random.Random(seed), folder.path)
        wrong = judge.verdicts(case, folder)
    finally:
        if "FLEXURA_KEEP" not in os.environ:
            folder.remove()
    return f"seed {seed}, {case.name} ({' '.join(map(str, case.words))}): " + "; ".join(wrong) if wrong else ""


class Hostile(unittest.TestCase):
    """A property, held by as many random cases as are asked for."""

    def hold(self, draw):
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            found = [words for words in pool.map(lambda seed: tried(draw, seed), range(SEED, SEED + CASES)) if words]
        self.assertEqual(found, [], f"{len(found)} of {CASES} cases:\n" + "\n".join(found[:20]))


class Scripts(Hostile):
    def test_files_run_nothing(self):
        self.hold(scripts.case)

    def test_a_canary_tells(self):
        """What is let run leaves it: so these files tell what they are to tell."""
        folder = judge.Folder()
        try:
            beam = (f"{scripts.STEEL}[section.s]\ntype = \"circle\"\ndiameter = 0.01\n[node.a]\nposition = [0, 0, 0]\n[node.b]\n"
                    "position = [1, 0, 0]\n[curves.c]\nfile = \"c.geo\"\n[interface.a]\n[interface.b]\n")
            body = f'SystemCall "touch {folder.path}/CANARY";\nPoint(1) = {{0, 0, 0, 1}}; Point(2) = {{1, 0, 0, 1}}; Line(1) = {{1, 2}};\n'
            folder.write({"in/p.toml": beam, "in/c.geo": body})
            words = ["flexura-reduce", "p.toml", "-q", "-o", "../out/p.se.h5"]
            self.assertEqual(folder.run(words).returncode, 2)
            self.assertFalse((folder.path / "CANARY").exists())
            self.assertEqual(folder.run([*words, "--run-scripts"]).returncode, 0)
            self.assertTrue((folder.path / "CANARY").exists())
        finally:
            folder.remove()


class Texts(Hostile):
    def test_files_move_and_forge_nothing(self):
        self.hold(texts.case)


if __name__ == "__main__":
    unittest.main()
