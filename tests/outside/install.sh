#!/bin/sh
# Installs into an empty folder and uses what lies there as a stranger would: pkg-config, compile,
# run; the example of the README; the program and its man page.
#   install.sh BUILD SOURCE PREFIX CC
build=$1 source=$2 prefix=$3 cc=$4
stage=$(mktemp -d)
trap 'rm -rf "$stage"' EXIT
number=0 bad=0

report() { # status name
    number=$((number + 1))
    if [ "$1" = 0 ]; then
        echo "ok $number - $2"
    else
        echo "not ok $number - $2"
        bad=1
    fi
}

echo 1..6
unset DESTDIR
meson install -C "$build" --no-rebuild --destdir "$stage" >"$stage/log" 2>&1
status=$?
[ $status = 0 ] || sed 's/^/# /' "$stage/log"
report $status installs

root=$stage$prefix
pc=$(find "$root" -name penumbra.pc)
export PKG_CONFIG_PATH="$(dirname "$pc")" PKG_CONFIG_SYSROOT_DIR="$stage"
library=$(dirname "$(dirname "$pc")")
export LD_LIBRARY_PATH="$library"
compile() {
    # shellcheck disable=SC2046
    $cc -std=c11 -Wall -Werror "$1" -o "$2" $(pkg-config --cflags --libs penumbra) -lm
}

compile "$source/examples/points.c" "$stage/points" && "$stage/points" >"$stage/out"
report $? points_by_pkg_config

awk '/^```c$/ { on = 1; next } /^```$/ { on = 0 } on' "$source/README.md" >"$stage/readme.c"
[ -s "$stage/readme.c" ] && compile "$stage/readme.c" "$stage/readme" &&
    (cd "$stage" && ./readme && [ -s shadow.png ])
report $? readme_example

(cd "$stage" && "$root/bin/penumbra" render builtin:prism -q -s 80x60 -n 16 -o out.png && [ -s out.png ])
report $? installed_program_renders

printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' >"$stage/one.obj"
(cd "$stage" && "$root/bin/penumbra" info one.obj >out.txt && grep -q '1 triangles' out.txt)
report $? installed_program_imports

[ -s "$root/share/man/man1/penumbra.1" ] || [ -s "$root/share/man/man1/penumbra.1.gz" ]
report $? man_page_is_there
exit $bad
