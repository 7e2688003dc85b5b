#!/usr/bin/env bash
# check_links.sh PROGRAM: the runtime loads none of the reduction's libraries, directly or through others.
set -euo pipefail
list=$(ldd "$1")
heavy=$(grep -iE 'petsc|slepc|libmpi|openmpi|gmsh|metis|mumps|scotch|cholmod|TK[A-Z]|libopen-(rte|pal)' <<<"$list" || true)
if [[ -n $heavy ]]; then
  echo "$1 links libraries that belong to flexura-reduce:"
  echo "$heavy"
  exit 1
fi
grep -q hdf5_serial <<<"$list" || { echo "$1 does not link the serial HDF5"; exit 1; }
echo "$1 loads $(wc -l <<<"$list") libraries, none of the reduction's"
