#!/bin/sh
# Installs Debian's packages of a build into a clean Debian, where there is no compiler, and uses them there. Then it adds a
# compiler and builds a program of samples/library with pkg-config.
#
#     tools/packaging/try_debian.sh BUILD ROOT
#
# BUILD is a built tree, such as build/release. ROOT is a folder that is made, by debootstrap, as root. Takes some five
# minutes, and 2 GB.
set -eu
build=$(cd "$1" && pwd)
root=$2
here=$(cd "$(dirname "$0")/../.." && pwd)
[ ! -e "$root" ] || { echo "$root is there: name a folder that is not" >&2; exit 2; }
packages=$(mktemp -d)
trap 'rm -rf "$packages"' EXIT
(cd "$build" && cpack -G DEB -B "$packages" >/dev/null)
ls -l "$packages"/*.deb
if command -v lintian >/dev/null; then lintian --fail-on error "$packages"/*.deb; fi

debootstrap --variant=minbase bookworm "$root" >/dev/null
cp -a /etc/apt/. "$root/etc/apt/"
mkdir "$root/packages" && cp "$packages"/*.deb "$root/packages/" && cp -a "$here/samples/wake" "$root/wake"
chroot "$root" sh -eu -c '
    export DEBIAN_FRONTEND=noninteractive
    apt-get update -qq
    apt-get install -y -qq --no-install-recommends /packages/*.deb man-db ffmpeg >/dev/null
    ! command -v c++
    cd /tmp
    vdblic_info "/wake/wake.%04d.vdb"
    vdblic_advect "/wake/wake.%04d.vdb" -o "lic.%04d.vdb" --frames 1-4 -q
    vdblic_render "lic.%04d.vdb" -o "image.%04d.png" --film film.mp4 --size 320 180 -q
    python3 -c "import vdblic; print(vdblic.__name__, vdblic.__file__)"
    mpirun --allow-run-as-root -n 1 vdblic_advect_mpi --version
    vdblic_import --help >/dev/null
    man vdblic_advect 2>/dev/null | head -n 4
'
cp "$here/samples/library/field.cpp" "$root/tmp"
chroot "$root" sh -eu -c '
    export DEBIAN_FRONTEND=noninteractive
    apt-get install -y -qq --no-install-recommends g++ pkg-config >/dev/null
    cd /tmp
    c++ field.cpp -o field $(pkg-config --cflags --libs vdblic)
    ./field
'
ls -l "$root/tmp"
echo "the packages work in $root"
