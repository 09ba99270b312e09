#!/bin/sh
# Renders the pictures of the documents into docs/pictures/.
#   tools/pictures.sh [BUILD]
set -eu
cd "$(dirname "$0")/.."
penumbra=${1:-build}/penumbra
tools/view_pictures.sh "${1:-build}"

picture() { # scene options...
    scene=$1
    shift
    echo "docs/pictures/$scene.png"
    "$penumbra" render "builtin:$scene" -o "docs/pictures/$scene.png" "$@"
}
# By the default method, exact; twice as large as they are shown.
picture room -s 1920x1080
picture spheres-9x9 -s 960x720
picture fence -s 960x720
picture jack-in-the-box -s 960x720

mkdir -p docs/pictures/scenes
for scene in $("$penumbra" scenes --json | sed -n 's/.*"name": *"\([^"]*\)".*/\1/p'); do
    echo "docs/pictures/scenes/$scene.png"
    "$penumbra" render "builtin:$scene" -m reference -o "docs/pictures/scenes/$scene.png" \
        -s 240x180 -n 256 -q
done

# Methods and their failures, small, beside the truth of the same scene.
mkdir -p docs/pictures/methods
method() { # picture scene method option...
    picture=docs/pictures/methods/$1.png
    scene=$2
    method=$3
    shift 3
    "$penumbra" methods "$method" >/dev/null 2>&1 || return 0
    echo "$picture"
    "$penumbra" render "builtin:$scene" -m "$method" -o "$picture" -s 320x240 -q "$@"
}
method two-boxes-truth two-boxes reference -n 4096
method two-boxes-reference-16 two-boxes reference -n 16
method two-boxes-exact two-boxes exact
method two-boxes-planar-3 two-boxes planar -n 3
method two-boxes-planar-16 two-boxes planar
method two-boxes-sampled-maps-4 two-boxes sampled-maps -n 4
method two-boxes-sampled-maps-16 two-boxes sampled-maps
method two-boxes-hard-map two-boxes hard-map
method two-boxes-hard-volume two-boxes hard-volume
method two-boxes-pcss two-boxes pcss
method two-boxes-dbuffer two-boxes dbuffer
method two-boxes-wedge two-boxes wedge
method two-boxes-wedge-probabilistic two-boxes wedge-probabilistic
method two-boxes-wedge-blend two-boxes wedge-blend
method two-boxes-line-map two-boxes line-map
method thin-wires-truth thin-wires reference -n 4096
method thin-wires-planar-3 thin-wires planar -n 3
method thin-wires-planar-64 thin-wires planar -n 64
method light-in-solid-truth light-in-solid reference -n 4096
method light-in-solid-pcss light-in-solid pcss
method light-in-solid-hard-volume light-in-solid hard-volume
method fence-truth fence reference -n 4096
method fence-exact fence exact
method fence-hard-map fence hard-map -p size=256
method fence-sampled-maps-16 fence sampled-maps

# The figures of the paper on planar shadows, where rsvg-convert is there to draw them.
figures=$(mktemp -d)
trap 'rm -rf "$figures"' EXIT
"${penumbra%/*}/examples/example-planar_figures" "$figures" >/dev/null
for figure in 6 7 8; do
    echo "docs/pictures/planar-figure-$figure.png"
    rsvg-convert -b white -w 480 "$figures/planar-figure-$figure.svg" \
        -o "docs/pictures/planar-figure-$figure.png" || break
done
planar() { # name scene options...
    picture=docs/pictures/$1.png
    scene=$2
    shift 2
    echo "$picture"
    "$penumbra" render "$scene" -o "$picture" -q "$@"
}
planar planar-figure-9 builtin:knot -s 480x360 -m planar -n 3
planar planar-tolerance builtin:knot -s 480x360 -m planar -p tolerance=0.0039
for samples in 8 32; do
    planar "planar-knot-$samples" builtin:knot -s 320x240 -m planar -n "$samples"
done
planar planar-knot-truth builtin:knot -s 320x240 -m reference -n 1024
models=${PNB_MODELS:-../shared/models}
mkdir -p docs/pictures/planar-models
for model in spot cow stanford-bunny teapot; do
    [ -f "$models/$model.obj" ] || continue
    for samples in 3 8 16 32; do
        planar "planar-models/$model-$samples" "$models/$model.obj" -s 200x150 -m planar \
            -n "$samples"
    done
done

# The baselines on OpenGL, and the engine's window (docs/opengl.md).
mkdir -p docs/pictures/opengl
baseline() { # name method option...
    name=$1
    method=$2
    shift 2
    "$penumbra" render builtin:disk -m "$method" -s 400x300 -q -o "docs/pictures/opengl/disk-$name.png" "$@"
}
baseline truth exact
if baseline hard-volume hard-volume; then
    baseline sampled-maps sampled-maps -n 16 -p path=opengl
    baseline pcss pcss
fi
engine=$(dirname "$penumbra")/examples/example-engine_gl
if [ -x "$engine" ] && command -v xvfb-run >/dev/null 2>&1; then
    xvfb-run -a -s '-screen 0 640x480x24' "$engine" --method pcss --light disk --size 480x360 \
        --frames 2 --check --screenshot docs/pictures/engine-gl.png
fi

# The figures of the D-buffer's paper beside the truth, and what the method fails at.
mkdir -p docs/pictures/dbuffer
pair() { # name scene options...
    name=$1 scene=$2
    shift 2
    for method in dbuffer exact; do
        picture=docs/pictures/dbuffer/$name-$method.png
        echo "$picture"
        "$penumbra" render "$scene" -m "$method" -o "$picture" -s 240x180 -q "$@"
    done
}
disk() { # radius
    echo "{\"type\": \"disk\", \"center\": [0.3, 3.2, 0.4], \"normal\": [0, -1, 0], \"radius\": $1}"
}
pair prism-0.2 builtin:prism --light "$(disk 0.2)"
pair prism-0.8 builtin:prism --light "$(disk 0.8)"
pair prism builtin:prism
for scene in distance-1 distance-2 distance-3 distance-4 \
    light-size-1 light-size-2 light-size-3 light-size-4 complex; do
    pair "$scene" "builtin:$scene"
done
for texels in 32 128 512; do
    picture=docs/pictures/dbuffer/size-$texels.png
    echo "$picture"
    "$penumbra" render builtin:distance-4 -m dbuffer -o "$picture" -s 240x180 -q -p size=$texels \
        -p filter=nearest
done
# Where umbra and outer boundary are more than 1.5 texels off.
marked=$(mktemp -d)
"$penumbra" bench dbuffer --boundary --pictures "$marked"
for scene in distance-3 light-size-2; do
    cp "$marked/$scene.png" "docs/pictures/dbuffer/boundary-$scene.png"
done
rm -r "$marked"
# A blade: two silhouette edges that meet at 8 degrees.
blade=$(mktemp -d)
cat >"$blade/blade.obj" <<'OBJ'
v -0.9 1 0
v 0.9 1 0.126
v 0.9 1 -0.126
v 0.5 1.05 0
f 1 3 2
f 1 2 4
f 2 3 4
f 3 1 4
OBJ
cat >"$blade/blade.json" <<'SCENE'
{"camera": {"eye": [0.6, 2.8, 3.4], "target": [0, 0.3, 0], "up": [0, 1, 0], "vertical_fov_degrees": 36},
 "lights": [{"type": "disk", "center": [0, 3, 0], "normal": [0, -1, 0], "radius": 0.3}],
 "objects": [{"name": "ground", "plane": {"point": [0, 0, 0], "normal": [0, 1, 0], "half_size": 8}},
             {"name": "blade", "mesh": "blade.obj", "color": [0.72, 0.38, 0.22]}]}
SCENE
pair blade "$blade/blade.json"
rm -r "$blade"
