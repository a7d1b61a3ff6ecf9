#!/usr/bin/env bash
# Holds ncfix against LinuxCNC's interpreter: samples, random programs, and the folder NCFIX_ORACLE_CORPUS if that is set.
# Skipped if the interpreter is not there and cannot be installed. Usage: tests/oracle/run.sh [release|debug]
set -euo pipefail
cd "$(dirname "$0")/../.."
profile=${1:-debug}

judge_works() {
    /usr/bin/python3 -c 'import gcode' 2>/dev/null
}

if ! judge_works && [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
    echo "installing linuxcnc-uspace"
    { apt-get update && DEBIAN_FRONTEND=noninteractive timeout 300 apt-get install -y --no-install-recommends linuxcnc-uspace; } >/dev/null 2>&1 || true
fi
if ! judge_works; then
    echo "skipped: LinuxCNC's interpreter (Debian package linuxcnc-uspace) is not installed and could not be installed"
    exit 0
fi

if [ "$profile" = release ]; then cargo build --locked --release --quiet; else cargo build --locked --quiet; fi
ncfix="${CARGO_TARGET_DIR:-target}/$profile/ncfix"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 tests/oracle/generate.py "${NCFIX_ORACLE_SEED:-1}" "$folder/any" "${NCFIX_ORACLE_COUNT:-60}"
python3 tests/oracle/generate.py "${NCFIX_ORACLE_SEED:-1}" "$folder/correctable" "${NCFIX_ORACLE_COUNT:-60}" correctable

status=0
compare() {
    local threshold=$1 mode=$2
    shift 2
    python3 tests/oracle/compare.py --ncfix "$ncfix" --threshold "$threshold" --mode "$mode" "$@" || status=1
}
compare 100 snc samples/programs/rs274 tests/oracle/programs
compare 100 roundtrip samples/programs/rs274
compare 100 model samples/programs/rs274
compare 100 wear tests/oracle/wear
compare 99 snc "$folder/any"
compare 99 roundtrip "$folder/correctable"
compare 99 model "$folder/correctable"
if [ -n "${NCFIX_ORACLE_CORPUS:-}" ]; then
    compare 99 snc "$NCFIX_ORACLE_CORPUS"
    compare 99 roundtrip "$NCFIX_ORACLE_CORPUS"
    compare 99 model "$NCFIX_ORACLE_CORPUS"
fi
exit $status
