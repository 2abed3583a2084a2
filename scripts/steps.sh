# Sourced by the other scripts. Changes to the checkout's root and provides their output format:
# a status line per step, its output in a log; on failure one reason, the end of the log and its path.
# shellcheck shell=bash

set -euo pipefail

program=$(basename "$0")
called_from=$PWD
cd "$(dirname "${BASH_SOURCE[0]}")/.."
root=$PWD
logs=$root/build/logs

# Lets ccache share objects between checkouts.
export CCACHE_BASEDIR=$root
# Needed by ccache to cache compilations with precompiled headers.
export CCACHE_SLOPPINESS=pch_defines,time_macros

# fail REASON [CODE]: prints one line to standard error and exits.
fail() {
  printf '%s: %s\n' "$program" "$1" >&2
  exit "${2:-1}"
}

mkdir -p "$logs" 2>/dev/null || fail "cannot write to $logs, wanted a checkout that this user can write to"

# shown PATH: path relative to the caller's folder, quoted for a shell.
shown() { printf '%q' "$(realpath -m --relative-to="$called_from" "$1")"; }

# first_error LOG: the line most likely to contain the reason (compiler, CMake, linker, our programs), else the last.
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

# step TITLE LOG COMMAND...: runs the command quietly; ends the script if it fails. A function stops at its first failing
# command; the subshell is needed because bash ignores set -e in commands tested by ||.
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

# configure_release [OPTION...]: keeps the tests if scripts/test has configured them, so that all commands share their objects.
release=$root/build/release
configure_release() {
  if [[ -e $release/build.ninja ]]; then cmake --preset release "$@"; else cmake --preset release -DVRDA_TESTS=OFF "$@"; fi
}
