#!/bin/sh
# Makes the site: the documents, with search, and the library's reference.
#
#     tools/packaging/site.sh FOLDER
#
# FOLDER receives the site, FOLDER/index.html first. Needs `.ci/packages.sh site`. Ends with status 1 if a link leads nowhere.
set -eu
cd "$(dirname "$0")/../.."
mkdir -p "$1"
out=$(cd "$1" && pwd)
.ci/packages.sh site
sources=$(mktemp -d)
trap 'rm -rf "$sources"' EXIT
/usr/bin/python3 tools/packaging/site.py gather "$sources"
/usr/bin/python3 -m sphinx -q -W --keep-going -j "$(nproc)" -d "$sources.cache" "$sources" "$out"
rm -rf "$sources.cache"
/usr/bin/python3 tools/packaging/site.py headers "$sources"
echo "OUTPUT_DIRECTORY = $out" | cat tools/packaging/Doxyfile "$sources/Doxyfile" - | doxygen -q -
/usr/bin/python3 tools/packaging/site.py check "$out"
