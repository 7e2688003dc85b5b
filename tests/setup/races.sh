#!/usr/bin/env bash
# races.sh BUILD: every part of ours that has threads, once under helgrind: rows beside the steps, a study's runs side by side,
# the assembly, factorisation, dense products, stress recovery and geometric stiffening of a reduction.  Exit code 9 where it finds a race.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd) build=$(cd "$1" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# BLAS by itself: its threads are not ours.
export OPENBLAS_NUM_THREADS=1
watched() { valgrind --tool=helgrind --error-exitcode=9 -q --suppressions="$root/tests/setup/helgrind.supp" "$@"; }
watched "$build/tests/bin/test_mechanism_runs" --gtest_filter='BackgroundQueue*:*Beside*'
printf '%s\n' "mechanism = \"$root/tests/fuzz/ball.toml\"" "cache = \"$work/cache\"" \
  '[choice.a]' 'set = ["solver.tolerance=1e-5"]' '[choice.b]' 'set = ["solver.tolerance=1e-6"]' \
  '[quantity.x]' 'of = "guide.position"' >"$work/study.toml"
watched "$build/bin/flexura" study "$work/study.toml" -j 2 -o "$work/study" --quiet
watched "$build/bin/flexura-reduce" -q "$root/tests/found/reduce/response_two_frequencies.toml" --set stiffening=true \
  --set recovery.stress=true -o "$work/part.se.h5"
