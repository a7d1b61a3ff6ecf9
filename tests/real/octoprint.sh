#!/usr/bin/env bash
# Feeds OctoPrint's virtual printer (Marlin) over a pseudo-terminal, with the errors that it can simulate: what it carries out is what was planned.
# Skipped if it cannot be installed. Usage: tests/real/octoprint.sh [release|debug]; NCFIX_BIN: a program that is built already.
# NCFIX_FEED: another program to feed with, called with the name of the link, the port and the file. NCFIX_OCTOPRINT: a folder with its environment.
set -euo pipefail
cd "$(dirname "$0")/../.."
profile=${1:-debug}

folder=$(mktemp -d)
printer=
finish() {
    [ -z "$printer" ] || kill "$printer" 2>/dev/null || true
    rm -rf "$folder"
}
trap finish EXIT
fail() { echo "FAILED: $*" >&2; exit 1; }

venv=${NCFIX_OCTOPRINT:-$folder/venv}
if [ ! -x "$venv/bin/python" ]; then
    echo "installing OctoPrint"
    { python3 -m venv "$venv" && timeout 600 "$venv/bin/pip" install --quiet OctoPrint==1.11.8; } >/dev/null 2>&1 || true
fi
if ! "$venv/bin/python" -c 'import octoprint' 2>/dev/null; then
    echo "skipped: OctoPrint (PyPI) is not installed and could not be installed"
    exit 0
fi

feed() {
    if [ -n "${NCFIX_FEED:-}" ]; then
        "$NCFIX_FEED" marlin "$folder/port" "$1"
    else
        "$ncfix" feed "$1" --machine tests/real/machine.toml --port "$folder/port" --link marlin
    fi
}
if [ -z "${NCFIX_FEED:-}" ]; then
    ncfix=${NCFIX_BIN:-}
    if [ -z "$ncfix" ]; then
        if [ "$profile" = release ]; then cargo build --locked --release --quiet; else cargo build --locked --quiet; fi
        ncfix="${CARGO_TARGET_DIR:-target}/$profile/ncfix"
    fi
    if ! "$ncfix" --help | grep -qE "^ +feed "; then
        echo "skipped: this ncfix cannot feed"
        exit 0
    fi
fi

for k in $(seq 300); do echo "G1 X$((k % 90)).$((k % 10)) Y$((k * 7 % 90)) F6000"; done >"$folder/job.gcode"

job() {
    echo "== $1"
    rm -f "$folder/port" "$folder/ready" "$folder"/*.journal*
    "$venv/bin/python" tests/real/virtual_printer.py "$folder/port" "$2" "$folder/record" >"$folder/ready" &
    printer=$!
    for _ in $(seq 100); do
        if [ -s "$folder/ready" ]; then break; fi
        sleep 0.2
    done
    [ -s "$folder/ready" ] || fail "the virtual printer does not start"
    said=$(feed "$folder/job.gcode" 2>&1) || fail "$said"
    tail -n 1 <<<"$said"
    for _ in $(seq 50); do
        kill -0 "$printer" 2>/dev/null || break
        sleep 0.2
    done
    kill "$printer" 2>/dev/null || true
    # The words are compared, not how they are spaced or whether a number ends with a zero.
    plain() { tr -d ' ' <"$1" | sed -E 's/\.0+([A-Z]|$)/\1/g'; }
    diff <(plain "$folder/job.gcode") <(plain "$folder/record") >"$folder/diff" ||
        fail "it did not carry out what was planned: $(head -n 5 "$folder/diff")"
    wc -l <"$folder/record"
}
quiet='"throttle": 0.0, "sendWait": false'
job "without errors" "{$quiet, \"simulated_errors\": []}"
# Not its "resend_with_timeout": there the printer counts the line as received and never carries it out.
# Lines are numbered behind what opens the job, from 1003 on.
job "demands, a missing number, a wrong checksum" \
    "{$quiet, \"simulated_errors\": [\"1100:resend\", \"1110:missing_lineno\", \"1115:checksum_mismatch\"]}"
job "lines that it does not hear, and busy" \
    "{$quiet, \"sendBusy\": true, \"simulated_errors\": [\"1050:resend\"], \"unheard\": [1060, 1061, 1200]}"
echo "OctoPrint's virtual printer: all as planned"
