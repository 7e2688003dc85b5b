#!/usr/bin/env bash
# release_test.sh BUILD: the release archive is configured and its pages are bundled without Node; without the bundle too, and then
# the configuration says what is missing. (`tests/run packages` builds it whole.)
set -euo pipefail
build=$1
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() { echo "error: $*" >&2; exit 1; }
archive=$("$here/../setup/release.sh" "$build/mbs/view/bundle" "$work")
tar -xzf "$archive" -C "$work"
sources=${archive%.tar.gz}
bundle() { # bundle WORK: as the build does, without Node and npm
  cmake -DWEB="$sources/mbs/view/web" -DWORK="$1" -DNODE= -DNPM= -P "$sources/mbs/view/bundle.cmake" 2>&1
}
said=$(bundle "$work/with") || fail "with the bundle: $said"
for name in page.js page.css report.js report.css; do
  cmp "$build/mbs/view/bundle/$name" "$work/with/$name" || fail "$name is another one"
done
rm -r "$sources/mbs/view/web/bundle"
said=$(bundle "$work/without") || fail "without the bundle the build stops: $said"
[[ $said == *"without their pages"*"Node and npm are missing"* ]] || fail "not said what is missing: $said"
[ -e "$work/without/page.js" ] && [ ! -s "$work/without/page.js" ] || fail "no empty bundle"
echo "the release archive needs no Node"
