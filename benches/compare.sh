#!/usr/bin/env bash
# Times ncfix beside other programs on the same file and writes the table of the README between its marks. Needs Rust; the interpreter of LinuxCNC
# (Debian package linuxcnc-uspace) is left out where it is not there. Usage: benches/compare.sh [--print]
set -euo pipefail
cd "$(dirname "$0")/.."
rounds=${NCFIX_ROUNDS:-7}
export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$PWD/target}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# A surface milled in lines, as a CAM system writes it: 200,000 blocks, so that the whole tree is kept.
awk 'BEGIN {
    print "G17 G21 G90 G94\nG54\nG0 X0 Y0 Z20\nG1 Z1 F2500"
    for (k = 0; k < 200000; k++) {
        row = int(k / 400); place = k % 400; along = row % 2 ? 399 - place : place
        x = along * 0.37; y = row * 0.3
        printf "N%d X%.4f Y%.4f Z%.4f\n", k + 10, x, y, -5 * sin(x * 0.05) * cos(y * 0.03)
    }
    print "M2"
}' > "$folder/surface.ngc"
lines=$(wc -l < "$folder/surface.ngc")

cargo build --quiet --release --manifest-path benches/peers/Cargo.toml
"$CARGO_TARGET_DIR/release/peers" "$folder/surface.ngc" "$rounds" > "$folder/times"

if command -v rs274 > /dev/null; then
    for ((round = 0; round < rounds; round++)); do
        start=$(date +%s%N)
        rs274 -g "$folder/surface.ngc" > /dev/null 2>&1
        echo $(($(date +%s%N) - start))
    done | sort -n | awk '{ t[NR] = $1 / 1e9 } END { printf "rs274 of LinuxCNC, execute\t%.4f\t%.4f\n", t[1], t[int((NR + 1) / 2)] }' >> "$folder/times"
fi

awk -F'\t' -v lines="$lines" 'BEGIN { print "| what | million blocks/s |\n| --- | ---: |" } { printf "| %s | %.2f |\n", $1, lines / $3 / 1e6 }' "$folder/times" > "$folder/table"
cat "$folder/table"
if [ "${1:-}" != --print ]; then
    awk -v table="$folder/table" '
        /<!-- compare begins -->/ { print; while ((getline line < table) > 0) print line; skip = 1 }
        /<!-- compare ends -->/ { skip = 0 }
        !skip' README.md > "$folder/README.md"
    cp "$folder/README.md" README.md
fi
