#!/bin/sh
# Installs the Debian packages of packages/debian.txt that are missing.
#   INSTALL=0   only names them, and fails if there are any
# Where there is no dpkg it says which libraries the build looks for, and goes on.
set -eu
cd "$(dirname "$0")"
wanted=$(sed 's/#.*//' debian.txt | tr -s ' \t\n' ' ')

if ! command -v dpkg-query >/dev/null 2>&1 || ! command -v apt-get >/dev/null 2>&1; then
    echo "set-up: this is no Debian; the build needs what these Debian packages hold:"
    echo "set-up: $wanted"
    exit 0
fi

installed=$(dpkg-query -W -f '${Package} ${db:Status-Status}\n' $wanted 2>/dev/null |
    awk '$2 == "installed" { print $1 }' || true)
missing=""
for package in $wanted; do
    if ! printf '%s\n' "$installed" | grep -qxF -- "$package"; then
        missing="$missing $package"
    fi
done
[ -n "$missing" ] || exit 0

if [ "${INSTALL:-1}" = 0 ]; then
    echo "set-up: missing packages:$missing"
    echo "set-up: install them with: apt-get install --no-install-recommends$missing"
    exit 1
fi
if [ "$(id -u)" = 0 ]; then
    as_root=""
elif command -v sudo >/dev/null 2>&1; then
    as_root=sudo
else
    echo "set-up: missing packages:$missing"
    echo "set-up: neither root nor sudo here; as root: apt-get install --no-install-recommends$missing"
    exit 1
fi

echo "set-up: installing packages:$missing"
echo "set-up: (from the Debian mirror; this may take some minutes)"
install() {
    $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends \
        -o Dpkg::Use-Pty=0 $missing >/dev/null
}
known=yes
for package in $missing; do
    apt-cache show "$package" >/dev/null 2>&1 || known=no
done
# Package lists that are absent or out of date: fetch them, then once more.
if [ $known = no ]; then
    $as_root apt-get update -qq
    install
else
    install || { $as_root apt-get update -qq && install; }
fi
