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
  when_free "${as_root[@]}" apt-get update -qq &&
    when_free "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=600 install -y -qq --no-install-recommends \
      "${missing[@]}" || {
    say "error: apt-get could not install these packages; the lines above are its last words" >&2
    return 1
  }
}

# when_free COMMAND...: a command of apt-get, again every few seconds for ten minutes while another package manager (unattended
# upgrades) holds one of its locks; DPkg::Lock::Timeout waits for dpkg's only, not for that of the lists.
when_free() {
  local log="${TMPDIR:-/tmp}/flexura-apt.log" start=$SECONDS told=
  until "$@" >"$log" 2>&1; do
    if ! grep -q 'Could not get lock\|Unable to acquire the dpkg\|Unable to lock' "$log" || ((SECONDS - start > ${FLEXURA_APT_WAIT:-600})); then
      tail -n 20 "$log" >&2
      return 1
    fi
    [ -n "$told" ] || say "another package manager is at work; waiting for it (at most ten minutes) ..."
    told=yes
    sleep "${FLEXURA_APT_PAUSE:-5}"
  done
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
  local steps=0 minutes
  # Of a first build; ninja's dry run does not look behind the check of the globbed folders.
  [ -f "build/$preset/.ninja_log" ] || steps=$(ninja -C "build/$preset" -t commands "$@" 2>/dev/null | grep -c -e ' -c ' || true)
  # About three seconds of one core a file: an estimate for cores of 2.5 GHz without a compiler cache.
  minutes=$((${steps:-0} * 3 / 60 / $(nproc)))
  [ "$minutes" -lt 1 ] || say "$steps files: about $minutes minutes on $(nproc) cores (less where ccache knows them)"
  if [ -t 1 ]; then # on a terminal ninja's own line shows how far it is
    cmake --build "build/$preset" -- "$@"
  else # elsewhere a line for each tenth, and what is not a step: warnings, errors
    cmake --build "build/$preset" -- "$@" | awk '
      match($0, /^\[[0-9]+\/[0-9]+\]/) { split(substr($0, 2, RLENGTH - 2), n, "/"); tenth = int(10 * n[1] / n[2])
        if (n[2] > 20 && tenth > last) { print "  " n[1] " of " n[2]; last = tenth; fflush() } ; next }
      /^ninja: (no work to do|Entering)/ { next } { print; fflush() }'
  fi
}
