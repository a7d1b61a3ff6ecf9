#!/usr/bin/env bash
# Whether two programs `ncfix` put out the same: every sample through every command that takes it, the tutorial, the pages of the manual, and the part
# programs of a folder. Exit status, standard output, standard error and files are compared byte by byte; how long something took is left out.
#
#   tests/same_outputs.sh BEFORE AFTER [FOLDER]
#
# FOLDER has a folder for each language (sinumerik, grundig, fanuc, rs274) with part programs at any depth. For a change that moves code and nothing else.
set -euo pipefail
if [ $# -lt 2 ]; then
    sed -n '5p' "$0"
    exit 2
fi
before=$(realpath "$1") after=$(realpath "$2") folder=${3:+$(realpath "$3")}
root=$(cd "$(dirname "$0")/.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# What a run may say of time and of the folder that it ran in.
plain() { sed -E -e 's/^(time +)[0-9.]+ s/\1T s/' -e 's/"(seconds|time_s|elapsed_s)":[0-9.e-]+/"\1":T/g' -e "s#$1#DIR#g"; }

# run FOLDER NAME ARGUMENTS…: one command, and what it leaves.
run() {
    local name=$1 status=0
    shift
    timeout 60 "$BIN" "$@" >"$name.out" 2>"$name.err" </dev/null || status=$?
    printf '%s\n' "$status" >"$name.status"
}

# All that one binary says, in a folder of its own: job NAME…
job() {
    local kind=$1 path=$2 machine=${3:-}
    local name
    name=$(printf '%s' "$kind ${path#"$root"/} $(basename "${machine:-none}")" | tr -c 'A-Za-z0-9._-' _)
    mkdir -p "$OUT/$name"
    cd "$OUT/$name"
    case $kind in
    program)
        # Some of them never end.
        local short=(--machine "$machine" --max-blocks 100000)
        run check check "$path" "${short[@]}"
        run check_json check "$path" --json "${short[@]}"
        run snc snc "$path" "${short[@]}"
        run fix "$path" -o fix.nc "${short[@]}"
        run fix_json "$path" -o fix_json.nc --json "${short[@]}"
        run ways "$path" -o ways.nc --rapids all --arcs chords --rotary correct "${short[@]}"
        run axes "$path" -o axes.nc --frame machine --rapids none --rotary hold "${short[@]}"
        run step "$path" -o step.nc --step 2mm "${short[@]}"
        if [ -s fix.nc ]; then
            run verify verify "$path" fix.nc --machine "$machine"
            run verify_json verify "$path" fix.nc --json --machine "$machine"
            run diff diff "$path" fix.nc --machine "$machine"
            run page diff "$path" fix.nc --html page.html --machine "$machine"
        fi
        ;;
    public)
        local short=(--machine "$machine" --max-blocks 100000)
        run check check "$path" --json "${short[@]}"
        run snc snc "$path" "${short[@]}"
        run fix "$path" -o fix.nc "${short[@]}"
        ;;
    machine)
        run check machine check "$path"
        run show machine show "$path" --at X10,Y20,Z30 --tool 100
        run origin machine show "$path" --origin
        run check_json machine check "$path" --json
        ;;
    table)
        for each in "$root"/samples/machines/*.toml; do
            run "check_$(basename "$each")" tables --read "$path" --check --machine "$each"
        done
        ;;
    made)
        for format in $(printf '%s' "cec comp grid"); do
            run "$format" tables --machine "$path" --format "$format" -o "table.$format"
        done
        ;;
    sensors) run check sensors "$path" --dry-run ;;
    words)
        run help --help
        run codes explain --all
        "$BIN" --help | sed -nE 's/^  ([a-z]+)  +[A-Z].*/\1/p' | while read -r command; do
            run "help_$command" help "$command"
            run "man_$command" man "$command"
        done
        sed -nE 's/.*"([EW][0-9]{4})".*/\1/p' "$root/src/diagnostic/codes.rs" "$root"/crates/*/src/diagnostic/codes.rs 2>/dev/null |
            sort -u | while read -r code; do run "explain_$code" explain "$code"; done
        for shell in bash zsh fish powershell; do run "completions_$shell" completions "$shell"; done
        ;;
    tutorial)
        cp "$root/samples/machines/demo.toml" hidden.toml
        awk '/^```[a-z]+ / { file = $2; next } /^```console/ { console = 1; next } /^```/ { file = ""; console = 0; next }
             file != "" { print > file } console && /^\$ ncfix / { print substr($0, 9) > "commands" }' "$path"
        local number=0
        while read -r -a words; do
            number=$((number + 1))
            run "$number" "${words[@]}"
        done <commands
        ;;
    esac
    # The text of each file, without time and place.
    local file
    find . -type f | while read -r file; do plain "$OUT" <"$file" >"$file.plain" && mv "$file.plain" "$file"; done
}
export -f job run plain
export root

list() {
    local machine
    for language in sinumerik:demo grundig:universal_mill fanuc:vmc rs274:knee_mill; do
        machine="$root/samples/machines/${language#*:}.toml"
        find "$root/samples/programs/${language%:*}" -type f ! -name '*.md' | while read -r path; do
            printf 'program\t%s\t%s\n' "$path" "$machine"
            if [ "${language%:*}" = sinumerik ]; then
                printf 'program\t%s\t%s\n' "$path" "$root/samples/machines/esmaeili_huron.toml"
            fi
        done
        if [ -n "$folder" ] && [ -d "$folder/${language%:*}" ]; then
            find "$folder/${language%:*}" -type f -size -2M | sort | sed "s#^#public\t#; s#\$#\t$machine#"
        fi
    done
    find "$root/samples/machines" -type f -name '*.toml' | sed "s#^#machine\t#"
    find "$root/samples/machines" -maxdepth 1 -type f -name '*.toml' | sed "s#^#made\t#"
    find "$root/samples/tables" -type f ! -name '*.md' | sed "s#^#table\t#"
    find "$root/samples/sensors" -type f -name '*.toml' | sed "s#^#sensors\t#"
    printf 'words\t-\ntutorial\t%s\n' "$root/docs/tutorial.md"
}

list >"$work/jobs"
for side in before after; do
    BIN=${!side} OUT="$work/$side"
    export BIN OUT
    mkdir -p "$OUT"
    tr '\n' '\0' <"$work/jobs" | xargs -0 -P "$(nproc)" -I {} bash -c 'IFS=$'"'\t'"' read -r kind path machine <<<"{}"; job "$kind" "$path" "$machine"'
done
files=$(find "$work/before" -type f | wc -l)
if diff -rq "$work/before" "$work/after" >"$work/differences"; then
    echo "the same: $(wc -l <"$work/jobs") jobs, $files files"
else
    echo "not the same: $(wc -l <"$work/differences") of $files files"
    sed "s#$work/##g" "$work/differences" | head -20
    diff -r "$work/before" "$work/after" | head -60
    exit 1
fi
