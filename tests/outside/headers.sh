#!/bin/sh
# Each public header compiles alone, as C11 and as C++11, without a warning.
#   headers.sh INCLUDE_FOLDER CC [CXX]
folder=$1 cc=$2 cxx=${3:-}
count=0 bad=0
for header in "$folder"/penumbra/*.h; do
    name=penumbra/$(basename "$header")
    for language in c c++; do
        if [ $language = c ]; then
            set -- $cc -x c -std=c11 -Wstrict-prototypes
        else
            [ -n "$cxx" ] || continue
            set -- $cxx -x c++ -std=c++11
        fi
        count=$((count + 1))
        if echo "#include <$name>" | "$@" -Wall -Wextra -pedantic -Werror -fsyntax-only -I"$folder" -; then
            echo "ok $count - $(basename "$header" .h)_is_$language"
        else
            echo "not ok $count - $(basename "$header" .h)_is_$language"
            bad=1
        fi
    done
done
echo "1..$count"
exit $bad
