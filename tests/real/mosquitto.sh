#!/usr/bin/env bash
# Reads messages of a mosquitto broker with `ncfix sensors --watch`. Skipped if it is not there and cannot be installed.
# Usage: tests/real/mosquitto.sh [release|debug]; NCFIX_BIN: a program that is built already.
set -euo pipefail
cd "$(dirname "$0")/../.."
profile=${1:-debug}
folder=$(mktemp -d)
broker= talker=
trap 'for one in $broker $talker; do kill "$one" 2>/dev/null || true; done; rm -rf "$folder"' EXIT

has_mosquitto() {
    PATH="$PATH:/usr/sbin" command -v mosquitto >/dev/null && command -v mosquitto_pub >/dev/null
}
if ! has_mosquitto && [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
    echo "installing mosquitto"
    { apt-get update && DEBIAN_FRONTEND=noninteractive timeout 300 apt-get install -y --no-install-recommends mosquitto mosquitto-clients; } >/dev/null 2>&1 || true
fi
if ! has_mosquitto; then
    echo "skipped: mosquitto (Debian packages mosquitto, mosquitto-clients) is not installed and could not be installed"
    exit 0
fi
ncfix=${NCFIX_BIN:-}
if [ -z "$ncfix" ]; then
    if [ "$profile" = release ]; then cargo build --locked --release --quiet; else cargo build --locked --quiet; fi
    ncfix="${CARGO_TARGET_DIR:-target}/$profile/ncfix"
fi

port=18883
printf 'ncfix:secret\n' >"$folder/passwords"
mosquitto_passwd -U "$folder/passwords"
chmod 644 "$folder/passwords"
chmod 755 "$folder"
printf 'listener %s 127.0.0.1\nallow_anonymous false\npassword_file %s\n' "$port" "$folder/passwords" >"$folder/mosquitto.conf"
PATH="$PATH:/usr/sbin" mosquitto -c "$folder/mosquitto.conf" >"$folder/broker.log" 2>&1 &
broker=$!
say() { mosquitto_pub -h 127.0.0.1 -p "$port" -u ncfix -P secret "$@"; }
for _ in $(seq 50); do
    if say -t ready -m 1 2>/dev/null; then break; fi
    sleep 0.1
done
printf 'secret\n' >"$folder/right"
printf 'wrong\n' >"$folder/wrong"

# Retained: without a time, with an old one, with a young one that ncfix hears only once.
say -r -t kept/plain -m 21.5
say -r -t kept/old -m "{\"value\": 22.5, \"time\": \"2020-01-01T00:00:00Z\"}"
say -r -t kept/young -m "{\"value\": 23.5, \"time\": \"$(date -u +%Y-%m-%dT%H:%M:%SZ)\"}"
say -r -t live/number -m 99.5
for _ in $(seq 60); do
    say -t live/number -m 24.5 || true
    say -t live/object -m '{"temperature": 25.5, "humidity": 40}' || true
    sleep 0.3
done &
talker=$!

channel() { printf '[channel.%s]\nsource = "%s"\ntopic = "%s"\n' "$@"; }
source_of() { printf '[source.%s]\nkind = "mqtt"\naddress = "127.0.0.1:%s"\nusername = "ncfix"\npassword_file = "%s"\n' "$@"; }
{
    echo 'poll_s = 0.5'
    source_of s "$port" right
    source_of w "$port" wrong
    channel plain s kept/plain
    channel old s kept/old
    channel young s kept/young
    echo 'confirm = 1'
    channel number s live/number
    channel object s live/object
    echo 'key = "temperature"'
    channel refused w live/number
} >"$folder/S.toml"
"$ncfix" sensors "$folder/S.toml" --watch --for 10 --json >"$folder/lines.json" || [ $? = 4 ]
python3 tests/real/sensors.py "$folder/lines.json" 'plain=!retained message of unknown age' 'old=! s old' young=23.5 number=24.5 object=25.5 'refused=!NotAuthorized' \
    || { cat "$folder/broker.log"; exit 1; }
