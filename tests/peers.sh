#!/bin/sh
# Gets what tests drive and Debian lacks, from PyPI: a current Blender (bpy), OpenUSD (usd-core), NumPy with Matplotlib, mypy, and
# what runs notebooks, each in a virtual environment below $VDBLIC_PEERS, by default ~/.cache/vdblic/peers. Tests skip by name what is not there.
#
#     tests/peers.sh [bpy|usd:usd-core|numpy:matplotlib|mypy|notebooks ...]     some of them; all by default
set -eu
folder=${VDBLIC_PEERS:-$HOME/.cache/vdblic/peers}
[ $# -gt 0 ] || set -- bpy usd:usd-core numpy:matplotlib mypy notebooks
for peer; do
    environment=$folder/${peer%%:*}
    [ -x "$environment/bin/python" ] || python3 -m venv "$environment"
    packages=${peer##*:}
    [ "$peer" != notebooks ] || packages='nbclient jupytext ipykernel matplotlib xarray cftime pint pyproj vtk'
    # shellcheck disable=SC2086  # several packages
    "$environment/bin/python" -m pip install --quiet --upgrade $packages numpy ||
        echo "$packages cannot be had; its tests will be skipped" >&2
done
