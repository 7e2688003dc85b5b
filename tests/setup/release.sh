#!/usr/bin/env bash
# release.sh BUNDLE OUT: the release archive OUT/flexura-VERSION.tar.gz: the sources of HEAD and the finished bundle of the pages
# (BUNDLE, of a build), so that it builds without network and without Node.
set -euo pipefail
bundle=$1 out=$2
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
version=$(sed -n 's/^project(flexura VERSION \([0-9.]*\).*/\1/p' "$root/CMakeLists.txt")
for name in page.js page.css report.js report.css; do
  [ -s "$bundle/$name" ] || { echo "error: $bundle/$name is not there or empty: build with Node and npm first" >&2; exit 1; }
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
top=flexura-$version
mkdir -p "$out" "$work/$top/mbs/view/web/bundle"
git -C "$root" archive --prefix="$top/" HEAD | tar -x -C "$work"
cp "$bundle"/{page.js,page.css,report.js,report.css} "$work/$top/mbs/view/web/bundle/"
tar -C "$work" --sort=name --owner=0 --group=0 --numeric-owner --mtime="$(git -C "$root" log -1 --format=%cI)" -c "$top" | gzip -9n >"$out/$top.tar.gz"
echo "$out/$top.tar.gz"
