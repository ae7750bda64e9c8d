#!/usr/bin/env bash
# Proves that Emberline builds and passes its tests with the libraries of the Debian to come (Embree 4
# among them), in a root of its own made with debootstrap. Run by hand, as root; not part of ci/test.sh.
#
#   ci/next-debian.sh [ROOT]      ROOT: where the system is made, and reused when it is there
#                                 (default build/next-debian; about 3 GB; delete it to start afresh)
#
#   EMBERLINE_DEBIAN_MIRROR       where packages come from (default: the mirror this host's apt uses)
#   EMBERLINE_DEBIAN_SUITE        which Debian (default: sid)
#   EMBERLINE_JOBS                how many compilers and tests at once (default: one per processor)
set -euo pipefail
cd "$(dirname "$0")/.."

fail() {
  echo "ci/next-debian.sh: $*" >&2
  exit 1
}

suite=${EMBERLINE_DEBIAN_SUITE:-sid}
jobs=${EMBERLINE_JOBS:-$(nproc)}
[ $# -le 1 ] || fail "one argument at most: the folder of the root"
[ "$(id -u)" -eq 0 ] || fail "debootstrap and chroot need root"
command -v debootstrap >/dev/null || fail "debootstrap is missing: apt-get install debootstrap"

# apt itself reads its sources, in whichever of the two formats they are written.
mirror=${EMBERLINE_DEBIAN_MIRROR:-$(apt-get indextargets --format '$(REPO_URI)' \
  "Created-By: Packages" "Origin: Debian" "Label: Debian" | head -n 1)}
[ -n "$mirror" ] || fail "apt's sources name no Debian mirror (apt-get update?); set EMBERLINE_DEBIAN_MIRROR"

mkdir -p "${1:-build}"
root=$(realpath "${1:-build/next-debian}")
if [ ! -e "$root/etc/debian_version" ]; then
  echo "ci/next-debian.sh: making a $suite root in $root"
  rm -rf "$root.part"
  log=$(mktemp)
  trap 'rm -f "$log"' EXIT
  debootstrap --variant=minbase --include=ca-certificates "$suite" "$root.part" "$mirror" >"$log" 2>&1 || {
    tail -n 20 "$log" >&2
    fail "debootstrap failed; the lines above say why"
  }
  [ ! -e "$root" ] || rmdir "$root"
  mv "$root.part" "$root"
fi

# How this host reaches its mirror. The lists may be older than they promise: a mirror that stands
# still serves the purpose, and the signatures are checked all the same.
{
  apt-config dump | grep -E '^Acquire::(https?|ftp|Retries)\b.*"[^"]+";$' || true
  echo 'Acquire::Check-Valid-Until "false";'
} >"$root/etc/apt/apt.conf.d/90emberline"
cp /etc/resolv.conf "$root/etc/resolv.conf"

# Runs a command in the root. What it needs mounted is mounted in a namespace of its own, which ends
# with the command however it ends: nothing stays mounted on the host.
in_root() {
  # The arguments are expanded by the inner shell.
  # shellcheck disable=SC2016
  unshare --mount --fork bash -c '
    root=$1
    shift
    mount -t proc proc "$root/proc"
    mount -t tmpfs tmpfs "$root/dev/shm"
    mount -t devpts -o newinstance,ptmxmode=0666 devpts "$root/dev/pts"
    exec chroot "$root" env -i HOME=/root LC_ALL=C.UTF-8 TERM="${TERM:-dumb}" \
      PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin \
      ${http_proxy:+http_proxy="$http_proxy"} ${https_proxy:+https_proxy="$https_proxy"} \
      "$@"' in_root "$root" "$@"
}

# The working tree as it stands, less what is ignored. Times are kept, so that a second run compiles
# only what changed; the build folder lies outside.
rm -rf "$root/emberline"
mkdir "$root/emberline"
git ls-files -z --cached --others --exclude-standard |
  while IFS= read -r -d '' file; do
    if [ -e "$file" ]; then printf '%s\0' "$file"; fi
  done |
  tar --create --null --files-from=- | tar --extract --directory "$root/emberline"

in_root sh -c '
  set -e
  cd /emberline
  ci/setup.sh
  cmake --preset release -B /build/release
  cmake --build /build/release -j "$1"
  ctest --test-dir /build/release --output-on-failure -j "$1"' build "$jobs"

echo
echo "ci/next-debian.sh: built and tested with"
in_root dpkg-query -W -f='${Package} ${Version}\n' g++ cmake libembree-dev libtbb-dev libimath-dev \
  libopenimageio-dev libopenexr-dev libopencolorio-dev libtinygltf-dev libdraco-dev libmeshoptimizer-dev \
  libcli11-dev libspdlog-dev libfmt-dev nlohmann-json3-dev libgtest-dev
