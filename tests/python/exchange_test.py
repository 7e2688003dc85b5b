# Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
"""Exported files, opened by the programs they are for (Debian's VTK) or by readers written from their specifications."""

import json
import os
import re
import struct
import subprocess
import tempfile
import unittest
from pathlib import Path
from xml.etree import ElementTree

import flexura
import numpy as np
import vtk
from flexura.programs import run
from vtk.util.numpy_support import vtk_to_numpy


class Exchange(unittest.TestCase):
    """The box beam of tests/mbs/superelement: six rigid and at most nine elastic modes of the free body."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="flexura_exchange_")
        cls.here = Path(cls.folder.name)
        subprocess.run([Path(os.environ["FLEXURA_TESTS"]) / "view_write_pages", cls.here], check=True)
        cls.beam = cls.here / "beam.se.h5"
        cls.se = flexura.read_superelement(cls.beam)
        cls.modes = cls.se.natural_modes(count=4)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def export(self, form, name):
        run(["export", self.beam, "--format", form, "-n", 4, "-o", self.here / name])
        return self.here / name

    def check_drawn(self, found, j):
        """`found`: the displacement of mode j at the vertices, drawn at a tenth of the part's size, of either sign."""
        u = np.asarray(self.se.displacement(self.modes.shapes[:, j]))
        vertices = np.asarray(self.se.vertices)
        size = np.linalg.norm(np.ptp(vertices, axis=0))
        u = u * (0.1 * size / np.linalg.norm(u, axis=1).max())
        sign = np.sign((u * found).sum())
        # 32-bit numbers, through sums of 15 shapes: 1e-6 of the largest.
        np.testing.assert_allclose(found * sign, u, atol=2e-6 * size * 0.1)

    def test_vtk_reads_the_mode_shapes(self):
        reader = vtk.vtkXMLPolyDataReader()
        reader.SetFileName(str(self.export("vtk", "beam.vtp")))
        reader.Update()
        data = reader.GetOutput()
        np.testing.assert_array_equal(vtk_to_numpy(data.GetPoints().GetData()), self.se.vertices)
        self.assertEqual(data.GetNumberOfPolys(), len(self.se.triangles))
        corners = vtk_to_numpy(data.GetPolys().GetConnectivityArray()).reshape(-1, 3)
        np.testing.assert_array_equal(corners, self.se.triangles)
        arrays = data.GetPointData()
        self.assertEqual(arrays.GetNumberOfArrays(), 4)
        for j in range(4):
            name = arrays.GetArrayName(j)
            self.assertAlmostEqual(float(re.search(r"\(([\d.]+) Hz\)", name)[1]), self.modes.frequency[j], delta=0.006)
            self.check_drawn(vtk_to_numpy(arrays.GetArray(j)), j)

    def test_vtk_reads_the_gltf_animation(self):
        path = self.export("gltf", "beam.glb")
        reader = vtk.vtkGLTFReader()
        reader.SetFileName(str(path))
        reader.UpdateInformation()
        self.assertEqual(reader.GetNumberOfAnimations(), 4)
        for j in range(4):
            self.assertIn(f"mode {j + 7} (", reader.GetAnimationName(j))
            self.assertAlmostEqual(reader.GetAnimationDuration(j), 1.5, places=6)

    def test_gltf_holds_each_mode_as_a_morph_target(self):
        data = self.export("gltf", "beam2.glb").read_bytes()
        magic, version, length = struct.unpack_from("<4sII", data)
        self.assertEqual((magic, version, length), (b"glTF", 2, len(data)))
        n_json, kind = struct.unpack_from("<I4s", data, 12)
        self.assertEqual((kind, n_json % 4), (b"JSON", 0))
        header = json.loads(data[20:20 + n_json])
        n_bin, kind = struct.unpack_from("<I4s", data, 20 + n_json)
        self.assertEqual(kind, b"BIN\0")
        binary = data[28 + n_json:]
        self.assertEqual(len(binary), n_bin)
        self.assertEqual(header["buffers"][0]["byteLength"], n_bin)

        def accessor(number):
            item = header["accessors"][number]
            view = header["bufferViews"][item["bufferView"]]
            self.assertEqual(view["byteOffset"] % 4, 0)
            width = {"SCALAR": 1, "VEC3": 3}[item["type"]]
            kind = {5126: "<f4", 5125: "<u4"}[item["componentType"]]
            values = np.frombuffer(binary, kind, item["count"] * width, view["byteOffset"]).reshape(-1, width)
            self.assertEqual(view["byteLength"], values.nbytes)
            if "min" in item:
                np.testing.assert_array_equal(values.min(axis=0), np.float32(item["min"]))
                np.testing.assert_array_equal(values.max(axis=0), np.float32(item["max"]))
            return values

        mesh, = header["meshes"]
        first = mesh["primitives"][0]
        np.testing.assert_array_equal(accessor(first["attributes"]["POSITION"]), np.float32(self.se.vertices))
        for j, target in enumerate(first["targets"]):
            self.check_drawn(accessor(target["POSITION"]), j)
        triangles = np.concatenate([accessor(p["indices"]).reshape(-1, 3) for p in mesh["primitives"] if p["mode"] == 4])
        self.assertEqual({tuple(t) for t in triangles}, {tuple(t) for t in np.asarray(self.se.triangles)})
        for j, animation in enumerate(header["animations"]):
            sampler, = animation["samplers"]
            time, weights = accessor(sampler["input"]), accessor(sampler["output"]).reshape(-1, 4)
            expected = np.zeros_like(weights)
            expected[:, j] = np.cos(2 * np.pi * time[:, 0] / 1.5)
            np.testing.assert_allclose(weights, expected, atol=1e-6)  # 32-bit numbers
            self.assertEqual(animation["channels"][0]["target"], {"node": 0, "path": "weights"})

    def test_gmsh_views_hold_the_mode_shapes(self):
        # MSH 2.2 read from its description: $NodeData blocks with a name, a time, four integers, then node and values.
        text = self.export("gmsh", "beam.msh").read_text()
        nodes = np.array([line.split() for line in re.search(r"\$Nodes\n\d+\n(.*?)\$EndNodes", text, re.S)[1].splitlines()],
                         dtype=float)
        np.testing.assert_allclose(nodes[:, 1:], self.se.vertices, rtol=1e-15)
        views = re.findall(r"\$NodeData\n1\n\"(.*?)\"\n1\n0.0\n3\n0\n3\n(\d+)\n(.*?)\$EndNodeData", text, re.S)
        self.assertEqual(len(views), 4)
        for j, (_, count, block) in enumerate(views):
            rows = np.array([line.split() for line in block.splitlines()], dtype=float)
            self.assertEqual(len(rows), int(count))
            self.check_drawn(rows[:, 1:], j)


class Motion(unittest.TestCase):
    """The pendulum of mbs/python/README.md, with shapes on its strip, as ParaView gets it."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="flexura_motion_")
        cls.here = Path(cls.folder.name)
        link, pendulum = readme_files()
        (cls.here / "link.toml").write_text(link, encoding="utf-8")
        (cls.here / "pendulum.toml").write_text(pendulum + """
[[body.link.shape]]
type = "box"
center = [1, 0, 0]
size = [0.1, 0.06, 0.04]
[[body.link.shape]]
type = "cylinder"
from = [0, 0, -0.1]
to = [0, 0, 0.1]
radius = 0.05
""", encoding="utf-8")
        cls.se = flexura.reduce(cls.here / "link.toml")
        cls.results = flexura.simulate(cls.here / "pendulum.toml", settings={"solver.end_time": "0.2 s"})

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_vtk_reads_the_bodies_where_they_are(self):
        run(["export", self.here / "pendulum.h5", "--format", "pvd", "--frames", 5])
        history = self.results["flexible"]
        frames = ElementTree.parse(self.here / "pendulum.flexible.pvd").getroot().findall("Collection/DataSet")
        self.assertTrue(4 <= len(frames) <= 6)
        self.assertEqual(float(frames[-1].get("timestep")), history.time[-1])
        n = len(self.se.vertices)
        for frame in frames:
            reader = vtk.vtkXMLPolyDataReader()
            reader.SetFileName(str(self.here / frame.get("file")))
            reader.Update()
            data = reader.GetOutput()
            row = int(np.argmin(np.abs(np.asarray(history.time) - float(frame.get("timestep")))))
            body = history.bodies["link"]
            u = np.asarray(self.se.displacement(body.superelement_coordinates()[row]))
            origin, turn = np.asarray(body.position)[row], rotation(np.asarray(body.quaternion)[row])
            points = vtk_to_numpy(data.GetPoints().GetData())
            # Shapes are kept in 32 bits: 1e-7 of displacements below 0.1 m.
            np.testing.assert_allclose(points[:n], origin + (np.asarray(self.se.vertices) + u) @ turn.T, atol=1e-7)
            moved = vtk_to_numpy(data.GetPointData().GetArray("displacement"))
            np.testing.assert_allclose(moved[:n], u @ turn.T, atol=1e-7)
            self.assertEqual(np.abs(moved[n:]).max(), 0.0)
            self.assertAlmostEqual(data.GetFieldData().GetArray("TimeValue").GetValue(0), history.time[row])
            self.assertEqual(set(vtk_to_numpy(data.GetCellData().GetArray("body"))), {1})
            # By the divergence theorem; outside is where the corners run counter-clockwise.
            corners = points[vtk_to_numpy(data.GetPolys().GetConnectivityArray()).reshape(-1, 3)]
            corners = corners[corners.shape[0] - self.shape_triangles:]
            volume = np.einsum("ti,ti->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
            prism = 32 / 2 * 0.05**2 * np.sin(2 * np.pi / 32) * 0.2
            self.assertAlmostEqual(volume / (0.1 * 0.06 * 0.04 + prism), 1.0, delta=1e-9)

    shape_triangles = 12 + 32 * (1 + 2 + 1)

    def test_csv_holds_every_quantity_with_its_unit(self):
        run(["export", self.here / "pendulum.h5", "--format", "csv"])
        for name, history in self.results.runs.items():
            lines = (self.here / f"pendulum.{name}.csv").read_text().splitlines()
            heads = lines[0].split(",")
            self.assertEqual(heads[0], "time [s]")
            self.assertEqual(heads[1:], [history[q].label for q in history])
            values = np.array([[float(v) for v in line.split(",")] for line in lines[1:]])
            np.testing.assert_array_equal(values[:, 0], history.time)
            np.testing.assert_array_equal(values[:, 1:].T, [history[q] for q in history])


def rotation(q):
    """R of a quaternion w x y z."""
    w, x, y, z = q
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


def readme_files():
    """link.toml and pendulum.toml."""
    readme = Path(__file__).resolve().parents[2] / "mbs" / "python" / "README.md"
    return re.findall(r"^```toml\n(.*?)^```", readme.read_text(encoding="utf-8"), re.S | re.M)


if __name__ == "__main__":
    unittest.main()
