#!/usr/bin/env bash
# A frame of 16 parts on a real Slurm of two nodes, both on this machine: a node that is killed and
# comes back, a part that fails for its input and is tried again. The picture has to be the single
# run's, bit for bit. As root; Slurm runs in a folder of its own and is stopped at the end, however
# that comes.
#   ci/farm.sh [PROGRAM]   with the program that is built, or that one
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
program=${1:-$root/build/release/bin/emberline}
[ "$(id -u)" -eq 0 ] || { echo "ci/farm.sh: Slurm's daemons start as root; run this as root" >&2; exit 1; }
"$root/ci/setup.sh" slurm-wlm munge
if [ $# -eq 0 ]; then
  (cd "$root" && cmake --preset release >/dev/null && ninja -C build/release emberline >/dev/null)
fi

work=$(mktemp -d)
export SLURM_CONF=$work/slurm/slurm.conf
munge=
began=$SECONDS
say() { printf '%4d s  %s\n' $((SECONDS - began)) "$*"; }

# Every process of the nodes and jobs that we started; other Slurms of this machine are not ours.
pids_of() { # NODE: its daemon, its steps and what they run
  local daemon step
  daemon=$(cat "$work/slurm/$1.pid" 2>/dev/null || true)
  for step in $(pgrep -x slurmstepd || true); do
    grep -qzx "SLURM_CONF=$SLURM_CONF" "/proc/$step/environ" 2>/dev/null || continue
    grep -qs "$work" "/proc/$step/maps" 2>/dev/null || true
    steps+=("$step")
  done
  echo "$daemon"
}

finish() {
  local status=$?
  if [ -e "$SLURM_CONF" ]; then
    timeout 10 scancel --user=root 2>/dev/null || true
    timeout 10 scontrol shutdown 2>/dev/null || true
    sleep 1
    for pid in "$work"/slurm/*.pid; do kill -9 "$(cat "$pid")" 2>/dev/null || true; done
  fi
  [ -z "$munge" ] || kill "$munge" 2>/dev/null || true
  rm -rf "$work"
  exit $status
}
trap finish EXIT
