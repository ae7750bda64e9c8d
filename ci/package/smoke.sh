#!/usr/bin/env bash
# Tries an installed Emberline. The checks range from rendering the demo's frame to building a program that uses the
# library.
#   ci/package/smoke.sh SOURCES   SOURCES: the folder with scenes/ and tests/
set -uo pipefail
sources=$(realpath "$1")
scenes=$sources/scenes
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit 1

count=0 failed=0
check() {
  local name=$1
  shift
  count=$((count + 1))
  if "$@" >log 2>&1; then
    echo "ok      $name"
  else
    failed=$((failed + 1))
    echo "FAILED  $name: $*"
    tail -n 5 log
  fi
}
exits() {
  local wanted=$1 status=0
  shift
  "$@" || status=$?
  [ $status -eq "$wanted" ]
}
says() { [[ $(eval "$2" 2>&1) == *"$1"* ]]; }
render() { emberline render "$scenes/cornell_box.glb" --size 64x64 --spp 4 --quiet "$@"; }
completes() {
  # shellcheck source=/dev/null
  source /usr/share/bash-completion/completions/emberline
  COMP_WORDS=(emberline render "$scenes/teap") COMP_CWORD=2
  _emberline
  [ "${COMPREPLY[*]}" = "$scenes/teapot.glb" ]
}
builds() {
  cmake -S "$sources/tests/install" -B example -DCMAKE_BUILD_TYPE=Release && cmake --build example
}
runs() { "$1" "$scenes/cornell_box.glb" light; }
by_pkg_config() {
  # shellcheck disable=SC2046
  g++ -std=c++20 "$sources/tests/install/example.cpp" -o example_pc $(pkg-config --cflags --libs emberline)
  ./example_pc "$scenes/cornell_box.glb" light
}

# Checks that the builds for all instruction sets render the same picture (renderer/arches.cmake). By default the loader
# chooses only the best build, so the other builds are selected explicitly.
builds_agree() {
  local arch loader=/lib64/ld-linux-x86-64.so.2
  for arch in $("$loader" --help | sed -n 's/^  \(x86-64-v[234]\) (supported.*/\1/p' | tac); do
    local emberline=("$loader" --glibc-hwcaps-mask "$arch" /usr/bin/emberline)
    "${emberline[@]}" --version | grep "^instruction sets: $arch," || return 1
    "${emberline[@]}" render "$scenes/glass_metal.glb" --size 64x64 --spp 4 --quiet -o "$arch.exr" || return 1
    emberline compare "$arch.exr" x86-64-v2.exr --json | grep '"different_pixels": 0' || return 1
  done
}

in_python() {
  python3 - "$scenes/cornell_box.glb" <<'SCRIPT'
import sys
import emberline
scene = emberline.Scene(sys.argv[1], size=(64, 64), spp=4)
picture = emberline.render(scene)
frame = emberline.read("a.exr")
assert (picture["RGB"] == frame["RGB"]).all(), "the picture differs from the command's"
assert emberline.compare(picture, frame).mse == 0
SCRIPT
}

# Blender is too large for a minimal root. So this only checks that all files of the add-on are there and that Python
# can parse them.
addon_of_blender() {
  local scripts=/usr/share/blender/scripts/addons/emberline_blender
  # Blender 4.2 and later look for the add-on in extensions/system.
  cmp "$scripts/blender_manifest.toml" /usr/share/blender/extensions/system/emberline_blender/blender_manifest.toml || return 1
  python3 - "$scripts" <<'SCRIPT'
import ast, os, sys
folder = sys.argv[1]
files = [name for name in os.listdir(folder) if name.endswith(".py")]
assert "__init__.py" in files
for name in files:
    with open(os.path.join(folder, name)) as file:
        for node in ast.walk(ast.parse(file.read())):
            if isinstance(node, ast.ImportFrom) and node.level == 1:
                for part in [node.module] if node.module else [alias.name for alias in node.names]:
                    assert part + ".py" in files, f"{name} imports {part}, which is missing"
SCRIPT
}

version=$(dpkg-query -W -f '${Version}' emberline)
check "the demo" emberline render "$scenes/teapot.glb" -o teapot.exr -o teapot.png --spp 128 \
  --report teapot.json --report teapot.html
check "version" says "emberline ${version%-*}" "emberline --version"
check "help" says --noise-threshold "emberline render --help-all"
check "manual" says "EMBERLINE\\-FARM" "zcat /usr/share/man/man1/emberline-farm.1.gz"
check "manual as HTML" says "Getting started" "cat /usr/share/doc/emberline/html/index.html"
check "completion" completes
check "exr" render -o a.exr
check "same bits on one thread" render -o b.exr --threads 1
check "same bits on older processors" builds_agree
check "compare" says '"mse":0.0' 'emberline compare a.exr b.exr --json | tr -d " "'
check "jpeg, environment" render -o a.jpg --env "$scenes/studio.hdr"
check "adaptive, channels" render -o c.exr --driver adaptive --aov denoising --report c.json
check "heatmap" emberline heatmap c.exr -o heatmap.png
check "denoise" emberline denoise c.exr -o clean.png
check "bisection, snapshots" render -o d.png --driver bisection --snapshots shots
check "a range" render -o 'r.##.png' --frames 1-2
check "part 1" render -o p.exr --part 1/2
check "part 2" render -o p.exr --part 2/2
check "merge" emberline merge -o p.exr p.exr.part-*.checkpoint
check "merged bits" says '"mse":0.0' 'emberline compare a.exr p.exr --json | tr -d " "'
check "to be extended" render -o e.exr --resumable
check "extend" emberline extend e.exr --spp 8
check "info" says '"triangles"' "emberline info $scenes/teapot.glb --json"
check "study" emberline study "$scenes/cornell_box.glb" --size 16x16 --spp 1,2 --seeds 2 -o study
check "farm, printed" says '{part}' "emberline farm $scenes/teapot.glb -o f.exr --parts 2 --print"
check "wrong option" exits 2 emberline render --sppp 4
check "no such scene" exits 3 emberline render no.glb -o n.exr
check "window without a screen" exits 1 emberline view "$scenes/teapot.glb"
check "a program against the library, by CMake" builds
check "it runs" runs example/example
check "it runs, static" runs example/example_static
check "the same by pkg-config" by_pkg_config
check "the same bits in Python" in_python
check "the add-on for Blender" addon_of_blender
echo "$count checks, $failed failed"
[ $failed -eq 0 ]
