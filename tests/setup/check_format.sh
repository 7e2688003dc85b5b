#!/usr/bin/env bash
# check_format.sh: the tracked C and C++ sources are as clang-format (Debian 12's, version 14) writes them; prints each place that is
# not, and fails. What it says is mended by `clang-format -i FILE`; a table or matrix keeps its rows by `//` at their ends.
set -euo pipefail
cd "$(dirname "$0")/../.."
command -v clang-format >/dev/null || { echo "clang-format is not installed (apt-get install clang-format): not checked"; exit 77; }
git rev-parse --is-inside-work-tree >/dev/null 2>&1 || { echo "no checkout of git: not checked"; exit 77; }
git ls-files -z -- '*.cpp' '*.hpp' '*.c' '*.h' | xargs -0 -n 40 -P "$(nproc)" clang-format --dry-run -Werror
echo "all sources are as clang-format writes them"
