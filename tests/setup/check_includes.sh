#!/usr/bin/env bash
# check_includes.sh [FOLDER]: who may include whom (the table of CONTRIBUTING.md), and which single folder sees which
# heavy library. Prints each breach as file:line and fails if there is one.
set -euo pipefail
here=$(cd "$(dirname "$0")/../.." && pwd)
cd "${1:-$here}"

# folder | what it says | what of ours it may include besides itself (longest matching folder counts)
own_rules=$(sed -n '/^```rooms$/,/^```$/p' "$here/CONTRIBUTING.md" | grep -v '^```')
[[ -n $own_rules ]] || { echo "CONTRIBUTING.md has no table of rooms"; exit 1; }

# header of a library | the files that may see it
library_rules='
gmsh            | mesh/gmsh/
metis           | mesh/partition/
petsc           | reduce/linalg/
slepc           | reduce/linalg/
cholmod         | reduce/linalg/
mpi             | reduce/linalg/
hdf5            | mbs/base/hdf5/
H5              | mbs/base/hdf5/
CLI             | mbs/base/terminal/
toml\+\+        | mbs/base/documents/
tinyxml2        | import/urdf/ import/xml/
STEP            | import/cad/
fcl             | mbs/proximity/
XCAF            | import/cad/
xxhash          | mbs/base/documents/
spdlog          | mbs/app/ reduce/app/
'

breaches=0
breach() { echo "$1"; breaches=$((breaches + 1)); }
starts_with_any() { local path=$1; shift; local p; for p in "$@"; do [[ $path == "$p" || $path == "$p"/* || ($p == */ && $path == "$p"*) ]] && return 0; done; return 1; }

# A room includes only rooms that stand above it: so there are no circles.
above=
while IFS='|' read -r folder _ may; do
  folder=${folder// /}
  for room in $may; do
    [[ $folder == "$room" || $folder == "$room"/* ]] && continue  # a folder's own family
    for other in $above; do [[ $other == "$room" || $other == "$room"/* ]] && continue 2; done
    breach "CONTRIBUTING.md: $folder may not include $room, which does not stand above it"
  done
  above+=" $folder"
done <<<"$own_rules"

mapfile -t files < <(find import mesh beam reduce mbs \( -name '*.hpp' -o -name '*.cpp' -o -name '*.h' \) -not -path '*/node_modules/*' | sort)

# Of ours: `#include "folder/..."`.
while IFS= read -r line; do
  [[ -n $line ]] && breach "$line"
done < <({ echo "$own_rules"; echo "==="; grep -nHE '^[[:space:]]*#[[:space:]]*include[[:space:]]*"' "${files[@]}"; } | awk '
  function within(path, folder) { return path == folder || index(path, folder "/") == 1 }
  function room_of(path,   n, best) {
    best = ""
    for (n in may) if (within(path, n) && length(n) > length(best)) best = n
    return best
  }
  /^===$/ { reading = 1; next }
  !reading { split($0, cell, "|"); gsub(/ /, "", cell[1]); may[cell[1]] = cell[3]; next }
  {
    split($0, at, ":"); split($0, quoted, "\"")
    file = at[1]; target = quoted[2]; from = room_of(file); to = room_of(target)
    if (from == "") { print file ": stands in no room of the table"; next }
    # Beside itself: what has no folder stands beside it.
    if (index(target, "/") == 0 || (to == from && to != "")) next
    n = split(may[from], allowed, " ")
    for (i = 1; i <= n; ++i) if (within(target, allowed[i])) next
    list = may[from]; gsub(/^ +| +$/, "", list)
    print file ":" at[2] ": includes \"" target "\"; " from " may include itself" (list == "" ? "" : " and " list)
  }')

# Each header is there: one that is not shows only where its file is compiled.
while IFS=: read -r file line rest; do
  target=${rest#*\"}; target=${target%%\"*}
  [[ $target != */* || -e $target ]] || breach "$file:$line: includes \"$target\", which does not exist"
done < <(if [[ $PWD == "$here" ]]; then grep -nHE '^[[:space:]]*#[[:space:]]*include[[:space:]]*"' "${files[@]}"; fi)

# Of others: `#include <header>`; a header of ours that shows a heavy library stays inside that folder.
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
        # shellcheck disable=SC2086
        { starts_with_any "$user" $where && [[ $user == *.cpp ]]; } ||
          breach "$user:$user_line: includes $file, which shows ${header//\\/}; only .cpp files in$where may"
      done < <(grep -nHF "\"$file\"" "${files[@]}" || true)
    fi
  done < <(grep -nHE "^[[:space:]]*#[[:space:]]*include[[:space:]]*[<\"]${header}" "${files[@]}" || true)
done <<<"$library_rules"

# Precompiled headers hide that a file lacks Eigen's geometry: without them its programs do not link.
while IFS= read -r file; do
  grep -qE '#[[:space:]]*include[[:space:]]*<Eigen/(Geometry|Dense)>' "$file" ||
    breach "$file: uses cross products or rotations of Eigen without <Eigen/Geometry>"
done < <(printf '%s\n' "${files[@]}" | grep -v '^mbs/' | xargs -r grep -lE '\.cross\(|AngleAxisd|Quaterniond|unitOrthogonal\(' || true)

((breaches == 0)) || { echo "$breaches breaches of the include boundaries"; exit 1; }
echo "include boundaries hold in ${#files[@]} files"
