#!/usr/bin/env bash
# tidy.sh BUILD [PATTERN]: clang-tidy with the checks of .clang-tidy over all that BUILD, a built folder, compiles (or only files whose
# path matches PATTERN); prints findings and fails if there are any. As many at a time as there are processors.
set -uo pipefail
build=$1 pattern=${2:-.}
[ -s "$build/compile_commands.json" ] || { echo "error: $build has no compile_commands.json; configure it anew" >&2; exit 1; }
command -v clang-tidy-16 >/dev/null || { echo "error: there is no clang-tidy-16; tests/run tidy installs it" >&2; exit 1; }
mapfile -t files < <(sed -n 's/^ *"file": "\(.*\)".*/\1/p' "$build/compile_commands.json" | grep -E '\.(cpp|cxx)$' | grep -E "$pattern" | sort -u)
((${#files[@]} > 0)) || { echo "error: nothing that is compiled in $build matches '$pattern'" >&2; exit 1; }
echo "${#files[@]} files ..."
printf '%s\0' "${files[@]}" | xargs -0 -n 4 -P "$(nproc)" clang-tidy-16 -p "$build" --quiet 2>/dev/null || { echo "clang-tidy has findings"; exit 1; }
echo "clang-tidy has no findings"
