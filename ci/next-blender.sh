#!/usr/bin/env bash
# Runs the add-on's tests in the Blender of another Debian release, in a root that debootstrap makes. The script copies
# the emberline built here, with its libraries, into that root. The script is run by hand, as root, with network access.
#
#   ci/next-blender.sh [ROOT [CASE...]]   ROOT: the system's folder, reused if it exists (default build/next-blender,
#                                         about 2 GB); CASE: a case of tests/blender/addon_test.py (default: all)
#
#   EMBERLINE_DEBIAN_SUITE    the Debian release (default: sid; trixie has Blender 4.3)
#   EMBERLINE_DEBIAN_MIRROR   the mirror of the packages (default: the mirror that this host's apt uses)
#   EMBERLINE_BUILD           the folder with bin/emberline (default: build/release)
set -euo pipefail
cd "$(dirname "$0")/.."

. ci/debian_root.sh

build=$(realpath "${EMBERLINE_BUILD:-build/release}")
[ -x "$build/bin/emberline" ] || fail "there is no $build/bin/emberline: build it first"
mkdir -p "${1:-build}"
root=$(realpath "${1:-build/next-blender}")
[ $# -eq 0 ] || shift
make_root "${EMBERLINE_DEBIAN_SUITE:-sid}" "$root"
if [ ! -e "$root/usr/bin/blender" ]; then
  in_root "$root" apt-get update
  in_root "$root" apt-get install -y --no-install-recommends \
    blender python3 python3-numpy python3-requests python3-cattr xvfb xauth libgl1-mesa-dri
fi

# The program must load the libraries with which it was built, and not those of the root.
command=$root/opt/emberline
rm -rf "$command"
mkdir -p "$command/lib"
images=$build/lib/libemberline_images.so
cp -L "$build/bin/emberline" "$command/emberline.bin"
ldd "$build/bin/emberline" "$images" | grep -o '/[^ :]*\.so[^ :]*' | sort -u | xargs cp -L -t "$command/lib"
cp "$images" "$command/lib"
cat >"$command/emberline" <<'WRAPPER'
#!/bin/sh
exec /opt/emberline/lib/ld-linux-x86-64.so.2 --library-path /opt/emberline/lib /opt/emberline/emberline.bin "$@"
WRAPPER
chmod +x "$command/emberline"

rm -rf "$root/emberline"
mkdir -p "$root/emberline"
cp -r --parents io/blender tests/blender "$root/emberline"

# shellcheck disable=SC2016
in_root "$root" sh -c '
  blender --version | head -n 1
  if [ -d /usr/share/blender/extensions ]; then  # Blender 4.2 and later
    blender --command extension validate /emberline/io/blender/emberline_blender || exit 1
  fi
  exec python3 -u /emberline/tests/blender/addon_test.py "${@:-all}" --emberline /opt/emberline/emberline' tests "$@"
