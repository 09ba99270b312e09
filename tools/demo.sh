#!/bin/sh
# Renders the demo into demo/: a picture, its visibility, and methods against the truth.
#   tools/demo.sh [BUILD]
set -eu
cd "$(dirname "$0")/.."
penumbra=${1:-build}/penumbra
scene=builtin:jack-in-the-box
mkdir -p demo

echo "demo: the reference picture and its visibility"
"$penumbra" render $scene -m reference -n 1024 -o demo/picture.png \
    --visibility demo/visibility.png --visibility demo/visibility.pfm
echo "demo: the same as EXR, with depth, normals and positions, by the default method"
"$penumbra" render $scene -o demo/picture.exr
echo "demo: methods against the truth"
"$penumbra" compare $scene -s 400x300 -o demo/compare

echo
echo "demo: look at demo/picture.png, demo/visibility.png, and in a browser at"
echo "demo: $PWD/demo/compare/index.html"
