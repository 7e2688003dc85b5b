# Sourced by cases/run and tests/run: installs what is missing, builds.  Safe to repeat, quick when nothing changed.
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
say() { printf '%s\n' "$*"; }

# install_packages GROUP...: the packages of tests/setup/packages.txt in these groups that are not there yet.
install_packages() {
  local group package command missing=() wanted=" $* "
  while read -r group package command; do
    case "$group" in '#'* | '') continue ;; esac
    case "$wanted" in *" $group "*) ;; *) continue ;; esac
    if [ -n "$command" ] && command -v "$command" >/dev/null; then continue; fi
    dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing+=("$package")
  done <"$root/tests/setup/packages.txt"
  [ ${#missing[@]} -eq 0 ] && return 0
  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || {
      say "error: missing Debian packages: ${missing[*]}; install them as root (there is no sudo here)" >&2
      return 1
    }
    as_root=(sudo)
  fi
  say "installing ${#missing[@]} Debian packages: ${missing[*]}"
  # Another package manager may be at work (unattended upgrades): wait for it instead of failing.
  "${as_root[@]}" apt-get -o DPkg::Lock::Timeout=600 update -qq || return 1
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=600 install -y -qq --no-install-recommends \
    "${missing[@]}" >"${TMPDIR:-/tmp}/flexura-apt.log" 2>&1 || {
    tail -n 20 "${TMPDIR:-/tmp}/flexura-apt.log" >&2
    say "error: apt-get could not install these packages; the lines above are its last words" >&2
    return 1
  }
}

# build PRESET [TARGET...]: configures when needed and builds with all cores.
build() {
  local preset=$1
  shift
  say "building ($preset) ..."
  cd "$root" || return 1
  if [ ! -f "build/$preset/build.ninja" ]; then
    cmake --preset "$preset" >"${TMPDIR:-/tmp}/flexura-cmake.log" 2>&1 || {
      cat "${TMPDIR:-/tmp}/flexura-cmake.log" >&2
      return 1
    }
  fi
  [ -d "build/$preset/bin" ] || say "the first build compiles some 600 files: about a quarter of an hour on two cores"
  local quiet=--quiet
  [ -t 1 ] && quiet=  # on a terminal ninja's own line shows how far it is
  cmake --build "build/$preset" -- $quiet "$@" || return 1
}
