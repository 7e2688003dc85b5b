#!/usr/bin/env bash
# The document and the page of the tests at the extremes hold what a log of a few cases says: two tests side by side, one
# table with a head and one without, a figure that broke its bound.
set -euo pipefail
generator=$(cd "$(dirname "$0")" && pwd)/extremes_page.mjs
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
cat >"$folder/log" <<'LOG'
test 1
1: [ RUN      ] Extremes.MassRatios
1: | mass ratio of two bodies | 1e-09 | energy error | 5.3e-09 | 1e-05 |
2: ## Tolerance
2: A pendulum for 10 s.
1: | mass ratio of two bodies | 1e+09 | energy error | 7.2e-02 | 1e-05 |
2: | tolerance | error | the program says |
1: ../../tests/mbs/solver/extremes.cpp:22: Failure
1: Expected: (result) < (bound), actual: 0.072 vs 1e-05
1: | mass ratio of two bodies | 1e+09 | energy error | 7.2e-02 | 1e-05 |
2: |---|---|---|
1: [       OK ] Extremes.MassRatios (1747 ms)
2: | 1e-06 | 2.0e-04 | |
2: | 1 | - | error: tolerance is above 0.1 |
3: ## Mass, random from 1e-15 to 1e+15 kg
3: Two periods. Worst error, relative to the amplitude; the bound is 5e-03.
3: | mechanism | ida | radau |
3: |---|---|---|
3: | bar | 8.5e-06 | 3.5e-07 |
3: | wheel | 1.2e-05 | - |
1/2 Test #7: test_extremes ....   Passed
LOG
node "$generator" "$folder/log" "$folder/page.json" "$folder/page.md" 0123abc
expect() { grep -qF -- "$1" "$folder/$2" || { echo "not in $2: $1"; cat "$folder/$2"; exit 1; }; }
expect "Made by \`tests/run extremes\` on $(date -u +%F) at commit 0123abc" page.md
expect '1 of the figures broke its bound (in bold below): mass ratio of two bodies, 1e+09, energy error.' page.md
expect '| extreme | value | what is measured | measured | bound |' page.md
expect '| mass ratio of two bodies | 1e-09 | energy error | 5.3e-09 | 1e-05 |' page.md
expect '| mass ratio of two bodies | 1e+09 | energy error | **7.2e-02** | 1e-05 |' page.md
expect '| 1e-06 | 2.0e-04 |  |' page.md
expect '| Tolerance | 1e-06 | 1e-06 | 2.0e-4 to 2.0e-4 |  | 1 (tolerance is above 0.1) |' page.md
[ "$(grep -cF '7.2e-02' "$folder/page.md")" = 1 ] || { echo "a broken bound stands twice"; exit 1; }
expect '| Mass, random from 1e-15 to 1e+15 kg | 2 | ida, radau | 1.2e-5 | 5e-03 |' page.md
expect '"title": "Flexura at the extremes"' page.json
: >"$folder/empty"
out=$(node "$generator" "$folder/empty" "$folder/none.json" "$folder/none.md" 2>&1) && { echo "an empty log is accepted"; exit 1; }
grep -qF 'no table in the log' <<<"$out" && [ ! -e "$folder/none.md" ] || { echo "wrong: $out"; exit 1; }
echo "the log's figures stand in both"
