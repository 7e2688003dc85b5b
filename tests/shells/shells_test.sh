#!/usr/bin/env bash
# shells_test.sh PROGRAMS: zsh and fish themselves complete what `flexura completion` prints; man(1)'s formatter takes the pages
# of all commands; examples are listed and copied; notes are folded where $COLUMNS says how wide.
set -uo pipefail
PATH=$1:$PATH
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit 1
failures=0
expect() { # expect NAME WANTED FOUND: a line of FOUND is WANTED
  grep -qxF -- "$2" <<<"$3" || { echo "$1: no line '$2' in:"; head -20 <<<"$3"; failures=$((failures + 1)); }
}
refuse() { # refuse NAME LINE FOUND
  if grep -qF -- "$2" <<<"$3"; then echo "$1: '$2' is offered, too"; failures=$((failures + 1)); fi
}

# fish: complete -C gives what the Tab key would offer.
flexura completion fish >flexura.fish
offers() { fish --no-config -c "source flexura.fish; complete -C '$1'" | cut -f1; }
expect "fish, commands" modes "$(offers 'flexura mo')"
expect "fish, options" --held "$(offers 'flexura modes --he')"
expect "fish, choices" dmig "$(offers 'flexura export beam --format d')"
expect "fish, asked of flexura-reduce" --mesh-size "$(offers 'flexura reduce --mesh-s')"
expect "fish, of help" modes "$(offers 'flexura help mod')"
refuse "fish" --held "$(offers 'flexura simulate --he')"

# zsh: its own functions are replaced by ones that print what they are given.
flexura completion zsh >_flexura
zoffers() { # the words of the line
  zsh -f -c '
    compdef() { }
    _describe() { while [[ $1 == -* ]]; do [[ $1 == -o ]] && shift; shift 0; break; done; [[ $1 == -o ]] && shift
                  local list=$argv[-1]; print -l -- ${(P)list} }
    _files() { print files }
    source ./_flexura
    words=('"$1"') CURRENT='"$2"'
    _flexura' | sed 's/:.*//'
}
expect "zsh, commands" modes "$(zoffers 'flexura mo' 2)"
expect "zsh, options" --held "$(zoffers 'flexura modes --he' 3)"
expect "zsh, choices" dmig "$(zoffers 'flexura export beam --format d' 5)"
expect "zsh, files" files "$(zoffers 'flexura modes be' 3)"
expect "zsh, asked of flexura-reduce" --mesh-size "$(zoffers 'flexura reduce --me' 3)"
refuse "zsh" --held "$(zoffers 'flexura simulate --he' 3)"
zsh -n _flexura || failures=$((failures + 1))

# A page for each command: man's formatter finds nothing to warn of, and the page has its parts.
for command in $(flexura --help | sed -n '/^Commands:/,/^$/s/^  \([a-z]*\)  .*/\1/p'); do
  page=$(flexura man "$command")
  if said=$(groff -man -Tutf8 -P-cbou -ww <<<"$page" 2>&1 >page.txt) && [ -z "$said" ]; then :; else
    echo "man $command: $said"; failures=$((failures + 1))
  fi
  for part in NAME SYNOPSIS DESCRIPTION; do grep -q "$part" page.txt || { echo "man $command: no $part"; failures=$((failures + 1)); }; done
  grep -q -- "--help\|--verbose" page.txt || { echo "man $command: no options"; failures=$((failures + 1)); }
done

# Examples.
listed=$(COLUMNS=80 flexura examples)
[ "$(grep -c '^[a-z_]* ' <<<"$listed")" -ge 20 ] || { echo "too few examples: $listed"; failures=$((failures + 1)); }
awk 'length > 80 { print "longer than 80: " $0; bad = 1 } END { exit bad }' <<<"$listed" || failures=$((failures + 1))
! grep -q '^[a-z_]*  *$' <<<"$listed" || { echo "an example without its question: $listed"; failures=$((failures + 1)); }
flexura examples switches -q && (cd switches && CASE=$PWD OUT=$PWD ./run >/dev/null) && [ -s switches/bouncing_ball.html ] || {
  echo "the copied example does not run"; failures=$((failures + 1)); }
said=$(flexura examples switches 2>&1) && { echo "a folder that is there was replaced"; failures=$((failures + 1)); }
[[ $said == *"is there already"* ]] || { echo "not said why: $said"; failures=$((failures + 1)); }
said=$(flexura examples swiches 2>&1) && { echo "an unknown example was taken"; failures=$((failures + 1)); }
[[ $said == *'did you mean "switches"'* ]] || { echo "not said what was meant: $said"; failures=$((failures + 1)); }

# Sentences: folded to the columns that are given, one line in a pipe without.
long=$(COLUMNS=60 flexura simulate nothing_by_this_long_name_is_in_this_folder.toml 2>&1)
awk 'length > 60 && / / { bad = 1 } END { exit bad || NR < 2 }' <<<"$long" || { echo "not folded: $long"; failures=$((failures + 1)); }
[ "$(env -u COLUMNS flexura simulate nothing_by_this_long_name_is_in_this_folder.toml 2>&1 | wc -l)" = 1 ] || {
  echo "folded in a pipe"; failures=$((failures + 1)); }
[ $failures -eq 0 ] && echo "two shells complete, every command has its page, examples run"
