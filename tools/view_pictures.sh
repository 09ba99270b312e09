#!/bin/sh
# Makes the pictures of docs/view.md, under an X server of its own.
#   tools/view_pictures.sh [BUILD]
set -eu
cd "$(dirname "$0")/.."
build=${1:-build}
[ -x "$build/viewer/penumbra-view" ] || { echo "view_pictures: built without the viewer"; exit 0; }
command -v xvfb-run >/dev/null || { echo "view_pictures: no xvfb-run"; exit 0; }
script=$(mktemp)
trap 'rm -f "$script"' EXIT
export GTK_A11Y=none GSK_RENDERER=cairo GDK_BACKEND=x11

picture() { # scene options...; standard input is the script
    cat >"$script"
    xvfb-run -a -s '-screen 0 1600x1000x24' "$build/penumbra" view "$@" -s 800x600 --script "$script"
}
picture builtin:jack-in-the-box <<'END'
truth 256
zoom 1.9
page light
wait 400
wait rest
wait 500
window docs/pictures/view.png
END
picture builtin:two-boxes --methods line-map,planar <<'END'
theme dark
truth 256
zoom 1.3
wait 400
show error
wait rest
wait 500
divider 0.55
point 380 380
wait 100
window docs/pictures/view-error.png
END
echo "docs/pictures/view.png"
echo "docs/pictures/view-error.png"
