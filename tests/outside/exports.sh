#!/bin/sh
# The library shows pnb_ symbols and no others; and nothing in it can be written to: no global state.
#   exports.sh LIBRARY.so ARCHIVE.a
echo 1..2
others=$(nm -D --defined-only "$1" | awk '$2 ~ /[A-Z]/ && $3 !~ /^pnb_/ { print $3 }')
if [ -z "$others" ]; then
    echo "ok 1 - only_pnb_symbols_are_exported"
else
    echo "$others" | sed 's/^/# exported: /'
    echo "not ok 1 - only_pnb_symbols_are_exported"
fi
# Sections of data that stay writable once the program runs; .data.rel.ro does not.
state=$(nm --format=sysv "$2" | awk -F '|' '
    { section = $7; name = $1; gsub(/ /, "", section); gsub(/ /, "", name) }
    section ~ /^\.(t?data|t?bss)/ && section !~ /^\.data\.rel\.ro/ && $4 ~ /OBJECT|TLS/ {
        print name " " section
    }
    section == "*COM*" { print name " " section }')
if [ -z "$state" ]; then
    echo "ok 2 - nothing_global_can_change"
else
    echo "$state" | sed 's/^/# state: /'
    echo "not ok 2 - nothing_global_can_change"
fi
[ -z "$others$state" ]
