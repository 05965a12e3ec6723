# Sourced by .ci/camera-test and .ci/machine-test: Debian's kernel, and what a virtual machine begins with. Wants $work (a
# folder), $vm (where kernel and busybox are kept between runs) and skip().
# shellcheck shell=bash

# fetch NAME PACKAGE: the package unpacked in $vm/NAME
fetch() {
  [ ! -e "$vm/$1.done" ] || return 0
  rm -rf "${vm:?}/$1" "$vm/$1.deb"
  mkdir -p "$vm/$1"
  (cd "$vm/$1" && apt-get download -qq "$2" >../$1.log 2>&1) || { tail -3 "$vm/$1.log"; skip "$2 cannot be fetched: is there a network?"; }
  mv "$vm/$1"/*.deb "$vm/$1.deb"
  dpkg-deb --extract "$vm/$1.deb" "$vm/$1"
  rm "$vm/$1.deb"
  touch "$vm/$1.done"
}

# Sets $version and $modules, the kernel's.
fetch_kernel() {
  mkdir -p "$vm"
  if [ ! -e "$vm/kernel.done" ]; then
    local package
    package=$(apt-cache depends linux-image-amd64 2>/dev/null | sed -n 's/.*Depends: \(linux-image-[0-9].*\)/\1/p' | head -1) || true
    [ -n "$package" ] || skip "apt knows no linux-image-amd64"
    fetch kernel "$package"
  fi
  fetch busybox busybox-static
  version=$(ls "$vm/kernel/lib/modules")
  modules=$vm/kernel/lib/modules/$version/kernel
}

# with_modules ROOT NAME...: copies the modules and what they depend on, and says in which order they are loaded
with_modules() {
  local root=$1 name file depends
  shift
  mkdir -p "$root/lib/modules"
  for name in "$@"; do
    name=${name//-/_}
    [ ! -e "$root/lib/modules/$name.ko" ] || continue
    file=$(find "$modules" -name "${name//_/[-_]}.ko" | head -1)
    [ -n "$file" ] || continue  # part of the kernel
    depends=$(tr '\0' '\n' <"$file" | sed -n 's/^depends=//p' | tr ',' ' ')
    # shellcheck disable=SC2086
    with_modules "$root" $depends
    cp "$file" "$root/lib/modules/$name.ko"
    echo "$name"
  done
}

# as_initrd ROOT FILE: as it is, unpacking is slow there
as_initrd() { (cd "$1" && find . | "$vm/busybox/bin/busybox" cpio -o -H newc 2>/dev/null) >"$2"; }
