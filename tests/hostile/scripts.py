# Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
"""Scripts in the clothes of every format: whatever runs one leaves a file CANARY...

Each case is a file that a reader is given, by its own name or through a part, a mechanism, a study or a robot.
"""

from judge import RUNS_ALONE, Case

HEX = """$MeshFormat
2.2 0 8
$EndMeshFormat
$Nodes
8
1 0 0 0
2 1 0 0
3 1 1 0
4 0 1 0
5 0 0 1
6 1 0 1
7 1 1 1
8 0 1 1
$EndNodes
$Elements
1
1 5 2 1 1 1 2 3 4 5 6 7 8
$EndElements
"""
STEEL = '[material.steel]\nyoung = "210 GPa"\npoisson = 0.3\ndensity = "7850 kg/m^3"\n'
ENDINGS = ["msh", "MSH", "Msh", "stl", "STL", "Stl", "sTL", "step", "STEP", "Stp", "p21", "igs", "IGS", "Iges", "brep", "BREP",
           "Brp", "geo", "GEO", "Geo", "geo_unrolled", "unv", "UNV", "inp", "INP", "bdf", "BDF", "Nas", "dat", "csv", "txt", "py",
           "PY", "m", "M", "exe", "gz", "msh.gz", "stl.gz", "geo.msh", "msh.geo", "opt", "xml", "h5", "pro", "pos", "med", "vtk",
           "mesh", "sat", "x_t", "toml", ""]


def toml(text):
    """A string of TOML, whatever is in it."""
    out = ""
    for letter in text:
        code = ord(letter)
        plain = 0x20 <= code < 0x7F and letter not in '"\\'
        out += letter if plain else f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"
    return f'"{out}"'


def script(rng, place):
    """A script of gmsh's, which can leave a canary in many ways."""
    ways = [f'SystemCall "touch {place}/CANARY_call";', f'NonBlockingSystemCall "touch {place}/CANARY_other";',
            f'Printf("x") > "{place}/CANARY_print";', f'Save "{place}/CANARY_save.msh";', f'Print "{place}/CANARY.geo";',
            'Include "evil.inc";', 'Merge "evil.inc";', f'OnelabRun("x", "touch {place}/CANARY_onelab");',
            f'General.BackgroundImageFileName = "{place}/x"; SystemCall "id > CANARY_id";',
            "Point(1) = {0, 0, 0, 1}; Point(2) = {1, 0, 0, 1}; Line(1) = {1, 2};"]
    return "\n".join(rng.sample(ways, rng.randint(1, 4))) + "\n"


def dressed(rng, body):
    """The same in the clothes of a format."""
    rows = body.replace("\n", "\n  ")
    clothes = [
        body, "//$MeshFormat\n" + body, "/*\n$MeshFormat\n2.2 0 8\n$EndMeshFormat\n*/\n" + body, "\ufeff$MeshFormat\n" + body,
        " $MeshFormat\n" + body, "\n$MeshFormat\n2.2 0 8\n$EndMeshFormat\n" + body, "\r\n" + HEX + body, "$meshformat\n" + body,
        "$MeshFormat\n" + body, HEX + body, HEX.replace("$Nodes", f"$PhysicalNames\n1\n3 1 \"a\n{body}\"\n$EndPhysicalNames\n$Nodes"),
        "$Comments\n" + rows + "\n$EndComments\n" + HEX, "$Comments\n$EndComments\n" + body, "$PTS\n" + body, "$NOD\n1\n" + body,
        "$PARA\n" + body, "$View\n" + body, "$PostFormat\n1.4 0 8\n$EndPostFormat\n" + body, "solid = 1; // facet\n" + body,
        "solid x\nfacet normal 0 0 1\nouter loop\n" + body + "endloop\nendfacet\nendsolid x\n", "SOLID = 1;\n" + body,
        "// ISO-10303-21;\n" + body + "// END-ISO-10303-21;\n", "ISO-10303-21;\nHEADER;\n" + body + "ENDSEC;\nEND-ISO-10303-21;\n",
        "DBRep_DrawableShape\n" + body, "// CASCADE Topology V1, (c) Matra-Datavision\n" + body,
        f"{body.splitlines()[0][:72]:<72}S      1\n" + body, "** deck\n*NODE\n1, 0, 0, 0\n*INCLUDE, INPUT=evil.inc\n" + body,
        "BEGIN BULK\nINCLUDE 'evil.inc'\n" + body, "    -1\n  2411\n" + body + "    -1\n", "#!/bin/sh\ntouch CANARY_sh\n" + body,
        "<?xml version=\"1.0\"?><!-- " + body + " --><Reference_FlexData/>", "%%MatrixMarket matrix coordinate real general\n" + body,
        "\0" + body, body.replace("\n", "\r"), "\x89HDF\r\n\x1a\n" + body]
    return rng.choice(clothes)


def name_of(rng):
    """Also names that a shell would take for more."""
    return rng.choice(["a", "a", "a", "a b", "a;touch CANARY_name;", "$(touch CANARY_name)", "`touch CANARY_name`",
                       "a|touch CANARY_name", "a&touch CANARY_name&", "-o", "a'b", 'a"b', "%s%n", "a\\b", "ünder"])


def through(rng, file):
    """A command that reads the file, and what else lies beside it."""
    q, ways = toml(file), ["faces", "part", "shell", "part", "curves", "curves", "section", "beam solid", "import", "robot", "reduce",
                           "direct", "study", "matrices", "deck", "library", "table"]
    part = f"[geometry]\nfile = {q}\n{STEEL}[interface.a]\nby = \"nodes\"\nnodes = [1, 2, 3]\n"
    beam = f"{STEEL}[section.s]\ntype = \"circle\"\ndiameter = 0.01\n[node.a]\nposition = [0, 0, 0]\n[node.b]\nposition = [1, 0, 0]\n"
    member = "[member.m]\nnodes = [\"a\", \"b\"]\n[interface.a]\n[interface.b]\n"
    body = "[body.b]\nmass = 1\ninertia = [1, 1, 1]\n[joint.j]\ntype = \"revolute\"\nfrom = \"ground\"\nto = \"b\"\n"
    way = rng.choice(ways)
    reduce = ["flexura-reduce", "p.toml", "-q", "-o", "../out/p.se.h5"]
    if way == "faces":
        return Case(["flexura-reduce", "--list-faces", "./" + file], name=way)
    if way == "part":
        return Case(reduce, {"in/p.toml": part}, ["out/p.se.h5"], way)
    if way == "shell":
        return Case(reduce, {"in/p.toml": part + "[shell]\nthickness = 0.01\n"}, ["out/p.se.h5"], way)
    if way == "curves":
        return Case(reduce, {"in/p.toml": f"{beam}[curves.c]\nfile = {q}\n[interface.a]\n[interface.b]\n"}, ["out/p.se.h5"], way)
    if way == "section":
        return Case(["flexura-reduce", "section", "p.toml", "-q", "-o", "../out/p.section"],
                    {"in/p.toml": f"cad = {q}\n{STEEL}"}, ["out/p.section", "out/p.svg"], way)
    if way == "beam solid":
        return Case(reduce, {"in/p.toml": f"{beam}[solid.s]\npart = {q}\n{member}"}, ["out/p.se.h5"], way)
    if way == "import":
        return Case(["flexura-import", "./" + file, "-o", "../out/m"], {}, ["out/m"], way)
    if way == "robot":
        mesh = file.replace("&", "&amp;").replace('"', "&quot;").replace("<", "&lt;")
        robot = ("<robot name=\"r\"><link name=\"l\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\" ixy=\"0\" "
                 f"ixz=\"0\" iyz=\"0\"/></inertial><visual><geometry><mesh filename=\"{mesh}\"/></geometry></visual></link></robot>")
        return Case(["flexura-import", "r.urdf", "-o", "../out/m"], {"in/r.urdf": robot}, ["out/m"], way)
    if way == "reduce":
        mechanism = "[body.b]\nsuperelement = \"p.se.h5\"\nfidelity = \"modal\"\n[joint.j]\ntype = \"revolute\"\nfrom = \"ground\"\nto = \"b.a\"\n"
        return Case(["flexura", "simulate", "m.toml", "--reduce", "-q", "--end-time", "1e-6", "-o", "../out/m.h5"],
                    {"in/p.toml": part, "in/m.toml": mechanism}, ["out/m.h5", "in/reduced"], way)
    if way == "study":
        study = (f"mechanism = \"m.toml\"\nrepeats = 1\n[part.b]\nfile = \"p.toml\"\n[axis.n]\nkey = \"body.b.modes\"\nvalues = [\"1\", \"2\"]\n"
                 "[quantity.a]\nof = \"j.angle\"\n")
        mechanism = "[body.b]\nsuperelement = \"p.se.h5\"\nfidelity = \"modal\"\n[joint.j]\ntype = \"revolute\"\nfrom = \"ground\"\nto = \"b.a\"\n"
        return Case(["flexura", "study", "s.toml", "-q", "-o", "../out/s"],
                    {"in/p.toml": part, "in/m.toml": mechanism, "in/s.toml": study}, ["out/s.*", "in/study.cache"], way)
    if way == "matrices":
        text = f"[geometry]\nfile = \"n.csv\"\n[matrices]\nstiffness = {q}\nmass = {q}\n[interface.a]\nby = \"nodes\"\nnodes = [1, 2, 3]\n"
        return Case(reduce, {"in/p.toml": text, "in/n.csv": "1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n"}, ["out/p.se.h5"], way)
    if way == "library":
        return Case(["flexura", "check", "m.toml"],
                    {"in/m.toml": body + f"[force.f]\ntype = \"user\"\nlibrary = {q}\nelement = \"x\"\n"}, [], way)
    if way == "table":
        return Case(["flexura", "check", "m.toml"], {"in/m.toml": f"[table.t]\nfile = {q}\n" + body}, [], way)
    if way == "deck":
        deck = rng.choice([("d.inp", f"*NODE\n1,0,0,0\n*INCLUDE, INPUT={file}\n"), ("d.bdf", f"BEGIN BULK\nINCLUDE '{file}'\nENDDATA\n")])
        return Case(reduce, {"in/p.toml": part.replace(q, toml(deck[0])), "in/" + deck[0]: deck[1]}, ["out/p.se.h5"], way)
    return Case(["flexura-reduce", "./" + file, "-q", "-o", "../out/p.se.h5"], {}, ["out/p.se.h5"], way)


def case(rng, place):
    body = script(rng, place)
    beside = rng.random() < 0.2  # of a sound mesh
    file = name_of(rng) + "." + rng.choice(["msh", "MSH", "Msh"] if beside else ENDINGS[:16] if rng.random() < 0.6 else ENDINGS)
    made = through(rng, file)
    made.name = f"{made.name}: {file}"
    if beside:
        made.files["in/" + file] = HEX
    elif "in/" + file not in made.files:
        made.files["in/" + file] = dressed(rng, body)
    for neighbour in (file + ".opt", file + ".OPT", "p.toml.opt", "evil.inc", ".petscrc", *RUNS_ALONE):
        made.files.setdefault("in/" + neighbour, body)
    for alone in RUNS_ALONE:
        made.files["home/" + alone] = body
    made.files["home/.petscrc"] = made.files["in/.petscrc"] = f"-log_view :{place}/CANARY_petsc\n-options_view\n"
    return made
