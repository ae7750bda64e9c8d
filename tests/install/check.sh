#!/usr/bin/env bash
# Installs a build, builds example.cpp against it with CMake and with pkg-config, and runs it.
#     check.sh BUILD
set -euo pipefail
build=$(realpath "$1")
here=$(dirname "$(realpath "$0")")
scenes=$here/../../scenes
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
prefix=$folder/prefix

cmake --install "$build" --prefix "$prefix" >"$folder/log" || { cat "$folder/log" >&2; exit 1; }
libdir=$(dirname "$(find "$prefix" -name libemberline.a)")

# Only the interface may be exported. (The linker may list a local symbol, which nothing can bind to.)
foreign=$(nm -DC --defined-only --extern-only "$libdir/libemberline.so" | cut -d' ' -f3- | grep -v 'emberline::api' || true)
if [ -n "$foreign" ]; then
  echo "libemberline.so shows more than its interface:" >&2
  echo "$foreign" | head >&2
  exit 1
fi

cmake -S "$here" -B "$folder/build" -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_BUILD_TYPE=Release \
  >"$folder/log" || { cat "$folder/log" >&2; exit 1; }
cmake --build "$folder/build" >"$folder/log" 2>&1 || { cat "$folder/log" >&2; exit 1; }
flags=$(PKG_CONFIG_PATH=$libdir/pkgconfig pkg-config --define-variable=prefix="$prefix" --cflags --libs emberline)
# shellcheck disable=SC2086
"${CXX:-c++}" -std=c++20 "$here/example.cpp" -o "$folder/example_pc" $flags

run() { (cd / && LD_LIBRARY_PATH=$libdir "$@" "$scenes/cornell_box.glb" light 2>/dev/null); }
shared=$(run "$folder/build/example")
echo "$shared"
for program in "$folder/build/example_static" "$folder/example_pc"; do
  other=$(run "$program")
  [ "$other" = "$shared" ] || { echo "$program says: $other" >&2; exit 1; }
done
# Programs built against 1.0.0 must run with this library, and their sources must compile against this header.
mkdir -p "$folder/old/emberline" "$folder/pictures"
cp "$here/emberline_1_0_0.h" "$folder/old/emberline/emberline.h"
for program in example all_of_1_0_0; do
  "${CXX:-c++}" -std=c++20 -I"$folder/old" "$here/$program.cpp" -o "$folder/${program}_old" \
    "$libdir/libemberline.so"
done
# shellcheck disable=SC2086
"${CXX:-c++}" -std=c++20 "$here/all_of_1_0_0.cpp" -o "$folder/all_of_1_0_0" $flags
other=$(run "$folder/example_old")
[ "$other" = "$shared" ] || { echo "what was built against 1.0.0 says: $other" >&2; exit 1; }
for program in all_of_1_0_0_old all_of_1_0_0; do
  (cd / && LD_LIBRARY_PATH=$libdir "$folder/$program" "$scenes/cornell_box.glb" light "$folder/pictures")
done
# Python's module, which was built here, must also find the library in a prefix that the loader does not know.
if [ -d "$prefix/lib/python3/dist-packages/emberline" ]; then
  PYTHONDONTWRITEBYTECODE=1 PYTHONPATH=$prefix/lib/python3/dist-packages /usr/bin/python3 -c \
    'import sys, emberline; emberline.render(emberline.Scene(sys.argv[1], size=(8, 8), spp=1))' "$scenes/cornell_box.glb"
fi
# The installed command must find its library.
"$prefix/bin/emberline" render "$scenes/cornell_box.glb" --env "$scenes/dusk.hdr" --size 8x8 --spp 1 \
  -o "$folder/a.exr" --quiet
[ -s "$folder/a.exr" ]
