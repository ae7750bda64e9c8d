# Scripts that work in a separate Debian system source this file for its functions make_root and in_root. The functions
# need to run as root, and make_root needs debootstrap and network access. EMBERLINE_DEBIAN_MIRROR is the mirror of the
# packages (default: the mirror that this host's apt uses).
# shellcheck shell=bash

fail() {
  echo "ci/$(basename "$0"): $*" >&2
  exit 1
}

# make_root SUITE ROOT: creates a minimal Debian system in the folder ROOT, unless there is one already.
make_root() {
  local suite=$1 root=$2 mirror log
  [ "$(id -u)" -eq 0 ] || fail "needs root, for debootstrap and chroot"
  command -v debootstrap >/dev/null || fail "debootstrap is missing: apt-get install debootstrap"
  # Ask apt for its mirror, because the file with apt's sources may have either of two formats.
  # shellcheck disable=SC2016
  mirror=${EMBERLINE_DEBIAN_MIRROR:-$(apt-get indextargets --format '$(REPO_URI)' \
    "Created-By: Packages" "Origin: Debian" "Label: Debian" | head -n 1)}
  [ -n "$mirror" ] ||
    fail "found no Debian mirror in apt's sources (run apt-get update, or set EMBERLINE_DEBIAN_MIRROR)"
  if [ ! -e "$root/etc/debian_version" ]; then
    echo "ci/$(basename "$0"): making a $suite root in $root"
    rm -rf "$root.part"
    log=$(mktemp)
    debootstrap --variant=minbase --include=ca-certificates "$suite" "$root.part" "$mirror" >"$log" 2>&1 || {
      tail -n 20 "$log" >&2
      rm -rf "$log" "$root.part"
      fail "debootstrap failed (no network?); the lines above say why"
    }
    rm -f "$log"
    [ ! -e "$root" ] || rmdir "$root"
    mv "$root.part" "$root"
  fi
  # Let the root's apt reach the mirror with this host's settings. It accepts package lists that are out of date, but it
  # checks their signatures.
  {
    apt-config dump | grep -E '^Acquire::(https?|ftp|Retries)\b.*"[^"]+";$' || true
    echo 'Acquire::Check-Valid-Until "false";'
  } >"$root/etc/apt/apt.conf.d/90emberline"
  cp /etc/resolv.conf "$root/etc/resolv.conf"
}

# in_root ROOT COMMAND...: runs the command in ROOT. Mounts /proc and other file systems in a mount namespace that ends
# with the command, so that nothing stays mounted on the host.
in_root() {
  # The inner shell expands the arguments.
  # shellcheck disable=SC2016
  unshare --mount --fork bash -c '
    root=$1
    shift
    mount -t proc proc "$root/proc"
    mount -t sysfs sysfs "$root/sys"
    mount -t tmpfs tmpfs "$root/dev/shm"
    mount -t devpts -o newinstance,ptmxmode=0666 devpts "$root/dev/pts"
    exec chroot "$root" env -i HOME=/root LC_ALL=C.UTF-8 TERM="${TERM:-dumb}" DEBIAN_FRONTEND=noninteractive \
      PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin \
      ${http_proxy:+http_proxy="$http_proxy"} ${https_proxy:+https_proxy="$https_proxy"} \
      "$@"' in_root "$@"
}
