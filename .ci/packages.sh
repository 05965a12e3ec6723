# Sourced by ./check and ./demo: Debian 12's packages that onemap needs, and how to install those that are missing.
# shellcheck shell=bash

build_packages=(
  g++ cmake ninja-build pkg-config ca-certificates
  libeigen3-dev libopencv-features2d-dev libglm-dev libtinygltf-dev nlohmann-json3-dev
  libegl-dev libgles-dev libegl1 libgles2 libgl1-mesa-dri libpng-dev libjpeg62-turbo-dev
  libzstd-dev libxxhash-dev libsodium-dev libtomlplusplus-dev libfmt-dev libcli11-dev libgtest-dev libgmock-dev
  libopenni2-dev libfreenect-dev libusb-1.0-0-dev
)
check_packages=(clang-format clang-tidy python3-minimal python3-numpy umockdev libumockdev-dev)
# They look at pages, completions and units (systemd-analyze): without them those tests are skipped.
looking_packages=(man-db zsh fish systemd)

# install_missing PACKAGE...: says what it is about to install, then installs it as root or with sudo.
install_missing() {
  local missing=() package
  for package in "$@"; do
    dpkg-query -W -f='${db:Status-Status}\n' "$package" 2>/dev/null | grep -qx installed || missing+=("$package")
  done
  [ ${#missing[@]} -gt 0 ] || return 0
  if ! command -v apt-get >/dev/null; then
    echo "missing: ${missing[*]} (this script installs packages on Debian 12 only; install them by hand and run it again)" >&2
    return 1
  fi
  local as_root=()
  if [ "$(id -u)" != 0 ]; then
    command -v sudo >/dev/null || { echo "missing: ${missing[*]}; run as root or install sudo" >&2; return 1; }
    as_root=(sudo)
  fi
  echo "Installing ${#missing[@]} Debian packages: ${missing[*]}"
  "${as_root[@]}" apt-get update -qq &&
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
}

# configure_and_build PRESET [TARGET...]: quiet unless something is wrong; a progress line on a terminal.
configure_and_build() {
  local preset=$1 log=build/$1.log
  shift
  mkdir -p build
  if ! cmake --preset "$preset" >"$log" 2>&1; then
    cat "$log" >&2
    return 1
  fi
  local targets=()
  [ $# -eq 0 ] || targets=(--target "$@")
  if [ -t 1 ]; then
    cmake --build --preset "$preset" "${targets[@]}"
  elif ! cmake --build --preset "$preset" "${targets[@]}" >>"$log" 2>&1; then
    grep -A30 -m3 -E 'FAILED|error' "$log" >&2 || tail -50 "$log" >&2
    return 1
  fi
}
