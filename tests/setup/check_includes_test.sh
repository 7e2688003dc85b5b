#!/usr/bin/env bash
# The include check notices each kind of breach: a copy of the tree in miniature, one wrong line at a time.
set -euo pipefail
check=$(cd "$(dirname "$0")" && pwd)/check_includes.sh
tree=$(mktemp -d); trap 'rm -rf "$tree"' EXIT
mkdir -p "$tree"/{import/model,mesh/model,mesh/gmsh,beam/section,beam/ancf,reduce/linalg/petsc,reduce/linalg/eigen,reduce/cms,mbs/mechanism/range,mbs/forces,mbs/superelement,mbs/solver/run}
good() { printf '#include "mesh/model/mesh.hpp"\n' >"$tree/mesh/gmsh/worker.cpp"
         printf '#include <petsc.h>\n' >"$tree/reduce/linalg/petsc/petsc_check.hpp"
         printf '#include "reduce/linalg/petsc/petsc_check.hpp"\n' >"$tree/reduce/linalg/eigen/solve.cpp"
         find "$tree" -name "bad.*" -delete; }
good
bash "$check" "$tree" >/dev/null || { echo "a tidy tree is refused"; exit 1; }
expect() { # file, line, words
  printf '%s\n' "$2" >"$tree/$1"
  out=$(bash "$check" "$tree") && { echo "not noticed: $1: $2"; exit 1; }
  grep -qF "$3" <<<"$out" || { echo "wrong words for $1: $out"; exit 1; }
  good
}
expect mbs/mechanism/bad.cpp '#include "reduce/cms/modes.hpp"' 'mbs/mechanism/bad.cpp:1: includes "reduce/cms/modes.hpp"'
expect mbs/mechanism/bad.hpp '  #  include "mesh/model/mesh.hpp"' 'mbs/mechanism may include itself and'
expect mbs/mechanism/bad.cpp '#include "mbs/app/commands.hpp"' 'mbs/mechanism may include itself and'
expect mbs/mechanism/bad.cpp '#include "mbs/mechanism/range/linear_range.hpp"' 'mbs/mechanism may include itself and'
expect mbs/mechanism/range/bad.cpp '#include "mbs/solver/run/run.hpp"' 'mbs/mechanism/range may include itself and'
expect mbs/forces/bad.cpp '#include "mbs/file/elements/read_context.hpp"' 'mbs/forces may include itself and'
expect mbs/solver/run/bad.cpp '#include "mbs/view/pages.hpp"' 'mbs/solver/run may include itself and'
expect beam/section/bad.cpp '#include "mbs/superelement/file.hpp"' 'beam/section may include itself'
expect beam/ancf/bad.cpp '#include "mbs/mechanism/mechanism.hpp"' 'beam/ancf may include itself'
expect reduce/cms/bad.cpp '#include "mbs/superelement/file.hpp"' 'reduce/cms may include itself'
expect reduce/cms/bad.cpp '#include "reduce/file/part_file.hpp"' 'reduce/cms may include itself'
expect mesh/model/bad.cpp '#include "mesh/gmsh/cad.hpp"' 'mesh/model may include itself'
expect mbs/mechanism/bad.cpp '#include <petscmat.h>' 'includes a header of petsc'
expect reduce/cms/bad.cpp '#include <slepceps.h>' 'includes a header of slepc'
expect import/model/bad.cpp '#include <tinyxml2.h>' 'includes a header of tinyxml2'
expect mesh/model/bad.cpp '#include <gmsh.h>' 'includes a header of gmsh'
expect reduce/linalg/eigen/bad.hpp '#include "reduce/linalg/petsc/petsc_check.hpp"' 'which shows petsc'
expect mbs/superelement/bad.cpp '#include <hdf5.h>' 'only mbs/base/hdf5/ may'
expect mesh/model/bad.cpp 'auto n = a.cross(b);' 'without <Eigen/Geometry>'
echo "each breach is noticed"
