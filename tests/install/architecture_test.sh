#!/usr/bin/env bash
# architecture_test.sh SOURCE COMPILER: does what docs/architecture.md says of a new force and of a new fidelity, to the letter,
# in a copy of the few files it names, and compiles what it made.  What the fidelity does is shown by sample_fidelity_test.cpp.
set -euo pipefail
source=$1 compiler=$2
work=$(mktemp -d); trap 'rm -rf "$work"' EXIT
mkdir -p "$work/mbs/forces" "$work/mbs/file/elements" "$work/mbs/bodies"
block() { awk -v n="$1" '/^```cpp$/ { ++k; next } /^```$/ { if (k == n) exit; next } k == n' "$source/docs/architecture.md"; }
block 1 >"$work/mbs/forces/coulomb_charge.hpp"
block 2 >"$work/entry.txt"
grep -q 'class CoulombCharge' "$work/mbs/forces/coulomb_charge.hpp" && grep -q '^ForceType coulomb_charge' "$work/entry.txt" ||
  { echo "docs/architecture.md does not hold the sample"; exit 1; }
# The entry beside the others, its name in the list.
awk -v entry="$work/entry.txt" '
  /^}  \/\/ namespace$/ && !done { while ((getline line < entry) > 0) print line; print ""; done = 1 }
  { print }' "$source/mbs/file/elements/forces.cpp" |
  sed -e 's#^\#include "mbs/forces/bushing.hpp"#&\n\#include "mbs/forces/coulomb_charge.hpp"#' \
      -e 's#std::vector<ForceType> list = {#&coulomb_charge(), #' >"$work/mbs/file/elements/forces.cpp"
grep -q 'coulomb_charge(), ' "$work/mbs/file/elements/forces.cpp" || { echo "force_types() has no such list any more"; exit 1; }
"$compiler" -std=c++20 -fsyntax-only -Wall -Wextra -I "$work" -I "$source" -isystem /usr/include/eigen3 "$work/mbs/file/elements/forces.cpp"
# The fidelity: a header, a maker, a line.
block 3 >"$work/mbs/bodies/lumped_bar.hpp"
block 4 >"$work/maker.txt"
block 5 >"$work/line.txt"
grep -q 'class LumpedBar' "$work/mbs/bodies/lumped_bar.hpp" && grep -q '^Segments lumped_bar' "$work/maker.txt" &&
  grep -q '"lumped_bar"' "$work/line.txt" || { echo "docs/architecture.md does not hold the sample of a fidelity"; exit 1; }
awk -v maker="$work/maker.txt" -v entry="$work/line.txt" '
  /^}  \/\/ namespace$/ && !done { while ((getline line < maker) > 0) print line; print ""; done = 1 }
  { print }
  /static const std::vector<Fidelity> all = {/ { while ((getline line < entry) > 0) print line; listed = 1 }
  END { exit !listed }' "$source/mbs/file/fidelities.cpp" |
  sed -e 's#^\#include "mbs/bodies/one_way_body.hpp"#\#include "mbs/bodies/lumped_bar.hpp"\n&#' >"$work/mbs/file/fidelities.cpp"
grep -q 'lumped_bar.hpp' "$work/mbs/file/fidelities.cpp" || { echo "fidelities.cpp has no such list any more"; exit 1; }
"$compiler" -std=c++20 -fsyntax-only -Wall -Wextra -I "$work" -I "$source" -isystem /usr/include/eigen3 "$work/mbs/file/fidelities.cpp"
# They may stand where they stand.
cp -r "$source/CONTRIBUTING.md" "$work/"
bash "$source/tests/setup/check_includes.sh" "$work"
