#!/usr/bin/env bash
# Feeds a job of several hundred lines to the simulator of LinuxCNC over linuxcncrsh and reads back where its axes are.
# Skipped if LinuxCNC is not there and cannot be installed. Usage: tests/real/linuxcnc.sh [release|debug]; NCFIX_BIN: a program that is built already.
# NCFIX_FEED: another program to feed with, called with the name of the link, the port and the file.
set -euo pipefail
cd "$(dirname "$0")/../.."
profile=${1:-debug}
port=5107
lines=${NCFIX_REAL_LINES:-500}

if ! command -v linuxcncrsh >/dev/null && [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
    echo "installing linuxcnc-uspace"
    { apt-get update && DEBIAN_FRONTEND=noninteractive timeout 300 apt-get install -y --no-install-recommends linuxcnc-uspace; } >/dev/null 2>&1 || true
fi
if ! command -v linuxcncrsh >/dev/null; then
    echo "skipped: LinuxCNC (Debian package linuxcnc-uspace) is not installed and could not be installed"
    exit 0
fi

folder=$(mktemp -d)
fail() { echo "FAILED: $*" >&2; exit 1; }
at_linuxcnc() { python3 tests/real/linuxcnc.py "$@"; }

feed() {
    if [ -n "${NCFIX_FEED:-}" ]; then
        "$NCFIX_FEED" linuxcnc "tcp:127.0.0.1:$port" "$1"
    else
        "$ncfix" feed "$1" --machine tests/real/machine.toml --port "tcp:127.0.0.1:$port" --link linuxcnc --allow-starvation
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

# LinuxCNC does not run as root.
as_user=()
if [ "$(id -u)" = 0 ]; then
    id lcnc >/dev/null 2>&1 || useradd --create-home lcnc
    as_user=(runuser -u lcnc --)
fi
config="$folder/lc"
cp -r /usr/share/doc/linuxcnc/examples/sample-configs/sim/axis "$config"
cat >"$config/head.ini" <<INI
[EMC]
VERSION = 1.1
[DISPLAY]
DISPLAY = linuxcncrsh -p $port
[TASK]
TASK = milltask
CYCLE_TIME = 0.001
[RS274NGC]
PARAMETER_FILE = sim.var
[EMCIO]
EMCIO = io
CYCLE_TIME = 0.100
TOOL_TABLE = sim_mm.tbl
[EMCMOT]
EMCMOT = motmod
SERVO_PERIOD = 1000000
[HAL]
HALFILE = LIB:basic_sim.tcl
[TRAJ]
COORDINATES = XYZ
LINEAR_UNITS = mm
ANGULAR_UNITS = degree
MAX_LINEAR_VELOCITY = 200
MAX_LINEAR_ACCELERATION = 2000
[KINS]
JOINTS = 3
KINEMATICS = trivkins coordinates=XYZ
INI
for joint in 0 1 2; do
    axis=$(echo "X Y Z" | cut -d' ' -f$((joint + 1)))
    limits="MAX_VELOCITY = 200
MAX_ACCELERATION = 2000
MIN_LIMIT = -500
MAX_LIMIT = 500"
    printf '[JOINT_%s]\nTYPE = LINEAR\nHOME_SEQUENCE = 0\nHOME_SEARCH_VEL = 0\nHOME_LATCH_VEL = 0\nFERROR = 10\nMIN_FERROR = 5\n%s\n[AXIS_%s]\n%s\n' \
        "$joint" "$limits" "$axis" "$limits" >>"$config/head.ini"
done
chmod 755 "$folder"
[ "${#as_user[@]}" = 0 ] || chown -R lcnc "$config"

"${as_user[@]}" linuxcnc "$config/head.ini" >"$folder/log" 2>&1 &
launcher=$!
finish() {
    at_linuxcnc "$port" shutdown >/dev/null 2>&1 || true
    for _ in $(seq 40); do
        kill -0 "$launcher" 2>/dev/null || break
        sleep 0.5
    done
    kill "$launcher" 2>/dev/null || true
    rm -rf "$folder"
}
trap finish EXIT
for _ in $(seq 120); do
    if (exec 3<>"/dev/tcp/127.0.0.1/$port") 2>/dev/null; then break; fi
    sleep 0.5
done
(exec 3<>"/dev/tcp/127.0.0.1/$port") 2>/dev/null || { cat "$folder/log" >&2; fail "LinuxCNC does not start"; }

end=$(at_linuxcnc program "$lines" "$folder/good.ngc")
bad=7
at_linuxcnc program 20 "$folder/bad.ngc" "$bad" >/dev/null

echo "== not switched on, it gets no line"
if said=$(feed "$folder/good.ngc" 2>&1); then fail "a machine in emergency stop was fed"; fi
grep -q "emergency stop" <<<"$said" || fail "$said"

at_linuxcnc "$port" ready
echo "== $lines lines"
said=$(feed "$folder/good.ngc" 2>&1) || fail "$said"
grep -E "^(lines|executed)" <<<"$said"
# Every line that was sent was executed.
read -r done all < <(sed -nE 's/^lines +([0-9,]+) of ([0-9,]+) acknowledged.*/\1 \2/p' <<<"$said" | tr -d ,)
[ "$done" = "$all" ] && grep -q "^executed  *$(sed -nE 's/^lines +([0-9,]+) of.*/\1/p' <<<"$said")$" <<<"$said" || fail "$said"
position=$(at_linuxcnc "$port" position)
echo "planned $end, read back $position"
python3 - "$end" "$position" <<'PY' || fail "the axes are not where the program ends"
import sys
planned, there = ([float(value) for value in text.split()] for text in sys.argv[1:3])
sys.exit(max(abs(a - b) for a, b in zip(planned, there)) > 1e-5)
PY

echo "== a line that it refuses"
if said=$(feed "$folder/bad.ngc" 2>&1); then fail "a bad line was not refused"; fi
# Its words: the move exceeds the limit of joint 0.
grep -qE "refused line [0-9]+: .*limit" <<<"$said" || fail "$said"
grep -i "radius\|refused" <<<"$said" | tail -n 1
echo "LinuxCNC: all as planned"
