#!/usr/bin/env bash
# Tests what the Tab key shows in bash, and that it offers every option that --help-all lists:
#     completion.sh PROGRAM SHARE       SHARE: the folder that --write-documents has written
set -euo pipefail
program=$(realpath "$1")
share=$(realpath "$2")
# shellcheck source=/dev/null
source "$share/bash-completion/completions/emberline"
[ "$(complete -p emberline)" = "complete -F _emberline emberline" ]

failed=0
print_completions() {
  COMP_WORDS=("$@") COMP_CWORD=$(($# - 1))
  _emberline
  printf '%s\n' "${COMPREPLY[@]}" | sort -u | paste -sd'|'
}
expect() {
  local wanted=$1 got
  shift
  got=$(print_completions "$@")
  [ "$got" = "$wanted" ] || {
    echo "of '$*' bash shows '$got', and not '$wanted'"
    failed=1
  }
}

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
mkdir shots
touch 'a scene.glb' b.gltf notes.txt sky.hdr look.json

expect 'compare' emberline co
expect '--version' emberline --v
expect 'bisection|bucket' emberline render --driver b
expect 'bisection' emberline render --driver = bi
expect 'adaptive|bisection|bucket' emberline render a.glb --driver =
expect 'live' emberline view --driver l
expect 'live' emberline session --driver l
expect '' emberline session ''
expect '--noise-threshold' emberline render a.glb --noi
expect 'N|Ng' emberline render --aov N
expect 'albedo,N|albedo,Ng' emberline render --aov albedo,N
expect 'cull|show' emberline render --backfaces ''
expect '' emberline render --spp ''
expect 'a scene.glb|b.gltf|shots' emberline render ''
expect 'a scene.glb' emberline render 'a\ s'
expect 'a scene.glb' emberline render '"a s'
expect 'shots|sky.hdr' emberline render b.gltf --env ''
expect 'look.json' emberline render --edits l
expect 'shots' emberline render --snapshots ''
expect 'status' emberline farm stat
expect '--json' emberline farm status --j
expect 'render' emberline help ren
expect 'notes.txt' emberline farm status n

for command in '' $(print_completions emberline '' | tr '|' ' '); do
  # shellcheck disable=SC2086
  options=$("$program" $command --help-all | grep -oE '^  (-[a-z], )?--[a-z-]+' | grep -oE -- '--[a-z-]+' | sort)
  completed=$(print_completions emberline $command -- | tr '|' '\n')
  page=$(zcat "$share/man/man1/emberline${command:+-$command}.1.gz" | sed 's/\\//g')
  [ "$options" = "$completed" ] || {
    echo "emberline $command: --help-all and completion differ:"
    diff <(echo "$options") <(echo "$completed") || true
    failed=1
  }
  for option in $options; do
    [[ $page == *"fB$option"fR* ]] || { echo "the page of emberline $command lacks $option"; failed=1; }
  done
done
exit $failed
