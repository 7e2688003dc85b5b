#!/usr/bin/env bash
# packages_test.sh BUILD: makes the Debian packages, unpacks them into a folder of their own and works with what is there:
# a mechanism, a reduction, the Python package, a C++ project.  Their dependencies are packages of Debian.
set -euo pipefail
build=$1
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d); trap 'rm -rf "$work"' EXIT
fail() { echo "error: $*" >&2; exit 1; }
(cd "$build" && cpack -B "$work/debs" >"$work/cpack.log" 2>&1) || { cat "$work/cpack.log"; exit 1; }
ls -l "$work"/debs/*.deb
for name in flexura flexura-reduce libflexura-dev python3-flexura; do
  deb=$(ls "$work/debs/${name}"_*.deb)
  dpkg-deb -x "$deb" "$work/root"
  depends=$(dpkg-deb -f "$deb" Depends)
  echo "$name depends on: $depends"
  for package in $(sed -e 's/([^)]*)//g' -e 's/|[^,]*//g' -e 's/,/ /g' <<<"$depends"); do
    [[ $package == flexura* ]] || apt-cache show "$package" >"$work/shown" 2>&1 || fail "$name depends on $package, which Debian does not have"
  done
done
dpkg-deb -f "$(ls "$work"/debs/flexura_*.deb)" Depends | grep -qE 'petsc|slepc|gmsh|mpi' && fail "the runtime's package brings heavy ones"
export PATH="$work/root/usr/bin:$PATH"
cd "$work"
flexura --version
for page in flexura flexura-modes flexura-reduce; do [ -s "$work/root/usr/share/man/man1/$page.1.gz" ] || fail "no manual page $page"; done
for file in bash-completion/completions/flexura zsh/vendor-completions/_flexura fish/vendor_completions.d/flexura.fish; do
  [ -s "$work/root/usr/share/$file" ] || fail "no completion $file"
done
flexura examples switches -q
flexura simulate switches/bouncing_ball.toml -o ball.h5 -q
flexura new mechanism -o start.toml -q
flexura simulate start.toml -o start.h5 -q
flexura new beams -o beams.toml -q
flexura reduce beams.toml -o beams.se.h5 -q
flexura modes beams.se.h5 | head -5
PYTHONPATH="$work/root/usr/lib/python3/dist-packages" /usr/bin/python3 -c 'import flexura; print(list(flexura.read_results("start.h5"))[:3])'
cp -r "$here/consumer" consumer
# The package's own prefix, /usr, is not here.
cmake -S consumer -B consumer/build -DCMAKE_PREFIX_PATH="$work/root/usr" -DCMAKE_BUILD_TYPE=Release >configure.log || { cat configure.log; exit 1; }
cmake --build consumer/build >build.log || { cat build.log; exit 1; }
consumer/build/consumer
if grep -rlF "$(cd "$here/../.." && pwd)" root/usr/lib root/usr/share; then fail "these name the source tree"; fi
echo "the packages work"
