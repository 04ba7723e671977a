#!/bin/sh
# The one list of what VDBLIC needs, and the one place that installs it.
#
#     .ci/packages.sh         all: also what the other tools, the tests and the gate need
#     .ci/packages.sh main    what turns velocities into pictures and a film: vdblic_advect, vdblic_render and ffmpeg
#     .ci/packages.sh site    what tools/packaging/site.sh needs
#     .ci/packages.sh arm64   what tests/compare_builds.sh arm64 needs; on Debian alone, libraries for ARM64 in build/arm64-root
#
# Each line names a Debian package and a probe that shows it is there: a command, a header, a file, a Python module of
# /usr/bin/python3, or a sanitizer of clang. As root on Debian the missing ones are installed; anywhere else they are named
# and the status is 1, so that a caller can stop before a confusing compiler error.
set -u

main_needs() {
    cat <<'LIST'
git                     command git
g++                     command c++
cmake                   command cmake
ninja-build             command ninja
ccache                  command ccache
pkg-config              command pkg-config
libopenvdb-dev          header  openvdb/openvdb.h
libblosc-dev            header  blosc.h
libboost-iostreams-dev  header  boost/iostreams/stream.hpp
zlib1g-dev              header  zlib.h
libxxhash-dev           header  xxhash.h
libtbb-dev              header  tbb/parallel_for.h
libopenexr-dev          header  OpenEXR/ImfOutputFile.h
libpng-dev              header  png.h
libcairo2-dev           header  cairo/cairo.h
libfontconfig-dev       header  fontconfig/fontconfig.h
libassimp-dev           header  assimp/Importer.hpp
libembree-dev           header  embree3/rtcore.h
fonts-dejavu-core       file    /usr/share/fonts/truetype/dejavu/DejaVuSans.ttf
libboost-math-dev       header  boost/math/distributions/students_t.hpp
libglm-dev              header  glm/glm.hpp
libcli11-dev            header  CLI/CLI.hpp
libfmt-dev              header  fmt/format.h
nlohmann-json3-dev      header  nlohmann/json.hpp
ffmpeg                  command ffmpeg
LIST
}

others_need() {
    cat <<'LIST'
libturbojpeg0-dev       header  turbojpeg.h
libopenmpi-dev          command mpicxx
openmpi-bin             command mpirun
libgtest-dev            header  gtest/gtest.h
python3-openvdb         python  pyopenvdb
python3-numpy           python  numpy
pybind11-dev            header  pybind11/pybind11.h
python3-dev             command python3-config
python3-vtk9            python  vtkmodules
python3-netcdf4         python  netCDF4
python3-xarray          python  xarray
python3-pint            python  pint
python3-pyproj          python  pyproj
python3-cfgrib          python  cfgrib
python3-zarr            python  zarr
python3-h5py            python  h5py
libopenvdb-tools        command vdb_print
openexr                 command exrheader
openimageio-tools       command idiff
xvfb                    command xvfb-run
xauth                   command xauth
groff-base              command groff
python3-mpi4py          python  mpi4py
openfoam                command icoFoam
blender                 command blender
chromium                command chromium
chromium-driver         command chromedriver
python3-selenium        python  selenium
clang                   command clang++
clang-format            command clang-format
clang-tidy              command run-clang-tidy
libclang-rt-14-dev      clang   fuzzer
LIST
}

site_needs() {
    cat <<'LIST'
doxygen                 command doxygen
python3-sphinx          python  sphinx
python3-myst-parser     python  myst_parser
furo                    python  furo
LIST
}

arm64_needs() {
    cat <<'LIST'
g++-aarch64-linux-gnu   command aarch64-linux-gnu-g++
qemu-user-static        command qemu-aarch64-static
LIST
}

# The libraries of `main` and GoogleTest for ARM64, as their packages hold them, in a folder of their own: none is installed.
# Links and files of CMake that name a path below /usr are led back into the folder.
unpack_for_arm64() {
    root=$(realpath "$(dirname "$0")/..")/build/arm64-root
    packages="$(main_needs | awk '$2 == "header" { print $1 }') libgtest-dev"
    [ "$(cat "$root/packages" 2>/dev/null)" != "$packages" ] || return 0
    echo "unpacking for ARM64: $(echo "$packages" | tr '\n' ' ')" >&2
    rm -rf "$root"
    mkdir -p "$root/apt/lists/partial" "$root/apt/archives/partial"
    : >"$root/apt/status"
    # shellcheck disable=SC2086
    for command in update "install -y --download-only --no-install-recommends $packages"; do
        apt-get -qq -o APT::Architecture=arm64 -o APT::Architectures=arm64 -o APT::Sandbox::User=root \
            -o Dir::State="$root/apt" -o Dir::State::status="$root/apt/status" -o Dir::Cache="$root/apt" $command >&2 ||
            return 1
    done
    for package in "$root"/apt/archives/*.deb; do
        dpkg-deb -x "$package" "$root" || return 1
    done
    rm -rf "$root/apt"
    find "$root" -type l -lname '/*' | while read -r link; do ln -sfnr "$root$(readlink "$link")" "$link"; done
    find "$root/usr/lib" -name '*.cmake' -exec \
        sed -Ei 's#/usr/(lib/aarch64-linux-gnu/lib|include")#${CMAKE_SYSROOT}&#g' {} +
    echo "$packages" >"$root/packages"
}

case ${1-} in
    main) needs() { main_needs; } ;;
    site) needs() { site_needs; } ;;
    arm64) needs() { main_needs && arm64_needs; } ;;
    '') needs() { main_needs && others_need; } ;;
    *) echo "usage: .ci/packages.sh [main|site|arm64]" >&2 && exit 2 ;;
esac

present() {
    case $1 in
        command) command -v "$2" >/dev/null 2>&1 ;;
        header) printf '#if !__has_include(<%s>)\n#error missing\n#endif\n' "$2" | c++ -std=c++20 -E -x c++ - >/dev/null 2>&1 ;;
        clang) echo 'extern "C" int LLVMFuzzerTestOneInput(const char*, unsigned long) { return 0; }' |
            clang++ -fsanitize="$2" -x c++ - -o /dev/null >/dev/null 2>&1 ;;
        file) [ -e "$2" ] ;;
        python) /usr/bin/python3 -c "import importlib.util as u, sys; sys.exit(u.find_spec('$2') is None)" >/dev/null 2>&1 ;;
    esac
}

missing() { needs | while read -r package kind what; do present "$kind" "$what" || printf '%s ' "$package"; done; }

list=$(missing)
if [ -n "$list" ] && [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null 2>&1; then
    echo "installing: $list" >&2
    export DEBIAN_FRONTEND=noninteractive
    # shellcheck disable=SC2086
    { apt-get update -qq && apt-get install -y -qq --no-install-recommends $list; } >&2 || exit 1
    list=$(missing)
fi
if [ -n "$list" ]; then
    echo "missing, by Debian's package names: $list" >&2
    exit 1
fi
[ "${1-}" != arm64 ] || unpack_for_arm64
