#!/bin/sh
# The command line from outside: exit statuses, one-line errors, files that are whole or absent.
#   cli.sh PENUMBRA SOURCE
penumbra=$1 source=$2
stage=$(mktemp -d)
trap 'rm -rf "$stage"' EXIT
cd "$stage" || exit 1
number=0 bad=0
export TERM=xterm

report() { # status name
    number=$((number + 1))
    if [ "$1" = 0 ]; then
        echo "ok $number - $2"
    else
        echo "not ok $number - $2"
        sed 's/^/# /' err 2>/dev/null
        bad=1
    fi
}

# One line that begins as it must.
one_error_line() {
    [ "$(wc -l <err)" = 1 ] && grep -q '^penumbra: error: [^:]*.*: .' err
}

# The argument list must end in this status, with one line on standard error that matches, nothing
# on standard output, and no file made.
refuses() { # name status pattern arguments...
    name=$1 want=$2 pattern=$3
    shift 3
    ls -A >before
    "$penumbra" "$@" >out 2>err </dev/null
    got=$?
    ls -A >after
    [ $got = "$want" ] && one_error_line && grep -q -- "$pattern" err && [ ! -s out ] &&
        cmp -s before after
    status=$?
    [ $status = 0 ] || echo "# exit $got, wanted $want: penumbra $*"
    report $status "$name"
}

: >out
: >err
: >before
: >after

# ---- the command line is wrong: 2 ----
refuses no_command 2 'command is missing'
refuses unknown_command 2 "no command 'rendr'; did you mean 'render'" rendr
refuses unknown_option_instead_of_command 2 "no option '--frobnicate'" --frobnicate
refuses too_much_after_help 2 'too many' --help extra
refuses missing_scene 2 'missing SCENE' render
refuses two_scenes 2 'too many' render a.json b.json
refuses empty_scene_name 2 'empty' render ''
refuses unknown_long_option 2 'did you mean --size' render builtin:prism --sise 3x3
refuses unknown_letter 2 'unknown option -z' render builtin:prism -z
refuses option_of_another_command 2 'does not take --size' info builtin:prism --size 3x3
refuses abbreviated_option 2 'unknown option --sampl' render builtin:prism --sampl 4
refuses missing_value 2 'needs a value' render builtin:prism --size
refuses missing_value_of_a_letter 2 'needs a value' render builtin:prism -n
refuses value_of_a_flag 2 'takes no value' render builtin:prism --json=yes
for size in 800 800x 800x600x2 x600 0x600 800x0 -8x6 +8x6 8.5x6 800x600px 99999x1 65536x65536 \
    99999999999999999999x1 ' 8x6' ''; do
    refuses "size_'$(echo "$size" | tr ' ' _)'" 2 '--size: ' render builtin:prism -s "$size"
done
for samples in 0 -1 1.5 abc '' 1x 99999999999999999999 2000000; do
    refuses "samples_'$samples'" 2 '--samples: ' render builtin:prism -n "$samples"
done
refuses threads_out_of_range 2 '--threads: ' render builtin:prism --threads 0
refuses light_index_not_a_number 2 '--light-index: ' render builtin:prism --light-index one
refuses light_index_out_of_range 2 '--light-index: ' render builtin:prism --light-index 999
refuses unknown_method 2 "no method 'refrence'; did you mean 'reference'" render builtin:prism -m refrence
refuses param_without_value 2 'KEY=VALUE' render builtin:prism -p key
refuses unknown_param 2 'no parameter' render builtin:prism -m reference -p no-such=1
refuses unknown_ending 2 'none of' render builtin:prism -o picture.gif
refuses unknown_visibility_ending 2 'none of' render builtin:prism --visibility v.txt
refuses one_file_for_two 2 'same file' render builtin:prism -o a.pfm --visibility a.pfm
refuses light_is_no_json 2 '--light: ' render builtin:prism --light '{'
refuses light_of_unknown_type 2 '--light: ' render builtin:prism --light '{"type": "lamp"}'
refuses light_of_no_area 2 '--light: ' render builtin:prism --light \
    '{"type": "disk", "center": [0,4,0], "normal": [0,-1,0], "radius": 0}'
refuses compare_without_folder 2 '-o DIR' compare builtin:prism
refuses compare_of_no_samples 2 '--methods: ' compare builtin:prism -o page --methods reference:0
refuses compare_of_an_unknown_method 2 'no method' compare builtin:prism -o page --methods reference,nothing
refuses compare_of_too_few_truths 2 'truth-samples' compare builtin:prism -o page --truth-samples 0
refuses unknown_suite 2 'no such suite' bench no-such-suite
refuses method_that_is_none 2 'no such method' methods no-such-method
refuses scene_name_without_write 2 'needs --write' scenes fence

# ---- the work failed: 1 ----
refuses missing_file 1 'nowhere.json' render nowhere.json
refuses missing_mesh 1 'nowhere.obj' render nowhere.obj
refuses unknown_builtin 1 'nosuch' render builtin:nosuch
mkdir folder.json
refuses scene_is_a_folder 1 'folder.json' render folder.json
: >empty.json
refuses empty_scene 1 'empty.json' render empty.json
: >empty.obj
refuses empty_mesh 1 'empty.obj' render empty.obj
: >empty.glb
refuses empty_glb 1 'empty.glb' render empty.glb
head -c 3000 "$penumbra" >binary.json
cp binary.json binary.glb
cp binary.json binary.obj
cp binary.json noending
refuses binary_scene 1 'binary.json' render binary.json
refuses binary_glb 1 'binary.glb' render binary.glb
refuses binary_mesh 1 'binary.obj' render binary.obj
refuses file_without_ending 1 'noending' render noending
printf '{"objects": [{"name": "a", "mesh": "gone.obj"}]}' >gone.json
refuses mesh_of_a_scene_is_missing 1 'gone.obj' render gone.json
printf '{"objects": [], "lihgts": []}' >unknown.json
refuses unknown_key_is_named 1 'lihgts' render unknown.json
refuses info_of_a_missing_file 1 'nowhere.json' info nowhere.json
refuses output_folder_is_missing 1 'no/such' render builtin:prism -o no/such/a.png
mkdir there.png
refuses output_is_an_existing_folder 1 'is a folder' render builtin:prism -o there.png
refuses output_folder_is_a_file 1 'no folder' render builtin:prism -o empty.json/a.png
refuses output_cannot_be_made 1 '/proc/a.png' render builtin:prism -s 8x8 -m reference -n 1 -o /proc/a.png
refuses visibility_folder_is_missing 1 'no/such' render builtin:prism --visibility no/such/v.pfm
refuses compare_of_a_missing_scene 1 'nowhere.json' compare nowhere.json -o page
refuses compare_with_a_missing_image 1 'nowhere.pfm' compare builtin:prism -o page --image nowhere.pfm
refuses compare_into_a_file 1 'empty.json' compare builtin:prism -s 8x8 -o empty.json
refuses scenes_folder_cannot_be_made 1 'no/such' scenes --write no/such/folder

# ---- it works ----
for line in --help --version 'render --help' 'render --version' 'compare --help' 'info --help' \
    'methods --help' 'scenes --help' 'bench --help' methods scenes 'methods reference' \
    'methods --json' 'scenes --json'; do
    # shellcheck disable=SC2086
    "$penumbra" $line >out 2>err
    [ $? = 0 ] && [ -s out ] && [ ! -s err ]
    report $? "answers_$(echo "$line" | tr ' ' _)"
done

"$penumbra" render builtin:prism -q -s 40x30 -m reference -n 16 >out 2>err && [ -s prism.png ] && [ ! -s out ] && [ ! -s err ]
report $? default_output_is_the_base_name
"$penumbra" render builtin:prism -qs40x30 -mreference -n16 -o all.exr --visibility=v.pfm --visibility v.exr \
    --visibility v.png --json >out 2>err &&
    [ -s all.exr ] && [ -s v.pfm ] && [ -s v.exr ] && [ -s v.png ] && [ ! -s err ] &&
    head -c 3 v.pfm | grep -q '^Pf' && head -c 1 out | grep -q '{'
report $? writes_what_is_asked
for key in method scene width height milliseconds prepare primary visibility shade parameters device \
    threads warnings; do
    grep -q "\"$key\":" out
    report $? "json_has_$key"
done
cp v.pfm v1.pfm
"$penumbra" render builtin:prism -q -s 40x30 -m reference -n 16 --threads 1 --visibility v.pfm 2>err && cmp v.pfm v1.pfm
report $? same_bytes_with_one_thread
"$penumbra" render builtin:prism -q -s 40x30 -m reference -n 4 -o two.png --light-index 1 --light \
    '{"type": "point", "position": [0, 4, 0]}' --light \
    '{"type": "sun", "direction": [0.3, -1, 0.2], "angular_diameter_degrees": 0.53}' 2>err && [ -s two.png ]
report $? lights_of_the_command_line
"$penumbra" render builtin:prism -q -s 40x30 -m reference -n 16 -o c.png --visibility c.pfm 2>err &&
    "$penumbra" compare builtin:prism -q -s 40x30 --methods reference:4,reference:64 --truth-samples 1024 \
        --image c.pfm --image c.png -o page --json >out 2>err &&
    [ -s page/index.html ] && grep -q '"rmse"' page/report.json && ! grep -q 'https*://[^w]' page/index.html
report $? compare_writes_page_and_report
"$penumbra" info builtin:prism >out 2>err && grep -q closed out && grep -q 'lights: 1' out
report $? info_says_what_is_there
"$penumbra" info builtin:prism --json >out 2>err && grep -q '"closed": true' out
report $? info_as_json
"$penumbra" scenes prism --write written >out 2>err && [ -s written/prism.json ] && [ -s written/prism.glb ]
report $? scenes_are_written
"$penumbra" render written/prism.json -q -s 40x30 -n 16 -o a.png 2>err && [ -s a.png ]
report $? written_scene_renders
"$penumbra" render written/prism.glb -q -s 40x30 -n 16 -o b.png 2>err && [ -s b.png ]
report $? written_glb_renders
"$penumbra" render -q -s 40x30 -n 4 -o c.png -- builtin:prism 2>err && [ -s c.png ]
report $? two_dashes_end_the_options

# ---- standard output that fails ----
if [ -w /dev/full ]; then
    for line in --help 'methods' 'info builtin:prism' 'info builtin:prism --json' \
        'render builtin:prism -q -s 8x8 -m reference -n 1 -o full.png --json'; do
        # shellcheck disable=SC2086
        "$penumbra" $line >/dev/full 2>err
        [ $? = 1 ] && one_error_line && grep -q 'standard output' err
        report $? "full_disk_$(echo "$line" | tr ' ' _)"
    done
fi
for line in --help methods 'render builtin:prism -q -s 8x8 -m reference -n 1 -o closed.png --json'; do
    # shellcheck disable=SC2086
    "$penumbra" $line >&- 2>err
    [ $? = 1 ] && one_error_line && grep -q 'standard output' err
    report $? "closed_output_$(echo "$line" | tr ' ' _)"
done
"$penumbra" render builtin:prism -q -s 8x8 -m reference -n 1 -o closed2.png >&- 2>err && [ -s closed2.png ]
report $? closed_output_does_not_matter_to_a_picture
"$penumbra" render nowhere.json >out 2>&-
[ $? = 1 ] && [ ! -s out ]
report $? closed_error_output

# ---- a disk that fills up: a limit on the size of files stands in for it ----
mkdir small
for ending in png exr pfm; do
    (ulimit -f 8 && cd small && exec "$penumbra" render builtin:prism -q -s 400x300 -m reference -n 1 -o "a.$ending") 2>err
    [ $? = 1 ] && one_error_line && grep -q "a.$ending" err && [ -z "$(ls -A small)" ]
    report $? "no_half_written_$ending"
done

# ---- cancelled ----
mkdir stopped
for signal in INT TERM; do
    "$penumbra" render builtin:spheres-9x9 -m reference -s 1600x1200 -n 65536 -o stopped/a.png >out 2>err &
    process=$!
    sleep 1
    kill -$signal $process
    wait $process
    [ $? = 1 ] && one_error_line && grep -q cancelled err && [ ! -s out ] && [ -z "$(ls -A stopped)" ]
    report $? "stops_at_SIG$signal"
done

# ---- nothing is drawn where there is no terminal ----
"$penumbra" render builtin:spheres-9x9 -m reference -s 400x300 -n 256 -o bar.png >out 2>err
[ $? = 0 ] && ! grep -q '%' err
report $? no_progress_bar_on_a_pipe
if script -qec true /dev/null >/dev/null 2>&1; then
    script -qec "'$penumbra' render builtin:spheres-9x9 -m reference -s 800x600 -n 1024 -o bar.png" \
        /dev/null >out 2>err </dev/null
    [ $? = 0 ] && grep -q '[0-9]%.*left [0-9]' out && tail -c 4 out | grep -q '\[K'
    report $? progress_bar_on_a_terminal
else
    number=$((number + 1))
    echo "ok $number # SKIP progress_bar_on_a_terminal"
fi

echo "1..$number"
exit $bad
