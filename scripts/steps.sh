# Sourced by the scripts beside it. Goes to the checkout's root and gives them one manner of speaking:
# a status line a step, its output in a log, and on failure one reason, the log's tail and the log's path.
# shellcheck shell=bash

set -euo pipefail

program=$(basename "$0")
called_from=$PWD
cd "$(dirname "${BASH_SOURCE[0]}")/.."
root=$PWD
logs=$root/build/logs

# The same object code in another checkout of the same text is found in the compiler cache.
export CCACHE_BASEDIR=$root
# What it wants to be told before it keeps what was compiled with precompiled headers.
export CCACHE_SLOPPINESS=pch_defines,time_macros

# fail REASON [CODE]: one line on standard error, and out.
fail() {
  printf '%s: %s\n' "$program" "$1" >&2
  exit "${2:-1}"
}

mkdir -p "$logs" 2>/dev/null || fail "cannot write to $logs, wanted a checkout that this user may write to"

# shown PATH: a path of the checkout as seen from the caller's folder, quoted for a shell.
shown() { printf '%q' "$(realpath -m --relative-to="$called_from" "$1")"; }

# first_error LOG: the line that most likely says why (compiler, CMake, linker, our own programs), else the last.
first_error() {
  grep -m1 -E '(^|[ :])(fatal |internal compiler )?error: ' "$1" || grep -m1 -A1 -E '^CMake Error' "$1" | tr '\n' ' ' ||
    tail -n 1 "$1"
}

# show_failure TITLE LOG [REASON]
show_failure() {
  local reason=${3:-}
  if [[ -z $reason ]]; then reason=$(first_error "$2"); fi
  {
    printf '%s: %s failed: %s\n' "$program" "$1" "$reason"
    printf -- '--- the end of %s\n' "$(shown "$2")"
    tail -n 25 "$2"
  } >&2
}

# step TITLE LOG COMMAND...: runs the command quietly; ends the script when it fails. A function fails at its first
# command that does: bash forgets set -e where it is asked for the outcome with ||, hence the subshell.
step() {
  local title=$1 log=$logs/$2 start=$SECONDS code=0
  shift 2
  printf '%s ... ' "$title"
  set +e
  (
    set -e
    "$@"
  ) >"$log" 2>&1 </dev/null
  code=$?
  set -e
  if ((code == 0)); then
    printf '%d s\n' $((SECONDS - start))
    return
  fi
  printf 'failed\n'
  show_failure "$title" "$log"
  exit "$code"
}

# configure_release: a folder that scripts/test has set up keeps its tests, so that all commands share their objects.
release=$root/build/release
configure_release() {
  if [[ -e $release/build.ninja ]]; then cmake --preset release; else cmake --preset release -DVRDA_TESTS=OFF; fi
}
