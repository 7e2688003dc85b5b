#!/usr/bin/env bash
# consumer_test.sh BUILD COMPILER: installs the library into a folder of its own, builds a project outside the tree
# against it, runs its mechanism with its own force element.
set -euo pipefail
build=$1 compiler=$2
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d); trap 'rm -rf "$work"' EXIT
cmake --install "$build" --prefix "$work/usr" --component development >"$work/install.log" || { cat "$work/install.log"; exit 1; }
cp -r "$here/consumer" "$work/consumer"
cmake -S "$work/consumer" -B "$work/build" -DCMAKE_PREFIX_PATH="$work/usr" -DCMAKE_CXX_COMPILER="$compiler" -DCMAKE_BUILD_TYPE=Release >"$work/configure.log" ||
  { cat "$work/configure.log"; exit 1; }
cmake --build "$work/build" >"$work/build.log" || { cat "$work/build.log"; exit 1; }
"$work/build/consumer"
"$work/build/native"
python3 -c 'import ctypes, sys; sys.exit(ctypes.CDLL(sys.argv[1]).run_down())' "$work/build/libwheel.so"
# Who goes past the package with another alignment is stopped by the linker, whatever the machine.
if "$compiler" -std=c++20 -DEIGEN_MAX_ALIGN_BYTES=64 -I "$work/usr/include/flexura" -isystem /usr/include/eigen3 "$work/consumer/main.cpp" \
  -o "$work/unlike" "$work/usr/lib/flexura/libflexura_library.a" >"$work/unlike.log" 2>&1; then echo "a program of another alignment is linked"; exit 1; fi
grep -q 'is_compiled_as_the_library<64' "$work/unlike.log" || { tail -20 "$work/unlike.log"; exit 1; }
cmake -S "$work/consumer" -B "$work/reduction" -DWITH_REDUCTION=ON -DCMAKE_PREFIX_PATH="$work/usr" -DCMAKE_CXX_COMPILER="$compiler" -DCMAKE_BUILD_TYPE=Release >"$work/configure.log" ||
  { cat "$work/configure.log"; exit 1; }
cmake --build "$work/reduction" >"$work/build.log" || { cat "$work/build.log"; exit 1; }
"$work/reduction/reduced_rod"
# What docs/howto/cpp.md shows, as it stands there: its project, its part, its programs, and what they print.
page=$here/../../docs/howto/cpp.md
block() { awk -v kind="$1" -v n="$2" '$0 == "```" kind { ++k; inside = 1; next } /^```$/ { inside = 0 } inside && k == n' "$page"; }
mkdir "$work/page"
block cmake 1 >"$work/page/CMakeLists.txt"
block toml 1 >"$work/page/arm.toml"
block cpp 1 >"$work/page/arm.cpp"
block cpp 2 >"$work/page/reduce_arm.cpp"
block toml 2 >"$work/page/cart.toml"
block cpp 3 >"$work/page/within.cpp"
block cpp 4 >"$work/page/loop.cpp"
printf 'foreach(one within loop)\nadd_executable(${one} ${one}.cpp)\ntarget_link_libraries(${one} PRIVATE Flexura::mbs)\nendforeach()\n' >>"$work/page/CMakeLists.txt"
cd "$work/page"
cmake -S . -B build -DCMAKE_PREFIX_PATH="$work/usr" -DCMAKE_CXX_COMPILER="$compiler" -DCMAKE_CXX_FLAGS="-Wall -Wextra -Werror" -DCMAKE_BUILD_TYPE=Release >"$work/configure.log" ||
  { cat "$work/configure.log"; exit 1; }
cmake --build build >"$work/build.log" || { cat "$work/build.log"; exit 1; }
build/reduce_arm
{ build/arm && build/within && build/loop; } | tee printed.txt
{ block text 1 && block text 2 && block text 3; } | while read -r line; do
  grep -qxF -- "$line" printed.txt || { echo "docs/howto/cpp.md shows \"$line\", which is not printed"; exit 1; }
done
cd "$here"
# Nothing in what was installed points back into the tree.
if grep -rlF "$(cd "$here/../.." && pwd)" "$work/usr/lib" --include='*.cmake'; then echo "these name the source tree"; exit 1; fi
if ldd "$work/build/consumer" | grep -E 'petsc|slepc|gmsh|libmpi'; then echo "the library brings heavy packages"; exit 1; fi
