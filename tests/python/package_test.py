# Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
"""The Python package on a steel strip that swings as a pendulum, made and simulated by the programs."""

import json
import os
import re
import tempfile
import unittest
from pathlib import Path

import flexura
import h5py
import numpy as np
from flexura import plot
from flexura.programs import run

HERE = Path(__file__).resolve().parent
README = HERE.parents[1] / "mbs" / "python" / "README.md"


def blocks(language):
    """The fenced blocks of README.md in a language, in their order."""
    return re.findall(rf"^```{language}\n(.*?)^```", README.read_text(encoding="utf-8"), re.S | re.M)


class Package(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="flexura_python_")
        cls.here = Path(cls.folder.name)
        link, pendulum = blocks("toml")
        (cls.here / "link.toml").write_text(link, encoding="utf-8")
        (cls.here / "pendulum.toml").write_text(pendulum, encoding="utf-8")
        cls.link = flexura.reduce(cls.here / "link.toml")
        cls.results = flexura.simulate(cls.here / "pendulum.toml", settings={"solver.end_time": "1 s"})

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    # 7850 kg/m^3 x 40 mm x 5 mm x 1 m
    mass = 7850 * 0.04 * 0.005

    def test_arrays_have_names_units_and_shapes(self):
        se = self.link
        self.assertEqual(se.K_se.shape, (se.n, se.n))
        self.assertEqual((se.n_b, se.n_q), (12, 6))
        self.assertEqual(se.inertia["S_x"].unit, "kg m")
        self.assertEqual(se.interface("tip").position.unit, "m")
        self.assertEqual(list(se.interface("tip").position), [1.0, 0.0, 0.0])
        self.assertIn("stiffness", se.K_se.doc)
        with self.assertRaisesRegex(KeyError, "pivot, tip"):
            se.interface("top")

    def test_slices_keep_their_unit_and_sums_lose_it(self):
        speed = self.results["rigid"]["hinge.speed"]
        self.assertEqual((speed.name, speed.unit), ("hinge.speed", "rad/s"))
        self.assertEqual(speed[3:7].label, "hinge.speed [rad/s]")
        self.assertEqual((2 * speed).unit, "")
        self.assertEqual(speed.unit, "rad/s")
        self.assertIsInstance(speed.mean(), float)

    def test_mass_and_centre_are_those_of_the_strip(self):
        # Exact for a straight member; 1e-12 is 1e4 roundings.
        self.assertAlmostEqual(self.link.mass / self.mass, 1.0, delta=1e-12)
        np.testing.assert_allclose(self.link.mass_centre, [0.5, 0, 0], atol=1e-12)

    def test_rigid_motions_strain_nothing(self):
        R = self.link.rigid_motions()
        K = np.asarray(self.link.K_se)
        # Each row's sum of products is zero up to the rounding of its largest products.
        self.assertLess(np.abs(K @ R).max(), 1e-10 * (np.abs(K) @ np.abs(R)).max())

    def test_modes_by_numpy_agree_with_the_programs(self):
        file = self.here / "link.se.h5"
        for held, options in [([], ["--free"]), (["pivot"], ["--clamped", "pivot"]), (["pivot", "tip"], ["--fixed"])]:
            told = flexura.modes(file, *options)["analyses"][0]["modes"]
            told = [m["frequency_hz"] for m in told if m["kind"] == "elastic"]
            mine = self.link.natural_modes(held=held, count=len(told))
            # Two algorithms on the same matrices: the eigenvalue 1/omega^2 of the highest mode has the absolute
            # error of the lowest one, 1e-16 (omega_high / omega_low)^2 < 1e-9 here.
            np.testing.assert_allclose(mine.frequency, told, rtol=1e-8)
            self.assertEqual(mine.frequency.unit, "Hz")

    def test_modes_are_mass_normalised_and_leave_the_held_still(self):
        modes = self.link.natural_modes(held=["pivot"])
        M = np.asarray(self.link.M_se)
        np.testing.assert_allclose(modes.shapes.T @ M @ np.asarray(modes.shapes), np.eye(modes.shapes.shape[1]), atol=1e-8)
        self.assertEqual(np.abs(modes.shapes[self.link.interface("pivot").dofs]).max(), 0.0)

    def test_first_cantilever_frequency_is_that_of_the_beam(self):
        # 3.5160 sqrt(EI / rho A L^4) / 2 pi of an Euler-Bernoulli cantilever, bent across its 5 mm; shear and rotary
        # inertia lower it by about (h/L)^2 (1 + E/(kappa G)) ~ 1e-4.
        EI = 210e9 * 0.04 * 0.005**3 / 12
        exact = 1.8751040687**2 * np.sqrt(EI / (7850 * 0.04 * 0.005)) / (2 * np.pi)
        first = self.link.natural_modes(held=["pivot"]).frequency[0]
        self.assertAlmostEqual(first / exact, 1.0, delta=3e-4)

    def test_section_forces_of_a_cantilever_are_those_of_statics(self):
        # Held at the pivot, 10 N down and 3 N along at the tip: N = 3 N, V_z = -10 N, M_y grows from the tip's 0 to
        # F l at the pivot; members take +x along themselves, z up.
        se = self.link
        forces = se.section_forces
        load = np.zeros(se.n)
        load[se.interface("tip").dofs] = [3, 0, -10, 0, 0, 0]
        keep = np.ones(se.n, dtype=bool)
        keep[se.interface("pivot").dofs] = False
        u_se = np.zeros(se.n)
        u_se[keep] = np.linalg.solve(np.asarray(se.K_se)[np.ix_(keep, keep)], load[keep])
        N, V_y, V_z, T, M_y, M_z = np.asarray(forces.at(u_se)).T
        x = np.asarray(forces.positions)[:, 0]
        self.assertEqual(forces.members, ["link"])
        np.testing.assert_array_equal(np.asarray(forces.axes)[0], np.eye(3))
        # Round-off of K_se of a slender strip: 1e-16 of its stretching stiffness 42 MN/m times 0.02 m of sag.
        close = dict(rtol=1e-6, atol=1e-6)
        np.testing.assert_allclose(N, 3.0, **close)
        np.testing.assert_allclose(V_z, -10.0, **close)
        np.testing.assert_allclose(M_y, 10.0 * (1.0 - x), **close)
        for none in (V_y, T, M_z):
            np.testing.assert_allclose(none, 0.0, **close)

    def test_energy_of_the_rigid_pendulum_from_its_arrays(self):
        run = self.results["rigid"]
        self.assertTrue(run.complete)
        # T + V of a rod about its end, from the speed and from where its middle is.
        J = self.mass * (1.0 / 3 + 0.04**2 / 12)
        middle = run.bodies["link"].place(self.link.mass_centre)
        energy = 0.5 * J * np.asarray(run["hinge.speed"])**2 + self.mass * 9.81 * np.asarray(middle)[:, 2]
        # The run's own tolerance is 1e-7 for each step, of some hundred; the swing is m g L / 2 = 7.7 J.
        self.assertLess(np.ptp(energy), 1e-4 * 7.7)
        np.testing.assert_allclose(np.ptp(run["energy.potential"]), np.ptp(np.asarray(middle)[:, 2]) * self.mass * 9.81,
                                   rtol=1e-6)

    def test_a_flexible_body_has_superelement_coordinates(self):
        run = self.results["flexible"]
        u_se = run.bodies["link"].superelement_coordinates()
        self.assertEqual(u_se.shape, (len(run.time), self.link.n))
        # Strain energy by K_se is the stored one.
        strain = 0.5 * np.einsum("ti,ij,tj->t", u_se, np.asarray(self.link.K_se), u_se)
        np.testing.assert_allclose(strain, run["link.strain_energy"], rtol=1e-7, atol=1e-12)
        with self.assertRaisesRegex(ValueError, "rigid in this run"):
            self.results["rigid"].bodies["link"].superelement_coordinates()

    def test_spectrum_of_a_sine_stands_at_its_frequency(self):
        run = self.results["rigid"]
        t = np.asarray(run.time)
        run._quantities["test"] = flexura.Array(3.0 * np.sin(2 * np.pi * 40.0 * t), "test", "m")
        frequency, amplitude = run.spectrum("test")
        del run._quantities["test"]
        peak = int(np.argmax(amplitude))
        self.assertLess(abs(frequency[peak] - 40.0), frequency[1])  # a line's width
        # Between two lines a Hann window shows at least 85 % of the amplitude.
        self.assertTrue(0.85 * 3 < amplitude[peak] < 1.001 * 3)
        self.assertEqual(amplitude.unit, "m")

    def test_check_tells_scripts_what_it_prints(self):
        told = json.loads(run(["check", self.here / "link.se.h5", "--json"]))
        self.assertAlmostEqual(told["mass_kg"] / self.mass, 1.0, delta=1e-12)
        self.assertEqual([i["name"] for i in told["interfaces"]], ["pivot", "tip"])
        np.testing.assert_allclose(told["fixed_interface_frequencies_hz"], self.link.fixed_interface_frequencies)
        told = json.loads(run(["check", self.here / "pendulum.toml", "--json"]))
        rigid, flexible = told["runs"]
        self.assertEqual((rigid["n_dof"], rigid["n_flx"]), (1, 0))
        self.assertEqual(flexible["n_dof"], 1 + flexible["n_flx"])
        self.assertEqual(rigid["joints"], [{"name": "hinge", "type": "revolute", "is_constraint": False, "is_connection": False}])

    def test_results_are_a_mapping_of_runs_and_one_run_goes_by_its_name(self):
        self.assertEqual(list(self.results), ["rigid", "flexible"])
        self.assertIn("rigid", self.results)
        self.assertNotIn("rigit", self.results)
        self.assertEqual(len(self.results.items()), 2)
        self.assertEqual(repr(self.results), "<results 'pendulum': runs rigid, flexible>")
        one = flexura.simulate(self.here / "pendulum.toml", self.here / "one.h5",
                               settings={"solver.end_time": "0.01 s"}, runs="rigid")
        self.assertEqual(list(one), ["rigid"])
        self.assertEqual(repr(self.results["rigid"].bodies["link"]), "<body 'link': 501 rows, rigid>")
        with self.assertRaisesRegex(KeyError, r"results\['rigid'\]\['hinge.speed'\]"):
            self.results["hinge.speed"]
        with self.assertRaisesRegex(KeyError, "run.time"):
            self.results["rigid"]["time"]

    def test_a_mechanism_of_a_dictionary_swings_with_its_frequency(self):
        # A point of 1 kg on 0.5 m, written and read back as it was.
        document = {
            "name": "a \"point\"", "gravity": [0, 0, -9.81],
            "ground": {"marker": {"hook": {"axis": [0, 1, 0]}}},
            "body": {"bob": {"mass": np.float64(1.0), "center": np.array([0.5, 0, 0]),
                             "inertia": ("1e-12 kg*m^2", 1e-12, 1e-12),
                             "marker": {"pin": {"axis": [0, 1, 0]}},
                             "shape": [{"type": "sphere", "center": [0.5, 0, 0], "radius": 0.02}]}},
            "joint": {"pin": {"type": "revolute", "from": "ground.hook", "to": "bob.pin", "angle": "90 deg", "drive": None}},
            "solver": {"end_time": 0.1}, "output": {"quantities": ["pin.angle"]}}
        file = flexura.write_toml(self.here / "bob.toml", document)
        import tomllib
        read = tomllib.loads(file.read_text(encoding="utf-8"))
        self.assertEqual(read["name"], document["name"])
        self.assertEqual(read["body"]["bob"]["center"], [0.5, 0, 0])
        self.assertEqual(read["body"]["bob"]["shape"], document["body"]["bob"]["shape"])
        mode, = flexura.eigen(file)["runs"][0]["modes"]
        self.assertAlmostEqual(mode["frequency_hz"], np.sqrt(9.81 / 0.5) / (2 * np.pi), places=6)
        at_rest = flexura.statics(file, settings={"body": {"bob": {"mass": np.float64(2.0)}}, "output.quantities": ["pin.force"]})
        self.assertAlmostEqual(at_rest["runs"][0]["quantities"][0]["value"], 2 * 9.81, places=9)
        self.assertIn("pin.angle", flexura.simulate(file)["run"])
        # Without shapes its picture goes from its only joint to its mass centre; two joints say enough.
        del document["body"]["bob"]["shape"]
        flexura.simulate(flexura.write_toml(file, document))
        with h5py.File(file.with_suffix(".h5"), "r") as results:
            drawn, = json.loads(bytes(results["bodies/bob/shape"][()]))
        self.assertEqual(drawn, {"type": "line", "points": [[0, 0, 0], [0.5, 0, 0]]})
        # Nothing damps it: round-off is no damping on the page of its modes either.
        flexura.eigen(file, "--pictures", str(self.here / "bob_modes.h5"))
        mode, = flexura.read_results(self.here / "bob_modes.h5").values()
        self.assertEqual(mode.summary["mode"]["damping"], 0)
        with self.assertRaisesRegex(TypeError, "write_toml"):
            flexura.simulate(document)
        with self.assertRaisesRegex(TypeError, "body.bob.mass: a complex"):
            flexura.write_toml(self.here / "no.toml", {"body": {"bob": {"mass": 1j}}})

    def test_a_study_gives_its_choices_with_errors_times_and_results(self):
        (self.here / "study.toml").write_text(
            'mechanism = "pendulum.toml"\nrun = "rigid"\nrepeats = 1\nset = ["solver.end_time=0.2"]\n'
            '[axis.tolerance]\nkey = "solver.tolerance"\nvalues = ["1e-3", "1e-6"]\n'
            '[quantity.angle]\nof = "hinge.angle"\n[want]\naccuracy = ["1 %"]\n', encoding="utf-8")
        study = flexura.study(self.here / "study.toml")
        self.assertEqual(len(study), 2)
        coarse, fine = study.values()
        self.assertLess(fine.error, coarse.error)
        self.assertEqual(fine.errors, {"angle": fine.error})
        self.assertGreater(coarse.wall_time, 0)
        self.assertIn(coarse, study.front + [coarse])
        self.assertTrue(study.answers)
        angle = fine.results()["rigid"]["hinge.angle"]
        self.assertAlmostEqual(angle[0], np.radians(60), places=12)
        self.assertEqual(list(flexura.read_study(self.here / "study.json")), list(study))
        with self.assertRaisesRegex(ValueError, "holds no study"):
            (self.here / "none.json").write_text("{}", encoding="utf-8")
            flexura.read_study(self.here / "none.json")

    def test_refusals_are_the_programs_sentences(self):
        with self.assertRaisesRegex(flexura.FlexuraError, "did you mean") as caught:
            flexura.simulate(self.here / "pendulum.toml", self.here / "no.h5", settings={"solver.end_tim": "1 s"})
        self.assertEqual(caught.exception.code, 2)
        self.assertFalse((self.here / "no.h5").exists())
        with self.assertRaisesRegex(ValueError, "no superelement file.*read_results"):
            flexura.read_superelement(self.here / "pendulum.h5")
        with self.assertRaisesRegex(FileNotFoundError, "none.h5: there is no such file"):
            flexura.read_results(self.here / "none.h5")
        with self.assertRaisesRegex(OSError, "pendulum.toml: is no HDF5 file"):
            flexura.read_results(self.here / "pendulum.toml")
        with self.assertRaisesRegex(ValueError, "no results file"):
            flexura.read_results(self.here / "link.se.h5")
        with self.assertRaisesRegex(KeyError, "flexible"):
            self.results["soft"]
        with self.assertRaisesRegex(KeyError, "hinge.speed"):
            self.results["rigid"]["link.speed"]
        before = os.environ["FLEXURA_BIN"]
        os.environ["FLEXURA_BIN"] = str(self.here)
        try:
            with self.assertRaisesRegex(flexura.FlexuraError, "FLEXURA_BIN names"):
                flexura.modes(self.here / "link.se.h5")
        finally:
            os.environ["FLEXURA_BIN"] = before

    def test_plots_show_the_stored_numbers(self):
        axes = plot.quantities(self.results, "hinge.speed")
        self.assertEqual([line.get_label() for line in axes.lines], ["rigid", "flexible"])
        np.testing.assert_array_equal(axes.lines[1].get_ydata(), self.results["flexible"]["hinge.speed"])
        self.assertEqual(axes.get_ylabel(), "hinge.speed [rad/s]")
        self.assertEqual(len(plot.quantities(self.results, ["hinge.speed", "hinge.angle"]).lines), 4)
        with self.assertRaisesRegex(KeyError, "stored no quantity 'hinge.sped'; there are hinge.speed"):
            plot.quantities(self.results, "hinge.sped")
        plot.spectra(self.results, "hinge.speed")
        picture = self.here / "mode.png"
        plot.mode_shape(self.link, self.link.natural_modes().shapes[:, 0]).figure.savefig(picture)
        self.assertGreater(picture.stat().st_size, 1000)

    def test_one_run_of_a_plot_goes_by_its_name(self):
        from flexura import plot
        name = next(iter(self.results["rigid"]))
        for runs in ("rigid", ["rigid"]):
            axes = plot.quantities(self.results, name, runs=runs)
            self.assertEqual([line.get_label() for line in axes.lines], ["rigid"])
            self.assertEqual(len(plot.spectra(self.results, name, runs=runs).lines), 1)
        with self.assertRaisesRegex(KeyError, "no run is called 'rigdi'"):
            plot.quantities(self.results, name, runs="rigdi")

    def test_a_notebook_shows_pages(self):
        shown = flexura.page(self.here / "link.se.h5")
        self.assertEqual(shown.path, self.here / "link.html")
        text = shown._repr_html_()
        self.assertTrue(text.startswith("<iframe ") and text.endswith("</iframe>"))
        # Escaped: nothing of the page ends the attribute.
        self.assertEqual(text.count('"'), 6)
        self.assertIn("&lt;script", text)
        shown = flexura.page(self.here / "pendulum.h5", self.here / "other.html", "--plot", "hinge.speed")
        self.assertTrue((self.here / "other.html").exists())

    def test_the_readme_example_runs(self):
        code, = blocks("python")
        before = os.getcwd()
        os.chdir(self.here)
        try:
            exec(compile(code, str(README), "exec"), {})
            for picture in ["speed.png", "mode.png", "pendulum.html"]:
                self.assertTrue(Path(picture).exists(), picture)
        finally:
            os.chdir(before)


if __name__ == "__main__":
    unittest.main()
