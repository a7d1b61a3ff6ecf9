#!/usr/bin/env bash
# Reads a Modbus server of pymodbus with `ncfix sensors --watch`. Skipped if it is not there and cannot be installed.
# Usage: tests/real/pymodbus.sh [release|debug]; NCFIX_BIN: a program that is built already.
set -euo pipefail
cd "$(dirname "$0")/../.."
profile=${1:-debug}
folder=$(mktemp -d)
server=
trap '[ -z "$server" ] || kill "$server" 2>/dev/null || true; rm -rf "$folder"' EXIT

python=python3
if ! "$python" -c 'import pymodbus' 2>/dev/null; then
    if python3 -m venv "$folder/venv" >/dev/null 2>&1 && timeout 120 "$folder/venv/bin/pip" install --quiet pymodbus >/dev/null 2>&1; then
        python="$folder/venv/bin/python"
    else
        echo "skipped: pymodbus (from PyPI) is not installed and could not be installed"
        exit 0
    fi
fi
ncfix=${NCFIX_BIN:-}
if [ -z "$ncfix" ]; then
    if [ "$profile" = release ]; then cargo build --locked --release --quiet; else cargo build --locked --quiet; fi
    ncfix="${CARGO_TARGET_DIR:-target}/$profile/ncfix"
fi

port=15502
"$python" tests/real/modbus_server.py "$port" >"$folder/server.log" 2>&1 &
server=$!
cat >"$folder/S.toml" <<TOML
poll_s = 0.5
[source.s]
kind = "modbus"
address = "127.0.0.1:$port"
[channel.signed]
source = "s"
address = 10
type = "i16"
scale = 0.1
[channel.below_zero]
source = "s"
address = 11
type = "i16"
scale = 0.1
[channel.none]
source = "s"
address = 12
type = "i16"
[channel.float]
source = "s"
address = 20
type = "f32"
[channel.swapped]
source = "s"
address = 22
type = "f32"
words = "low_first"
[channel.holding]
source = "s"
table = "holding"
address = 30
type = "u32"
unit = "mC"
[channel.beyond]
source = "s"
address = 5000
type = "i16"
TOML
"$ncfix" sensors "$folder/S.toml" --watch --for 10 --json >"$folder/lines.json" || [ $? = 4 ]
python3 tests/real/sensors.py "$folder/lines.json" signed=21.5 below_zero=-5.5 'none=!no value' float=22.5 swapped=23.5 holding=24.5 \
    'beyond=!illegal data address (exception 2)' || { cat "$folder/server.log"; exit 1; }
