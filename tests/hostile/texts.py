# Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
"""Titles, names and words that move a terminal or leave the place where they are written, in every file that a program reads."""

import gzip
import io
import json
import os
import random
import struct
from functools import lru_cache

import h5py
import numpy as np

from judge import BIN, Case, Folder
from scripts import HEX, STEEL, toml

TERMINAL = ["\x1b[2J", "\x1b]0;x\x07", "\x1b[31;1m", "\x1b[1m", "\r\x1b[K", "\x9b31m", "\x85", "\x90q", "\u202e", "\u2066", "\u200f", "\u2028",
            "\n", "\r\n", "\t", "\x7f", "\x08\x08", "\ufeff", "\U000e0041", "\x00"]
FORGERIES = ["\nsystem('touch CANARY_octave');\n% ", "\nsystem('id')\n", "\n*NODE\n", "\n$ENDDATA\n", "--><script>touch</script>", "</script><script>x()</script>",
             "<img src=x onerror=x()>", "]]>", "| x | y |", "](http://x)", "=cmd|' /C x'!A0", "@x", "'); system('touch CANARY_octave'); disp('"]
ODD = ["&lt;", "+1", "-1+1", "'", '"', "\\", "%s%n%p", "{}", "{0}", "{:>99999999}", "${jndi:x}", "$(x)", "`x`", "..", "../../x", "/", "ünder", "连杆", "👩\u200d🔧",
       "x" * 300, "x" * 5000]
BROKEN = [b"\x9b31m", b"\xff\xfe", b"\xc3", b"\xed\xa0\x80", b"\xc0\x9b", b"\x80"]


def text(rng, most=4):
    return "".join(rng.choice([rng.choice(rng.choice([TERMINAL, FORGERIES, ODD])), "name", " "]) for _ in range(rng.randint(1, most)))


def raw(rng):
    """Bytes, of which some are no UTF-8."""
    data = text(rng).replace("\0", "").encode("utf-8")
    return data + rng.choice(BROKEN) if rng.random() < 0.4 else data


def line(rng):
    """Such bytes in one line."""
    return raw(rng).replace(b"\n", b"").replace(b"\r", b"")


def name(rng, chance=0.3):
    """Mostly one that is taken, so that the command goes on."""
    return text(rng, 2) if rng.random() < chance else rng.choice(["rod", "Ölpumpe", "连杆", "a b", "x" * 150, "=1", "a|b", "<b>", "it's"])


def title(rng):
    return f"name = {toml(text(rng))}\n" if rng.random() < 0.8 else ""


def mechanism(rng):
    b, j = name(rng, 0.1), name(rng, 0.1)
    out = title(rng) + f"""[body.{toml(b)}]
mass = 1
center = [1, 0, 0]
inertia = [0.1, 0.1, 0.1]
[joint.{toml(j)}]
type = "revolute"
from = "ground"
to = {toml(b)}
[force.f]
type = "joint_force"
joint = {toml(j)}
value = "sin(3*t)"
[solver]
end_time = "0.01 s"
"""
    odd = text(rng)
    extra = ["", "", f"[measure.m]\ntype = \"formula\"\nvalue = \"t\"\nunit = {toml(odd)}\n", f"[run.{toml(odd)}]\n", f"[run.r]\nset = [{toml(odd)}]\n",
             f"[output]\nquantities = [{toml(odd)}]\n", f"[input.u]\nvalue = {toml(odd)}\n", f"[table.t]\nfile = {toml(odd)}\n",
             f"[subsystem.s]\nfile = {toml(odd)}\n", f"{toml(odd)} = 1\n", f"[parameters]\n{toml(odd)} = 1\n", f"[body.x]\nsuperelement = {toml(odd)}\n",
             f"[force.g]\ntype = \"user\"\nlibrary = {toml(odd)}\n", f"[ground.marker.{toml(odd)}]\n", f"[ground.marker.g]\non = {toml(odd)}\n"]
    return rng.choice([out, out, out + rng.choice(extra)]), b, j


def mechanism_case(rng):
    file, _, j = mechanism(rng)
    words, outputs = rng.choice([
        (["statics"], []), (["check"], []), (["eigen"], []), (["assemble"], []), (["check", "--json"], []), (["statics", "--json"], []),
        (["eigen", "--frozen", "--json"], []), (["simulate", "-o", "../out/m.h5", "--csv", "--html", "../out/m.html"], ["out/m.h5", "out/m.*.csv", "out/m.html"]),
        (["linearize", "--frozen", "--input", j + ".angle", "-o", "../out/m.m"], ["out/m.m"]),
        (["linearize", "--frozen", "--input", j + ".angle", "--measure", "*", "--response", "1:2:3", "-o", "../out/m.mtx"], ["out/*.mtx", "out/*.csv"]),
        (["statics", "--save-state", "../out/s.json"], ["out/s.json"]), (["export", "--format", "urdf", "-o", "../out/m.urdf"], ["out/m.urdf"])])
    if rng.random() < 0.15:
        words = [*words, rng.choice(["--run", "--set", "--input", "--quantity", "-o"]), text(rng).replace("\0", "")]
        outputs = ["*"] if words[-2] == "-o" else outputs
    return Case(["flexura", words[0], "m.toml", *words[1:]], {"in/m.toml": file}, outputs, "mechanism " + words[0])


@lru_cache(maxsize=None)
def made(kind):
    """A sound superelement or results file, to be damaged."""
    folder = Folder()
    try:
        if kind == "superelement":
            folder.write({"in/p.toml": f"name = \"rod\"\n{STEEL}[section.s]\ntype = \"circle\"\ndiameter = 0.01\n[node.a]\nposition = [0, 0, 0]\n[node.b]\n"
                                       "position = [1, 0, 0]\n[member.m]\nnodes = [\"a\", \"b\"]\n[interface.a]\n[interface.b]\n[modes]\ncount = 2\n"})
            folder.run(["flexura-reduce", "p.toml", "-q", "-o", "../out/x.h5"])
        else:
            folder.write({"in/m.toml": mechanism(random.Random(0))[0].split("[body", 1)[0] + "[body.b]\nmass = 1\ninertia = [1, 1, 1]\n[joint.j]\n"
                                       "type = \"revolute\"\nfrom = \"ground\"\nto = \"b\"\n[solver]\nend_time = 0.01\n"})
            folder.run(["flexura", "simulate", "m.toml", "-q", "-o", "../out/x.h5"])
        return (folder.path / "out/x.h5").read_bytes()
    finally:
        folder.remove()


def damaged(rng, kind):
    """Names in its headers, attributes and groups made hostile, or a number not finite."""
    memory = io.BytesIO(made(kind))
    with h5py.File(memory, "r+") as file:
        for _ in range(rng.randint(1, 3)):
            nodes = []
            file.visititems(lambda _, node: nodes.append(node))
            node = rng.choice([file, *nodes])
            if rng.random() < 0.3 and node.attrs:
                node.attrs[rng.choice(list(node.attrs))] = np.bytes_(raw(rng) or b"x")
            elif isinstance(node, h5py.Dataset) and node.dtype == np.uint8 and node.size:
                spoil(rng, node)
            elif isinstance(node, h5py.Dataset) and node.dtype.kind == "f" and node.size and rng.random() < 0.5:
                node[tuple(0 for _ in node.shape)] = rng.choice([np.nan, np.inf])
            elif node.name != "/" and rng.random() < 0.3:
                other = node.parent.name.rstrip("/") + "/" + (text(rng, 1).replace("/", "").replace("\0", "") or "x")
                if other not in file:
                    file.move(node.name, other)
    return memory.getvalue()


def spoil(rng, node):
    """Texts of a JSON header, or of whatever the dataset holds."""
    data = bytes(node[()])
    try:
        tree = json.loads(data)
    except ValueError:
        tree = None
    if isinstance(tree, dict):
        hostile(rng, tree)
        data = json.dumps(tree, ensure_ascii=rng.random() < 0.5).encode("utf-8", "surrogatepass")
    else:
        data += raw(rng)
    where, attributes, group = node.name.rsplit("/", 1)[1], dict(node.attrs), node.parent
    del group[where]
    new = group.create_dataset(where, data=np.frombuffer(data, np.uint8), chunks=(max(len(data), 1),), shuffle=True, compression=4, fletcher32=True)
    new.attrs.update(attributes)


def hostile(rng, tree):
    """Some texts of a tree of JSON."""
    items = list(tree.items()) if isinstance(tree, dict) else list(enumerate(tree))
    for key, value in items:
        if isinstance(value, str) and rng.random() < 0.5:
            tree[key] = text(rng)
        elif isinstance(value, (dict, list)):
            hostile(rng, value)
    if isinstance(tree, dict) and rng.random() < 0.2:
        tree[text(rng)] = text(rng)


def superelement_case(rng):
    words, outputs = rng.choice([
        (["modes"], []), (["check"], []), (["modes", "--json"], []), (["check", "--json"], []), (["modes", "--html", "../out/x.html"], ["out/x.html"]),
        (["report", "-o", "../out/x.html"], ["out/x.html"]),
        *[(["export", "--format", f, "-o", "../out/x" + e], ["out"]) for f, e in
          (("matrix-market", ""), ("dmig", ".bdf"), ("sid", ".sid"), ("flexdata", ".xml"), ("vtk", ".vtp"), ("gmsh", ".msh"), ("gltf", ".glb"))]])
    return Case(["flexura", words[0], "x.h5", *words[1:]], {"in/x.h5": damaged(rng, "superelement")}, outputs, "superelement " + words[0])


def results_case(rng):
    words, outputs = rng.choice([(["view", "--summary"], []), (["view", "--summary", "--json"], []), (["view", "-o", "../out/x.html"], ["out/x.html"]),
                                 (["export", "--format", "csv", "-o", "../out/x"], ["out"]), (["export", "--format", "pvd", "-o", "../out/x"], ["out"])])
    return Case(["flexura", words[0], "x.h5", *words[1:]], {"in/x.h5": damaged(rng, "results")}, outputs, "results " + words[0])


def json_case(rng):
    state = {"format": "flexura state", "time": 0, "name": text(rng), "positions": {"j.angle": 0.1, **({text(rng): 1} if rng.random() < 0.3 else {})}, "velocities": {"j.speed": 0}}
    report = {"title": "t", "summary": "s", "sections": [{"title": "a", "blocks": [{"type": "text", "text": "x"}]}], "facts": [["a", "b"]]}
    file = "[body.b]\nmass = 1\ninertia = [1, 1, 1]\n[joint.j]\ntype = \"revolute\"\nfrom = \"ground\"\nto = \"b\"\n"
    if rng.random() < 0.5:
        return Case(["flexura", "statics", "m.toml", "--from-state", "s.json"], {"in/m.toml": file, "in/s.json": json.dumps(state)}, [], "state")
    hostile(rng, report)
    data = json.dumps(report, ensure_ascii=rng.random() < 0.5)
    return Case(["flexura", "report", "r.json", "-o", "../out/r.html"], {"in/r.json": data}, ["out/r.html"], "report")


def study_case(rng):
    quantity, choice = name(rng, 0.2), name(rng, 0.2)
    file = (title(rng) + f"mechanism = \"m.toml\"\nrepeats = 1\n[axis.a.choice.{toml(choice)}]\nset = [\"parameters.x=1\"]\n[axis.a.choice.last]\n"
            f"set = [\"parameters.x=2\"]\n[quantity.{toml(quantity)}]\nof = \"j.angle\"\n[want]\naccuracy = [\"10 %\"]\n")
    mechanism_file = ("[parameters]\nx = 1\n[body.b]\nmass = \"x\"\ninertia = [1, 1, 1]\n[joint.j]\ntype = \"revolute\"\nfrom = \"ground\"\nto = \"b\"\n"
                      "[force.f]\ntype = \"joint_force\"\njoint = \"j\"\nvalue = \"t\"\n[solver]\nend_time = 0.001\n")
    return Case(["flexura", "study", "s.toml", "-o", "../out/s"], {"in/s.toml": file, "in/m.toml": mechanism_file},
                ["out/s.*", "in/study.cache"], "study")


def part_case(rng):
    """Meshes and decks whose sets and materials are hostile."""
    group, kind = line(rng), rng.choice(["msh", "inp", "bdf", "unv", "csv", "mtx"])
    by = rng.choice(["by = \"nodes\"\nnodes = [1, 2, 3]", f"by = \"group\"\ngroup = {toml(text(rng))}"])
    part = title(rng) + f"[geometry]\nfile = \"g.{kind}\"\n{STEEL}[interface.{toml(name(rng, 0.1))}]\n{by}\n"
    mesh = HEX.encode()
    if kind == "msh":
        mesh = mesh.replace(b"$Nodes", b'$PhysicalNames\n1\n3 1 "' + group.replace(b'"', b"") + b'"\n$EndPhysicalNames\n$Nodes', 1)
    elif kind == "inp":
        nodes = b"".join(b"%d, %d, %d, %d\n" % (k + 1, k & 1 ^ (k >> 1 & 1), k >> 1 & 1, k >> 2) for k in range(8))
        mesh = (b"** " + group + b"\n*NODE, NSET=" + group + b"\n" + nodes + b"*ELEMENT, TYPE=C3D8, ELSET=" + group.replace(b",", b"") +
                b"\n1, 1, 2, 3, 4, 5, 6, 7, 8\n*SOLID SECTION, ELSET=" + group.replace(b",", b"") + b", MATERIAL=" + group.replace(b",", b"") + b"\n*MATERIAL, NAME=" + group.replace(b",", b"") +
                b"\n*ELASTIC\n1, 0\n*DENSITY\n1\n*" + group + b"\n")
    elif kind == "bdf":
        mesh = b"$ " + group + b"\n" + group + b"\nBEGIN BULK\nGRID,1,,0.,0.,0.\n" + group + b",1,2\nINCLUDE '" + group + b"'\nENDDATA\n"
    elif kind == "unv":
        mesh = b"    -1\n  2467\n 1 0 0 0 0 0 0 1\n" + group + b"\n 7 1 0 0\n    -1\n"
    elif kind == "csv":
        mesh = b"# " + group + b"\n1,0,0,0\n" + group + b"\n"
    else:
        mesh = gzip.compress(b"%%MatrixMarket matrix coordinate real general\n% " + group + b"\n" + group)
        part = f"[geometry]\nfile = \"n.csv\"\n[matrices]\nstiffness = \"g.mtx\"\nmass = \"g.mtx\"\n[interface.a]\n{by}\n"
    words = rng.choice([["-o", "../out/p.se.h5"], ["-q", "-o", "../out/p.se.h5", "--report", "../out/p.json", "--mesh", "../out/p.inp"]])
    return Case(["flexura-reduce", "p.toml", *words], {"in/p.toml": part, "in/g." + kind: mesh, "in/n.csv": "1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n"},
                ["out/p.se.h5", "out/p.json", "out/p.inp"], "part of " + kind)


def beam_case(rng):
    member, section = name(rng, 0.1), name(rng, 0.1)
    file = (title(rng) + f"{STEEL}[section.{toml(section)}]\ntype = \"circle\"\ndiameter = 0.01\n[node.a]\nposition = [0, 0, 0]\n[node.b]\nposition = [1, 0, 0]\n"
            f"[member.{toml(member)}]\nnodes = [\"a\", \"b\"]\n[interface.a]\n[interface.b]\n[modes]\ncount = 2\n")
    words, outputs = rng.choice([(["-o", "../out/p.se.h5"], ["out/p.se.h5"]), (["--beam-modes", "2"], []), (["--statics"], [])])
    return Case(["flexura-reduce", "p.toml", *words], {"in/p.toml": file}, outputs, "beam part")


def section_case(rng):
    file = title(rng) + STEEL + f"[region.{toml(name(rng, 0.1))}]\npoints = [[0, 0], [0.01, 0], [0.01, 0.02], [0, 0.02]]\n"
    return Case(["flexura-reduce", "section", "s.toml", "-o", "../out/s.section"], {"in/s.toml": file}, ["out/s.section", "out/s.svg"], "section")


def xml(data):
    return data.replace(b"&", b"&amp;").replace(b"<", b"&lt;").replace(b'"', b"&quot;")


def robot_case(rng):
    link, joint, robot = xml(line(rng)), xml(line(rng)), xml(line(rng))
    inertial = b'<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    mesh, data = rng.choice([("m.stl", b"solid " + line(rng) + b"\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"),
                             ("m.obj", b"# " + line(rng) + b"\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n" + line(rng) + b"\n"),
                             ("m.dae", b"<COLLADA><asset>" + xml(line(rng)) + b"</asset><scene/></COLLADA>"),
                             ("m.stl", struct.pack("<80sI", raw(rng)[:80], 0)), ("m.xyz", raw(rng))])
    visual = b'<visual><geometry><mesh filename="' + rng.choice([mesh.encode(), xml(line(rng))]) + b'"/></geometry></visual>'
    bomb = b'<!DOCTYPE r [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>' if rng.random() < 0.2 else b""
    file = (b'<?xml version="1.0"?>' + bomb + b'<robot name="' + robot + b'"><link name="base">' + inertial + b'</link><link name="' + link + b'">' + inertial + visual +
            b'</link><joint name="' + joint + b'" type="' + rng.choice([b"continuous", b"continuous", xml(line(rng))]) + b'"><parent link="base"/><child link="' + link +
            b'"/><axis xyz="0 0 1"/></joint></robot>')
    return Case(["flexura-import", "r.urdf", "-o", "../out/r"], {"in/r.urdf": file, "in/" + mesh: data}, ["out/r"], "robot")


@lru_cache(maxsize=None)
def step():
    """A cube as gmsh and OpenCASCADE know one: the smallest sound file of the tests."""
    return (BIN.parents[2] / "tests/mesh/data/two_touching_one_apart.step").read_bytes()


def cad_case(rng):
    named = line(rng).replace(b"'", b"''")
    file = step().replace(b"PRODUCT('", b"PRODUCT('" + named).replace(b"FILE_NAME('", b"FILE_NAME('" + named)
    words, outputs = rng.choice([(["flexura-reduce", "--list-faces", "a.step"], []),
                                 (["flexura-reduce", "--list-faces", "a.step", "--html", "../out/a.html"], ["out/a.html"]),
                                 (["flexura-import", "a.step", "-o", "../out/a"], ["out/a"])])
    return Case(words, {"in/a.step": file}, outputs, "STEP")


def flexdata_case(rng):
    encoded = "".join(f"%{byte:02X}" for byte in raw(rng))
    file = (f"<?xml version=\"1.0\"?><!-- Flexura: the body's inertia integrals (SI)\ninterface {encoded} -->\n<Reference_FlexData id = \"1\" num_nodes = \"1\" "
            f"num_sel_modes = \"1\" num_sel_nodes = \"1\">\n<ModeData>{text(rng)}</ModeData>\n<NodeData>\n</NodeData>\n</Reference_FlexData>\n")
    return Case(["flexura-reduce", "f.xml", "-o", "../out/f.se.h5"], {"in/f.xml": file}, ["out/f.se.h5"], "FlexData")


def path_case(rng):
    """What the command line itself says."""
    odd = text(rng).replace("\0", "") or "x"
    words = rng.choice([["simulate", odd], ["modes", odd], ["view", odd, "--summary"], ["study", odd], ["report", odd], [odd], ["check", "m.toml", odd], ["help", odd],
                        ["export", odd, "--format", odd], ["completion", odd], ["man", odd], ["new", odd], ["examples", odd], ["reduce", odd], ["import", odd], ["section", odd]])
    return Case(["flexura", *[word if word != odd or not odd.startswith("-") else "./" + odd for word in words]], {}, [], "paths " + words[0])


READERS = [mechanism_case] * 5 + [superelement_case] * 3 + [results_case] * 2 + [json_case] * 2 + [study_case, part_case, part_case, beam_case, section_case,
                                                                                               robot_case, robot_case, cad_case, flexdata_case, path_case, path_case]


def case(rng, _):
    return rng.choice(READERS)(rng)
