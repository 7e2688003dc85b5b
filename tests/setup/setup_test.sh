#!/usr/bin/env bash
# setup_test.sh SETUP: what tests/setup/setup.sh does where apt-get is busy, and where it fails: with a stub in its place.
set -uo pipefail
setup=$1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir "$folder/bin"
cat >"$folder/bin/apt-get" <<'STUB'
#!/bin/sh
echo "$*" >>"$CALLS"
n=$(wc -l <"$CALLS")
if [ "$n" -le "$BUSY" ]; then echo "E: Could not get lock /var/lib/apt/lists/lock. It is held by process 42 (apt-get)" >&2; exit 100; fi
[ -z "$BROKEN" ] || { echo "E: Unable to locate package" >&2; exit 100; }
STUB
printf '#!/bin/sh\nexit 1\n' >"$folder/bin/dpkg-query"   # nothing is installed
printf '#!/bin/sh\nexec "$@"\n' >"$folder/bin/sudo"
chmod +x "$folder"/bin/*
export PATH="$folder/bin:$PATH" TMPDIR="$folder" FLEXURA_APT_PAUSE=0.05 CALLS="$folder/calls" BUSY BROKEN
fail() { echo "$1"; exit 1; }
try() { # try BUSY BROKEN: what installing a group says
  BUSY=$1 BROKEN=$2
  : >"$CALLS"
  bash -c ". '$setup'; install_packages packages" 2>&1
}
said=$(try 3 "") || fail "a busy package manager was not waited for: $said"
[ "$(grep -c waiting <<<"$said")" = 1 ] || fail "that it waits is said once: $said"
[ "$(grep -c update "$CALLS")" = 4 ] && [ "$(grep -c install "$CALLS")" = 1 ] || fail "calls: $(cat "$CALLS")"
said=$(try 0 "") && ! grep -q waiting <<<"$said" || fail "it waits for nothing: $said"
said=$(try 0 yes) && fail "a failure was taken for success"
grep -q "Unable to locate package" <<<"$said" && grep -q "^error: " <<<"$said" || fail "not said why: $said"
said=$(FLEXURA_APT_WAIT=-1 try 99 "") && fail "it waited without an end"
echo "waits while busy, fails where it must"
