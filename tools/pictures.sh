#!/bin/sh
# Renders the pictures of the documents into docs/pictures/.
#   tools/pictures.sh [BUILD]
set -eu
cd "$(dirname "$0")/.."
penumbra=${1:-build}/penumbra
mkdir -p docs/pictures/scenes

picture() { # scene options...
    scene=$1
    shift
    echo "docs/pictures/$scene.png"
    "$penumbra" render "builtin:$scene" -m reference -o "docs/pictures/$scene.png" "$@"
}
picture jack-in-the-box -s 960x540 -n 1024
picture spheres-9x9 -s 480x360 -n 1024
picture fence -s 480x360 -n 1024
picture room -s 480x360 -n 1024

mkdir -p docs/pictures/scenes
for scene in $("$penumbra" scenes --json | sed -n 's/.*"name": *"\([^"]*\)".*/\1/p'); do
    echo "docs/pictures/scenes/$scene.png"
    "$penumbra" render "builtin:$scene" -m reference -o "docs/pictures/scenes/$scene.png" \
        -s 240x180 -n 256 -q
done

for scene in $("$penumbra" scenes | cut -d ' ' -f 1); do
    echo "docs/pictures/scenes/$scene.png"
    "$penumbra" render "builtin:$scene" -m reference -n 256 -s 240x180 \
        -o "docs/pictures/scenes/$scene.png"
done
