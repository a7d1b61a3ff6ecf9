#!/usr/bin/env bash
# Reads an OPC UA server of asyncua with `ncfix sensors --watch`. Skipped if it is not there and cannot be installed.
# Usage: tests/real/opcua.sh [release|debug]; NCFIX_BIN=PROGRAM takes one that is built already, with the feature opcua.
set -euo pipefail
cd "$(dirname "$0")/../.."
profile=${1:-debug}
folder=$(mktemp -d)
server= watcher=
trap 'for one in $watcher $server; do kill -CONT "$one" 2>/dev/null || true; kill "$one" 2>/dev/null || true; done; rm -rf "$folder"' EXIT

python=python3
if ! "$python" -c 'import asyncua' 2>/dev/null; then
    if python3 -m venv "$folder/venv" >/dev/null 2>&1 && timeout 180 "$folder/venv/bin/pip" install --quiet asyncua >/dev/null 2>&1; then
        python="$folder/venv/bin/python"
    else
        echo "skipped: asyncua (from PyPI) is not installed and could not be installed"
        exit 0
    fi
fi
ncfix=${NCFIX_BIN:-}
if [ -z "$ncfix" ]; then
    if [ "$profile" = release ]; then cargo build --locked --release --quiet --features opcua; else cargo build --locked --quiet --features opcua; fi
    ncfix="${CARGO_TARGET_DIR:-target}/$profile/ncfix"
fi

port=14840
serve() {
    : >"$folder/ready"
    "$python" tests/real/opcua_server.py "$port" >"$folder/ready" 2>>"$folder/server.log" &
    server=$!
    for _ in $(seq 300); do
        if grep -q ready "$folder/ready"; then return; fi
        sleep 0.1
    done
    cat "$folder/server.log"
    exit 1
}
source_of() { printf '[source.%s]\nkind = "opcua"\nurl = "opc.tcp://localhost:%s"\ntimeout_s = 1\n' "$1" "$port"; }
channel() { printf '[channel.%s]\nsource = "%s"\nnode = "%s"\n' "$@"; }

# Values, and why there are none.
serve
{
    echo 'poll_s = 0.5'
    source_of open
    source_of user
    printf 'user = "ncfix"\npassword_env = "OPCUA_PASSWORD"\n'
    source_of stranger
    printf 'user = "ncfix"\npassword_env = "OPCUA_WRONG"\n'
    source_of timed
    echo 'use_time = true'
    channel number open 'ns=2;s=Machine.T_head'
    channel below_zero open 'ns=2;i=17'
    echo 'scale = 0.1'
    channel float open 'ns=2;g=09087e75-8e5e-499b-954f-f2a9603db28a'
    channel opaque open 'ns=2;b=TWFjaGluZQ=='
    echo 'unit = "mC"'
    channel bad open 'ns=2;s=bad'
    channel uncertain open 'ns=2;s=uncertain'
    channel by_hand open 'ns=2;s=set by hand'
    channel truth open 'ns=2;s=truth'
    channel text open 'ns=2;s=text'
    channel array open 'ns=2;s=array'
    channel unknown open 'ns=2;s=nowhere'
    channel steady open 'ns=2;s=old'
    channel with_password user 'ns=2;s=Machine.T_head'
    channel refused stranger 'ns=2;s=Machine.T_head'
    channel old timed 'ns=2;s=old'
    channel young timed 'ns=2;s=stamped'
} >"$folder/S.toml"
export OPCUA_PASSWORD=secret OPCUA_WRONG=wrong
"$ncfix" sensors "$folder/S.toml" --watch --for 10 --json >"$folder/lines.json" || [ $? = 4 ]
python3 tests/real/sensors.py "$folder/lines.json" number=21.5 below_zero=-5.5 float=22.4 opaque=24.5 'bad=!BadNoCommunication' \
    'uncertain=!UncertainLastUsableValue' 'by_hand=!GoodLocalOverride' 'truth=!a truth value' 'text=!a text' 'array=!an array' \
    'unknown=!BadNodeIdUnknown' steady=23.5 with_password=21.5 'refused=!does not open a session' 'old=! s old' young=25.5 \
    || { cat "$folder/server.log"; exit 1; }

# A server that hangs, goes on, is gone and comes again.
{ echo 'poll_s = 0.3'; echo 'max_age_s = 3'; echo 'confirm = 1'; source_of s; channel T s 'ns=2;s=Machine.T_head'; } >"$folder/R.toml"
: >"$folder/again.json"
"$ncfix" sensors "$folder/R.toml" --watch --for 60 --json >>"$folder/again.json" &
watcher=$!
# Waits for a state, in lines that are newer than those seen before.
seen=0
until_state() {
    for _ in $(seq 250); do
        if tail -n "+$((seen + 1))" "$folder/again.json" | grep -q "$1"; then
            seen=$(wc -l <"$folder/again.json")
            echo "ok    $2"
            return
        fi
        sleep 0.1
    done
    echo "WRONG $2: not within 25 s"
    tail -n 2 "$folder/again.json"
    cat "$folder/server.log"
    exit 1
}
good='"state":"good"' gone='"fault":"disconnected"'
until_state "$good" "good at first"
kill -STOP "$server"
until_state "$gone" "disconnected while the server hangs"
kill -CONT "$server"
until_state "$good" "good when it goes on"
kill "$server"
wait "$server" 2>/dev/null || true
until_state "$gone" "disconnected when it is gone"
serve
until_state "$good" "good when it has come again"
kill "$watcher"
