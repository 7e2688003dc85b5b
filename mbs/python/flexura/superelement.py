# Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
"""Superelement files (mbs/superelement/FORMAT.md says what is in them)."""

import json
from dataclasses import dataclass, field
from typing import Any, Dict, List, Optional, Sequence

import numpy as np
import numpy.typing as npt

from .arrays import Array, FilePath, open_file, read_array, read_text


@dataclass
class Interface:
    """A point to which a face, an edge or a node of the mesh is tied."""

    name: str
    tie: str  # "rigid", "average" or "node"
    position: Array  # p_BoN_B [m]
    directions: List[str]  # "u_x", ..., "theta_z"
    first_dof: int
    follow: Dict[str, Array] = field(default_factory=dict)  # directions that are no dofs: direction -> row, n

    @property
    def dofs(self) -> slice:
        """Its rows and columns in the matrices."""
        return slice(self.first_dof, self.first_dof + len(self.directions))


@dataclass
class Modes:
    """Natural modes: frequencies [Hz], and one column of superelement coordinates for each."""

    frequency: Array
    shapes: Array
    held: List[str]


@dataclass
class SectionForces:
    """Section forces of a beam part: N, V_y, V_z, T, M_y, M_z at places along its members."""

    members: List[str]
    member: Array  # n_p: number of each place's member
    positions: Array  # n_p x 3 [m]
    axes: Array  # n_p x 3 x 3: columns are the member's axes in B
    modes: Array  # n x 6 n_p [N, N m per dof]

    def at(self, u_se: npt.ArrayLike) -> Array:
        """For superelement coordinates, also many rows of them: ... x n_p x 6 [N, N m]."""
        forces = np.asarray(u_se) @ np.asarray(self.modes)
        return Array(forces.reshape(*forces.shape[:-1], -1, 6), "section forces", "N, N m")


@dataclass
class Superelement:
    """A reduced body: u(x) = sum_k phi_k(x) u_se,k with n = n_b + n_q shapes phi_k.

    Arrays have the shapes of FORMAT.md; groups that the file does not hold are None (or empty).
    """

    name: str
    created_by: str
    source: str
    report: Dict[str, Any]
    n_b: int
    n_q: int
    modal_damping: float
    interfaces: List[Interface]
    K_se: Array  # n x n
    M_se: Array  # n x n
    D_se: Optional[Array]
    omega2: Array  # n_q [rad^2/s^2]
    inertia: Dict[str, Array]  # mass, S_x, S_xx, S_phi, S_xphi, S_phiphi
    load_cases: Dict[str, Array]  # name: p_se, n
    stiffening: Dict[str, Array] = field(default_factory=dict)  # K0t, K0r, K0omega, K0F
    vertices: Optional[Array] = None  # n_v x 3 [m]
    triangles: Optional[Array] = None  # n_t x 3
    edges: Optional[Array] = None  # n_e x 2
    surface_shapes: Optional[Array] = None  # n x 3 n_v
    stress_vertices: Optional[Array] = None  # n_s: vertex of the surface at each place
    stress_modes: Optional[Array] = None  # n x 6 n_s [Pa]
    section_forces: Optional[SectionForces] = None  # of a beam part
    node_numbers: Optional[Array] = None  # n_k, of a part with [recovery] nodes = "all"
    node_positions: Optional[Array] = None  # n_k x 3 [m]
    node_rotations: Optional[Array] = None  # n_k: 0 none known, 1 dofs of the model, 2 half the curl of u
    T: Optional[Array] = None  # n x 6 n_k [m, rad]

    @property
    def n(self) -> int:
        return self.n_b + self.n_q

    @property
    def mass(self) -> float:
        """[kg]"""
        return float(self.inertia["mass"].ravel()[0])

    @property
    def mass_centre(self) -> Array:
        """From Bo [m]."""
        return Array(np.asarray(self.inertia["S_x"]) / self.mass, "mass centre", "m")

    def interface(self, name: str) -> Interface:
        """An interface by its name; KeyError lists the names."""
        for item in self.interfaces:
            if item.name == name:
                return item
        raise KeyError(f"no interface is called {name!r}; there are {', '.join(i.name for i in self.interfaces)}")

    @property
    def fixed_interface_frequencies(self) -> Array:
        """With all interfaces held [Hz]."""
        return Array(np.sqrt(np.asarray(self.omega2)) / (2 * np.pi), "frequency", "Hz",
                     "natural frequencies with all interfaces held")

    def rigid_motions(self) -> "np.ndarray[Any, np.dtype[np.float64]]":
        """Translations along and rotations about the axes of B at Bo in the n coordinates: n x 6."""
        R = np.zeros((self.n, 6))
        for item in self.interfaces:
            x, y, z = np.asarray(item.position)
            # Columns u_x ... theta_z of the motion of a point at (x, y, z): u = a + alpha x p, theta = alpha.
            rows = {"u_x": [1, 0, 0, 0, z, -y], "u_y": [0, 1, 0, -z, 0, x], "u_z": [0, 0, 1, y, -x, 0],
                    "theta_x": [0, 0, 0, 1, 0, 0], "theta_y": [0, 0, 0, 0, 1, 0], "theta_z": [0, 0, 0, 0, 0, 1]}
            for i, direction in enumerate(item.directions):
                R[item.first_dof + i] = rows[direction]
        return R

    def natural_modes(self, held: Sequence[str] = (), count: Optional[int] = None) -> Modes:
        """Elastic modes (K_se - omega^2 M_se) phi = 0 with the named interfaces held, phi^T M_se phi = 1.

        Of a free body the rigid motions that the held interfaces leave are projected out, not searched for.
        """
        keep = np.ones(self.n, dtype=bool)
        for name in held:
            keep[self.interface(name).dofs] = False
        K, M = np.asarray(self.K_se)[np.ix_(keep, keep)], np.asarray(self.M_se)[np.ix_(keep, keep)]
        R = self.rigid_motions()
        # Motions that the held dofs leave free: the null space of their rows of R.
        _, s, Vt = np.linalg.svd(R[~keep]) if (~keep).any() else (None, np.zeros(0), np.eye(6))
        rank = int((s > 1e-9 * (s[0] if s.size else 1.0)).sum())
        free = R[keep] @ Vt[rank:].T
        # An M-orthogonal complement of the free motions, then a standard problem with K's Cholesky factor.
        basis = np.eye(K.shape[0])
        if free.shape[1]:
            Q, _ = np.linalg.qr(M @ free, mode="complete")
            basis = Q[:, free.shape[1]:]
        L = np.linalg.cholesky(basis.T @ K @ basis)
        A = np.linalg.solve(L, np.linalg.solve(L, basis.T @ M @ basis).T)
        mu, Y = np.linalg.eigh((A + A.T) / 2)
        order = np.argsort(mu)[::-1]
        order = order[mu[order] > 1e-14 * mu[order[0]]][:count]
        shapes = np.zeros((self.n, len(order)))
        shapes[keep] = basis @ np.linalg.solve(L.T, Y[:, order]) / np.sqrt(mu[order])
        return Modes(Array(1 / np.sqrt(mu[order]) / (2 * np.pi), "frequency", "Hz"),
                     Array(shapes, "mode shapes", "", "superelement coordinates, mass-normalised"), list(held))

    def displacement(self, u_se: npt.ArrayLike) -> Array:
        """Of the surface's vertices for superelement coordinates u_se: n_v x 3 [m]."""
        self._require(self.surface_shapes, "shapes on its surface")
        return Array((np.asarray(u_se) @ np.asarray(self.surface_shapes)).reshape(-1, 3), "displacement", "m")

    def node_motions(self, u_se: npt.ArrayLike) -> Array:
        """u_x, u_y, u_z, theta_x, theta_y, theta_z of the nodes node_numbers: n_k x 6 [m, rad]."""
        self._require(self.T, "the motions of all nodes")
        return Array((np.asarray(u_se) @ np.asarray(self.T)).reshape(-1, 6), "motion", "m, rad")

    def stress(self, u_se: npt.ArrayLike) -> Array:
        """Nodal stresses xx, yy, zz, xy, yz, zx at the places stress_vertices: n_s x 6 [Pa]."""
        self._require(self.stress_modes, "stress modes")
        return Array((np.asarray(u_se) @ np.asarray(self.stress_modes)).reshape(-1, 6), "stress", "Pa")

    @staticmethod
    def von_mises(stress: npt.ArrayLike) -> Array:
        """Of an n x 6 array as stress() gives it [Pa]."""
        xx, yy, zz, xy, yz, zx = np.asarray(stress).T
        return Array(np.sqrt(((xx - yy)**2 + (yy - zz)**2 + (zz - xx)**2) / 2 + 3 * (xy**2 + yz**2 + zx**2)),
                     "von Mises stress", "Pa")

    def _require(self, array: Optional[Array], what: str) -> None:
        if array is None:
            raise ValueError(f"superelement {self.name!r} was read or made without {what}")


def read_superelement(path: FilePath, surface: bool = True) -> Superelement:
    """Reads FILE.se.h5; without `surface` only matrices and inertia, a few kilobytes.

    Checksums are checked by HDF5.  Raises OSError for a file that is damaged and ValueError for one that is no
    superelement or of a later version.
    """
    with open_file(path, "superelement") as file:
        header = json.loads(read_text(file["header"]))
        report = read_text(file["report"]) if "report" in file else ""
        matrices = file["matrices"]
        read = {name: read_array(matrices[name]) for name in matrices}
        p_se = read.pop("p_se", None)
        se = Superelement(
            name=header["name"], created_by=header["created_by"], source=read_text(file["source"]),
            report=json.loads(report) if report else {}, n_b=header["n_b"], n_q=header["n_q"],
            modal_damping=header["modal_damping"],
            interfaces=[Interface(i["name"], i["tie"], Array(i["p_BoN_B"], i["name"], "m"), i["directions"],
                                  i["first_dof"], {d: Array(row, d) for d, row in i.get("follow", {}).items()}) for i in header["interfaces"]],
            K_se=read["K_se"], M_se=read["M_se"], D_se=read.get("D_se"), omega2=read.get("omega2", Array([])),
            inertia={name: read_array(file["inertia"][name]) for name in file["inertia"]},
            load_cases={name: Array(p_se[i], name, "", "load vector p_se") for i, name in
                        enumerate(header.get("load_cases", []))} if p_se is not None else {},
            stiffening={name: read_array(d) for name, d in file["stiffening"].items()} if "stiffening" in file else {})
        if "sections" in file:
            part = file["sections"]
            axes = read_array(part["axes"])
            se.section_forces = SectionForces(json.loads(read_text(part["members"])), read_array(part["member"]),
                                              read_array(part["positions"]), Array(axes.reshape(-1, 3, 3), axes.name, axes.unit, axes.doc),
                                              read_array(part["forces"]))
        if surface and "nodes" in file:
            se.node_numbers, se.node_positions, se.node_rotations, se.T = (
                read_array(file["nodes"][name]) for name in ("numbers", "positions", "rotations", "T"))
        if surface and "surface" in file:
            se.vertices = read_array(file["surface/vertices"])
            se.triangles = read_array(file["surface/triangles"])
            se.edges = read_array(file["surface/edges"])
            if "shapes" in file:
                se.surface_shapes = read_array(file["shapes/surface"])
            if "stress" in file:
                se.stress_vertices = read_array(file["stress/vertices"])
                se.stress_modes = read_array(file["stress/modes"])
        return se
