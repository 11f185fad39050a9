# Sourced by ./reproduce and ./check: what a fresh Debian 12 lacks, and the build.

# need_packages WHY PACKAGE...: installs those that are missing, saying what and why. Without root
# it prints the command and stops.
need_packages() {
  local why=$1
  shift
  local package missing=()
  for package in "$@"; do
    dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null | grep -qx installed ||
      missing+=("$package")
  done
  if [ ${#missing[@]} -eq 0 ]; then return; fi
  if [ "$(id -u)" -ne 0 ]; then
    echo "Missing ($why): ${missing[*]}" >&2
    echo "Install them and run this again:" >&2
    echo "  sudo apt-get update && sudo apt-get install --no-install-recommends ${missing[*]}" >&2
    exit 3
  fi
  echo "Installing ($why): ${missing[*]}"
  if [ -z "${package_lists_updated:-}" ]; then
    apt-get update -qq
    package_lists_updated=1
  fi
  DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
}

# Node 18 or later and npm, which fetch and bundle the report's page: those that are there, else
# Debian's.
need_node() {
  local version
  version=$(node --version 2>/dev/null || echo v0)
  version=${version#v}
  if [ "${version%%.*}" -ge 18 ] && command -v npm >/dev/null; then return; fi
  need_packages "the report's page" nodejs npm
}

need_packages_to_run() {
  need_packages "the compiler and the build" g++ cmake ninja-build pkg-config git
  need_packages "images, ray tracing, maths" \
    libopenimageio-dev libopenexr-dev libembree-dev libglm-dev
  need_packages "OpenGL without a window; Mesa's llvmpipe where there is no GPU" \
    libegl-dev libepoxy-dev libegl-mesa0 libgl1-mesa-dri
  need_packages "configuration, command line, JSON, text, checksums" \
    libtomlplusplus-dev libcli11-dev nlohmann-json3-dev libfmt-dev libssl-dev
  need_packages "compressed images in the report" zlib1g-dev
  need_packages "power spectra" libkissfft-dev
  need_packages "the history of runs" libsqlite3-dev
  need_node
  need_packages "labels in figures" libfreetype-dev fonts-dejavu-core
}

# build TESTS (ON or OFF): configures and builds the release preset in build/release.
build() {
  cmake --preset release -DOCCLAB_TESTS="$1" >build.log 2>&1 || { cat build.log >&2; exit 3; }
  rm -f build.log
  cmake --build --preset release
}
