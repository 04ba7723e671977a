#!/bin/sh
# Makes the site: the documents, with search, the library's reference, and flows that move.
#
#     tools/packaging/site.sh FOLDER [TOOLS]
#
# FOLDER receives the site, FOLDER/index.html first. TOOLS is the folder of the built tools, build/release/tools by default.
# Needs `.ci/packages.sh site`. Ends with status 1 if a link leads nowhere.
set -eu
cd "$(dirname "$0")/../.."
mkdir -p "$1"
out=$(cd "$1" && pwd)
tools=$(cd "${2:-build/release/tools}" && pwd)
.ci/packages.sh site
sources=$(mktemp -d)
trap 'rm -rf "$sources"' EXIT
/usr/bin/python3 tools/packaging/site.py gather "$sources"
mkdir -p "$sources/pages/flows" "$sources/velocity"
"$tools/vdblic_synth" tornado -q -o "$sources/velocity/tornado.%04d.vdb" --size 72 72 48 --frames 1-24 >/dev/null
"$tools/vdblic_synth" rossby -q -o "$sources/velocity/rossby.%04d.vdb" --frames 1-24 >/dev/null
cp samples/wake/wake.*.vdb "$sources/velocity"
for flow in wake tornado rossby; do
    "$tools/vdblic_film" "$sources/velocity/$flow.%04d.vdb" -q -o "$sources/pages/flows/$flow.html"
done >/dev/null
rm -r "$sources/velocity"
/usr/bin/python3 -m sphinx -q -W --keep-going -j "$(nproc)" -d "$sources.cache" "$sources" "$out"
rm -rf "$sources.cache"
/usr/bin/python3 tools/packaging/site.py headers "$sources"
echo "OUTPUT_DIRECTORY = $out" | cat tools/packaging/Doxyfile "$sources/Doxyfile" - | doxygen -q -
/usr/bin/python3 tools/packaging/site.py check "$out"
