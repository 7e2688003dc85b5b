#!/usr/bin/env bash
# check_includes.sh [FOLDER]: who may include whom (the table of CONTRIBUTING.md), and which single folder sees which
# heavy library. Prints each breach as file:line and fails if there is one.
set -euo pipefail
cd "${1:-$(dirname "$0")/../..}"

# folder | what of ours it may include besides itself (longest matching folder counts)
own_rules='
import/model    | mbs/files mbs/math mbs/superelement
import/urdf     | import/model mbs/files mbs/math
import/cad      | import/model mesh/model mesh/gmsh mbs/files mbs/math
import/app      | import mbs/files mbs/input mbs/terminal
mesh/model      |
mesh/gmsh       | mesh/model
mesh/import     | mesh/model mbs/files
mesh/partition  | mesh/model
mesh            | mesh
beam/section    |
beam            | beam
reduce/linalg   | mbs/math
reduce/elements | mesh/model beam
reduce/assembly | mesh/model mesh/partition beam reduce/elements reduce/linalg
reduce/app      | mesh beam reduce mbs/files mbs/superelement mbs/input mbs/terminal
reduce          | mesh/model mesh/partition beam reduce
mbs/files       |
mbs/hdf5        | mbs/files
mbs/input       | mbs/files
mbs/math        |
mbs/superelement| mbs/files mbs/hdf5
mbs/results     | mbs/files mbs/hdf5
mbs/terminal    | mbs/files mbs/hdf5 mbs/input
mbs/view        | mbs/files mbs/superelement mbs/results mbs/terminal
mbs             | mbs beam
'

# header of a library | the files that may see it
library_rules='
gmsh            | mesh/gmsh/
metis           | mesh/partition/
petsc           | reduce/linalg/
slepc           | reduce/linalg/
cholmod         | reduce/linalg/
mpi             | reduce/linalg/ reduce/app/
hdf5            | mbs/hdf5/
H5              | mbs/hdf5/
CLI             | mbs/terminal/
toml\+\+        | mbs/input/
muParser        | mbs/model/ reduce/app/force_field.cpp
tinyxml2        | import/urdf/
STEP            | import/cad/
XCAF            | import/cad/
xxhash          | mbs/input/
spdlog          | mbs/app/ reduce/app/
'

breaches=0
breach() { echo "$1"; breaches=$((breaches + 1)); }
starts_with_any() { local path=$1; shift; local p; for p in "$@"; do [[ $path == "$p" || $path == "$p"/* || ($p == */ && $path == "$p"*) ]] && return 0; done; return 1; }

mapfile -t files < <(find import mesh beam reduce mbs \( -name '*.hpp' -o -name '*.cpp' -o -name '*.h' \) -not -path '*/node_modules/*' | sort)

# Of ours: `#include "folder/..."`.
while IFS=: read -r file line text; do
  target=${text#*\"}; target=${target%%\"*}
  own=${file%/*}; best= allowed=
  while IFS='|' read -r folder may; do
    folder=${folder// /}
    [[ -n $folder ]] && starts_with_any "$file" "$folder" && ((${#folder} > ${#best})) && { best=$folder; allowed=$may; }
  done <<<"$own_rules"
  # shellcheck disable=SC2086
  starts_with_any "$target" "$own" "$best" $allowed ||
    breach "$file:$line: includes \"$target\"; $best may include itself${allowed:+ and}$allowed"
done < <(grep -nHE '^[[:space:]]*#[[:space:]]*include[[:space:]]*"' "${files[@]}")

# Of others: `#include <header>`; a header of ours that shows a heavy library stays inside its folder.
while IFS='|' read -r header where; do
  header=${header// /}
  [[ -n $header ]] || continue
  while IFS=: read -r file line _; do
    [[ -n $file ]] || continue
    # shellcheck disable=SC2086
    if ! starts_with_any "$file" $where; then
      breach "$file:$line: includes a header of ${header//\\/}; only$where may"
    elif [[ $file == *.hpp || $file == *.h ]]; then
      while IFS=: read -r user user_line _; do
        [[ -n $user ]] || continue
        [[ ${user%/*} == "${file%/*}" && $user == *.cpp ]] ||
          breach "$user:$user_line: includes $file, which shows ${header//\\/}; only .cpp files beside it may"
      done < <(grep -nHF "\"$file\"" "${files[@]}" || true)
    fi
  done < <(grep -nHE "^[[:space:]]*#[[:space:]]*include[[:space:]]*[<\"]${header}" "${files[@]}" || true)
done <<<"$library_rules"

((breaches == 0)) || { echo "$breaches breaches of the include boundaries"; exit 1; }
echo "include boundaries hold in ${#files[@]} files"
