#!/usr/bin/env bash
# Renders a frame in 16 parts on a real Slurm with two nodes, both on this machine. The script damages the scene for a
# while, so that some parts fail. It kills a node and starts it again, and then retries the missing parts. The picture
# must be bit-identical to that of a single run, as must the pictures of a staged frame and of an adaptive frame. This
# script must run as root. Slurm uses a separate folder and separate ports, and is always stopped at the end.
#   ci/farm.sh [PROGRAM]   PROGRAM: the emberline to test (default: build/release/bin/emberline, which is then built)
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
program=$(realpath "${1:-$root/build/release/bin/emberline}")
[ "$(id -u)" -eq 0 ] || { echo "ci/farm.sh: Slurm's daemons start as root; run this as root" >&2; exit 1; }
"$root/ci/setup.sh" slurm-wlm munge
[ $# -gt 0 ] || (cd "$root" && cmake --preset release >/dev/null && ninja -C build/release emberline >/dev/null)

work=$(mktemp -d)
chmod 755 "$work"  # all users need munge's socket
export SLURM_CONF=$work/slurm.conf
port=$((20000 + $$ % 10000 * 3))
began=$SECONDS
say() { printf '%4d s  %s\n' $((SECONDS - began)) "$*"; }
fail() {
  say "FAILED: $*"
  squeue -r 2>&1 || true
  tail -n 3 ./*.farm/logs/* "$work"/*.log 2>/dev/null || true
  exit 1
}

# processes_of NODE: prints the process numbers of the node's daemon, of the emberline programs that its jobs run, and
# of their parents, which are Slurm's step daemons.
processes_of() {
  cat "$work/$1.pid" 2>/dev/null || true
  for pid in $(pgrep -x emberline || true); do
    tr '\0' '\n' 2>/dev/null <"/proc/$pid/environ" | grep -qx "SLURMD_NODENAME=$1" || continue
    tr '\0' '\n' 2>/dev/null <"/proc/$pid/cmdline" | grep -qF "$work" || continue
    echo "$pid"
    ps -o ppid= -p "$pid" || true
  done
}

finish() {
  status=$?
  trap - EXIT
  trap '' INT TERM HUP  # nothing may interrupt the cleanup
  for node in n1 n2; do kill -9 $(processes_of $node) 2>/dev/null || true; done
  for name in controller munge; do kill -9 "$(cat "$work/$name.pid" 2>/dev/null)" 2>/dev/null || true; done
  rm -rf "$work"
  exit $status
}
trap finish EXIT
trap 'exit 130' INT TERM HUP

start_slurm() {
  mkdir "$work/state"
  (umask 077 && head -c 64 /dev/urandom >"$work/munge.key")
  munged --socket="$work/munge.socket" --key-file="$work/munge.key" --pid-file="$work/munge.pid" \
    --log-file="$work/munge.log" --seed-file="$work/munge.seed" --force 2>>"$work/munge.log"
  cat >"$SLURM_CONF" <<CONF
ClusterName=farm
SlurmctldHost=$(hostname -s)
SlurmUser=root
AuthType=auth/munge
# A requeued job waits until its credentials expire, by default after 120 s.
AuthInfo=socket=$work/munge.socket,cred_expire=5
MpiDefault=none
ProctrackType=proctrack/linuxproc
ReturnToService=2
SlurmctldPidFile=$work/controller.pid
SlurmdPidFile=$work/%n.pid
SlurmdSpoolDir=$work/node.%n
StateSaveLocation=$work/state
SlurmctldPort=$port
SlurmctldTimeout=10
SlurmdTimeout=6
SwitchType=switch/none
TaskPlugin=task/none
SchedulerType=sched/backfill
SchedulerParameters=bf_interval=1,sched_interval=2
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmctldLogFile=$work/controller.log
SlurmdLogFile=$work/node.%n.log
NodeName=n[1-2] NodeHostname=$(hostname -s) Port=[$((port + 1))-$((port + 2))] CPUs=1 RealMemory=4000 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
  slurmctld
  for node in n1 n2; do slurmd -N $node; done
  wait_for 30 "two idle nodes" '[ "$(sinfo -h -t idle -o %D)" = 2 ]'
}

# wait_for SECONDS WHAT CONDITION: waits until the shell condition holds. WHAT describes it in the error message.
wait_for() {
  local end=$((SECONDS + $1))
  until eval "$3" 2>/dev/null; do
    [ $SECONDS -lt $end ] || fail "waited $1 s in vain for $2"
    sleep 0.3
  done
}

# count STATE: prints how many parts are in this state, such as "done" or "failed".
count() { "$program" farm status "$frame" --json | grep -A1 '"part":' | grep -c "\"state\": \"$1\"" || true; }

say "Slurm with two nodes of one processor"
start_slurm
folder=$work/$'a frame\'s\n100% \\folder'  # file names may contain any character
mkdir "$folder" && cd "$folder"
cp "$root/scenes/cornell_box.glb" scene.glb
frame=shot.exr
settings=(--size 256x256 --bucket-size 16 --spp "${EMBERLINE_FARM_SPP:-128}" --aov variance,albedo)

say "16 parts"
"$program" farm scene.glb -o $frame --parts 16 --cpus 1 --memory 1G --minutes 30 "${settings[@]}"

wait_for 60 "two finished parts" '[ "$(count done)" -ge 2 ]'
mv scene.glb whole.glb && head -c 1000 whole.glb >scene.glb
say "the scene is truncated"
wait_for 60 "a failed part" '[ "$(count failed)" -ge 1 ]'
mv whole.glb scene.glb
say "the scene is restored; $(count failed) parts have failed"
"$program" farm status $frame

# Stops the processes of node n1 while it renders a part whose checkpoint already has some buckets. Because they are
# stopped, the part cannot finish before the script kills it.
hold_n1_with_buckets() {
  local held part
  held=$(processes_of n1)
  kill -STOP $held
  [ "$(wc -w <<<"$held")" -ge 3 ] &&  # the node's daemon, the part's program and its parent
    part=$(squeue -h -r -w n1 -t RUNNING -o %K) &&
    [ "$(stat -c %s $frame.part-"$part"-of-16.checkpoint)" -gt 20000 ] && return
  kill -CONT $held
  return 1
}
wait_for 60 "a part with buckets on n1" hold_n1_with_buckets
kill -9 $(processes_of n1)
say "killed n1: its daemon and its steps"
wait_for 60 "a node that is down" 'sinfo -h -n n1 -o %T | grep -q down'
slurmd -N n1
say "n1 is back"
wait_for 120 "the end of the array" '[ -z "$(squeue -h -r -o %T | grep -v PENDING)" ] && ! squeue -h -r -o %r | grep -qE "Resources|Priority|BeginTime|None"'
"$program" farm status $frame
[ "$(count failed)" -ge 1 ] || fail "no part has failed"
[ ! -e $frame ] || fail "the parts were merged although some are missing"
grep -l "NODE_FAIL\|NODE FAILURE\|resumed from" $frame.farm/logs/*.log | sed 's/^/        resumed after the kill: /' || fail "no part was running on n1"

say "farm retry"
"$program" farm retry $frame
wait_for 120 "the picture" '[ -e $frame.farm/merge.json ] && [ -z "$(squeue -h)" ]'
"$program" farm status $frame
grep -h "SLURM_\|the job" $frame.farm/logs/part-1.log | sed 's/^/        /'

say "a frame whose scene is copied to the nodes first"
mkdir "$work/scratch"
TMPDIR=$work/scratch "$program" farm scene.glb -o staged.exr --parts 4 --cpus 1 --stage "${settings[@]}" --spp 16
wait_for 60 "the staged picture" '[ -e staged.exr.farm/merge.json ] && [ -z "$(squeue -h)" ]'
[ "$(ls "$work/scratch" | wc -l)" = 1 ] || fail "unexpected files in the scratch folder: $(ls "$work/scratch")"

say "an adaptive frame, which is planned first"
"$program" farm scene.glb -o adaptive.exr --parts 4 --cpus 1 --driver adaptive "${settings[@]}" --spp 16
wait_for 90 "the adaptive picture" '[ -e adaptive.exr.farm/merge.json ] && [ -z "$(squeue -h)" ]'
"$program" farm status adaptive.exr

say "the same frames, each in a single run"
"$program" render scene.glb -o single.exr --quiet "${settings[@]}"
"$program" render scene.glb -o single-staged.exr --quiet "${settings[@]}" --spp 16
"$program" plan scene.glb -o own.plan --quiet "${settings[@]}" --spp 16
cmp own.plan adaptive.exr.farm/frame.plan || fail "the plans differ"
"$program" render scene.glb -o single-adaptive.exr --quiet --driver adaptive --plan own.plan "${settings[@]}" --spp 16
PYTHONPATH=$root/tests/invariance python3 - <<'CHECK' || fail "the pictures differ"
from frame_bits import chunks
for a, b in (("shot.exr", "single.exr"), ("staged.exr", "single-staged.exr"),
             ("adaptive.exr", "single-adaptive.exr")):
    a, b = (chunks(open(name, "rb").read()) for name in (a, b))
    print(f"        {len(a)} tiles, {sum(x != y for x, y in zip(a, b))} differ")
    assert a == b
CHECK
say "the pictures are bit-identical"
