# Sourced by .ci/package-test and .ci/machine-test: the package, and a clean Debian 12 in which it is installed. Wants $work
# (a folder that is kept between runs), skip() and step().
# shellcheck shell=bash

# Sets $deb.
make_package() {
  step "package"
  rm -f build/release/onemap_*.deb
  configure_and_build release package  # cmake --build --preset release --target package
  deb=$(ls build/release/onemap_*.deb)
}

within() { systemd-nspawn --quiet --register=no --keep-unit -D "$root" --bind-ro=/etc/resolv.conf "$@" </dev/null; }

# install_package ROOT: sets $root. $work/clean is a Debian 12 without what the package depends on.
install_package() {
  local clean=$work/clean
  root=$1
  if [ ! -e "$clean.done" ]; then
    step "a clean Debian 12 (debootstrap)"
    rm -rf "$clean"
    debootstrap --variant=minbase --include=systemd,systemd-sysv,udev,dbus,iproute2 bookworm "$clean" >"$work/debootstrap.log" 2>&1 ||
      { tail -5 "$work/debootstrap.log"; skip "debootstrap failed: is there a network?"; }
    touch "$clean.done"
  fi
  step "install"
  rm -rf "$root"
  cp -a --reflink=auto "$clean" "$root"
  mkdir -p "$work/archives"
  cp -n "$work"/archives/*.deb "$root/var/cache/apt/archives/" 2>/dev/null || true  # what an earlier run fetched
  rm -f "$root/etc/apt/apt.conf.d/docker-clean"
  cp "$deb" "$root/onemap.deb"
  within sh -c 'apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends -o APT::Keep-Downloaded-Packages=true /onemap.deb libgl1-mesa-dri' >"$work/install.log" 2>&1 ||
    { tail -20 "$work/install.log"; exit 1; }
  cp -n "$root"/var/cache/apt/archives/*.deb "$work/archives/" 2>/dev/null || true
}
