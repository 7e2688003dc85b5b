#!/usr/bin/env bash
# new_files.sh PROGRAMS: what `flexura new` writes runs as it stands; a file that is there is kept.
set -euo pipefail
PATH=$1:$PATH
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
for kind in part beams mechanism study; do flexura new "$kind" -q; done
# What is said to be next takes the file that was written.
said=$(flexura new beams -o tube.toml) && [[ $said == *"next: flexura reduce tube.toml"* ]] || { echo "no next step: $said"; exit 1; }
flexura reduce beams.toml -q
flexura simulate mechanism.toml -q
flexura study study.toml -q
# A study reads its mechanism as `simulate` does: numbers that are formulas of its parameters (above), keys of subsystems.
cat >pair.toml <<'TOML'
[subsystem.left]
file = "mechanism.toml"
[subsystem.right]
file = "mechanism.toml"
position = [0, "1 m", 0]
[solver]
end_time = "0.1 s"
TOML
sed -e 's/mechanism.toml/pair.toml/; s/hinge.angle/left.hinge.angle/' -e 's/^values = .*/values = ["1e-3", "1e-5"]/' study.toml >pairs.toml
cat >>pairs.toml <<'TOML'
[choice.heavy]
set = ["subsystem.left.body.bar.mass=3"]
TOML
flexura study pairs.toml -q
# The part has all keys right; what it lacks is the user's own file.
said=$(flexura reduce part.toml 2>&1) && { echo "a part without its CAD file was reduced"; exit 1; }
[[ $said == *part.step* ]] || { echo "the part was refused for something else: $said"; exit 1; }
cp beams.toml before
said=$(flexura new beams 2>&1) && { echo "a file that was there was replaced"; exit 1; }
[[ $said == *"is there already"* ]] && cmp -s before beams.toml || { echo "not refused as it should be: $said"; exit 1; }
flexura new lathe 2>/dev/null && { echo "an unknown kind was taken"; exit 1; }
# As the comments say: the bar as a flexible body of beams.
sed -e '/^mass = /d; /^center = /d; /^inertia = /d' -e 's/^# superelement/superelement/' -e 's/"bar.pin"/"bar.swivel"/' \
  -e 's/^\[body.bar.marker.pin\]/[body.bar.marker.swivel]\non = "left"/' mechanism.toml >flexible.toml
# A key behind a table's header would be that table's: the superelement goes to the body.
awk '/^superelement/ { next } { print } /^\[body.bar\]$/ { print "superelement = \"beams.se.h5\"" }' flexible.toml >run.toml
flexura simulate run.toml -q
echo "four starts run"
