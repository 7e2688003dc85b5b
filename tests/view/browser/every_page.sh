#!/usr/bin/env bash
# every_page.sh ROOT OUT: one page of every kind that the programs write, into OUT; the programs are those of the PATH.
set -euo pipefail
root=$1 out=$2
mkdir -p "$out"
cp "$root"/cases/steam_engine/{conrod.step,conrod.toml,engine.toml} "$root"/cases/jib_crane/*.toml "$root"/cases/trade/four_bar.toml "$out"
cp "$root"/cases/switches/bouncing_ball.toml "$root"/cases/macpherson/macpherson.toml "$out"
cp "$root"/tests/found/user/{cant,bar}.toml "$out"
cd "$out"
# Parts: solid with the mesh's error, beams; the report of a reduction from its file and from what --report wrote.
flexura reduce conrod.toml -o conrod.se.h5 --report conrod.report.json -q
flexura modes conrod.se.h5 --html modes_solid.html -q
flexura report conrod.se.h5 -o report_superelement.html -q
flexura report conrod.report.json -o report_reduction.html -q
flexura section jib_section.toml -q
flexura reduce crane.toml -o crane.se.h5 -q
flexura modes crane.se.h5 --html modes_beams.html -q
flexura reduce --list-faces conrod.step --html faces.html >/dev/null
# An assembly with the joints proposed for it.
flexura import "$root/cases/assembly/engine.step" -o assembly -q
cp assembly/assembly.html assembly.html
# Motion: rigid beside flexible, contacts, a loop with markers, a clamped beam, modes of a mechanism.
flexura simulate engine.toml -o engine.h5 -q
flexura view engine.h5 -o motion_engine.html -q
flexura simulate bouncing_ball.toml -o ball.h5 -q
flexura view ball.h5 -o motion_ball.html -q
flexura simulate macpherson.toml -o macpherson.h5 -q
flexura view macpherson.h5 -o motion_suspension.html -q
flexura eigen macpherson.toml --run ride --equilibrium --pictures macpherson_modes.h5 -q
flexura view macpherson_modes.h5 -o modes_suspension.html -q
flexura eigen engine.toml --run flexible --frozen --pictures engine_modes.h5 -q
flexura view engine_modes.h5 -o modes_engine.html -q
flexura reduce bar.toml -o bar.se.h5 -q
flexura simulate cant.toml -o cant.h5 -q
flexura view cant.h5 -o motion_cantilever.html -q
# A mechanism that does not assemble.
cat >short.toml <<'TOML'
name = "short bar"
[ground.marker.left]
[ground.marker.right]
position = [1, 0, 0]
[body.bar]
mass = 1
inertia = [0.001, 0.1, 0.1]
[body.bar.marker.a]
[body.bar.marker.b]
position = [0.5, 0, 0]
[[body.bar.shape]]
type = "cylinder"
from = [0, 0, 0]
to = [0.5, 0, 0]
radius = 0.03
[joint.left]
type = "revolute"
from = "ground.left"
to = "bar.a"
[joint.right]
type = "spherical"
from = "ground.right"
to = "bar.b"
TOML
flexura assemble short.toml -q 2>/dev/null && exit 1
mv ./*.open.html open.html
# A study.
flexura new mechanism -q
flexura new study -q
flexura study study.toml -q
[ -s study.html ]
