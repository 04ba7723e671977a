#!/bin/sh
# Gets what tests drive and Debian lacks, from PyPI: a current Blender (bpy), OpenUSD (usd-core), NumPy with Matplotlib, and mypy,
# each in a virtual environment below $VDBLIC_PEERS, by default ~/.cache/vdblic/peers. Tests skip by name what is not there.
#
#     tests/peers.sh [bpy|usd:usd-core|numpy:matplotlib|mypy ...]     some of them; all by default
set -eu
folder=${VDBLIC_PEERS:-$HOME/.cache/vdblic/peers}
[ $# -gt 0 ] || set -- bpy usd:usd-core numpy:matplotlib mypy
for peer; do
    environment=$folder/${peer%%:*}
    [ -x "$environment/bin/python" ] || python3 -m venv "$environment"
    "$environment/bin/python" -m pip install --quiet --upgrade "${peer##*:}" numpy ||
        echo "${peer##*:} cannot be had; its tests will be skipped" >&2
done
