#!/usr/bin/env bash
# Times ncfix beside other programs on the same file and writes the table of docs/explanation/speed.md between its marks. Needs Rust; the interpreter of LinuxCNC
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

# The whole way from a file to its corrected one: the demo machine with its 21 motion errors as cubic polynomials and nothing else, and
# a five-axis machine whose rotary axes are corrected too.
cargo build --quiet --release
ncfix=$CARGO_TARGET_DIR/release/ncfix
awk -v axes="X Y Z" 'BEGIN { split(axes, axis); split("X Y Z A B C", direction); srand(1) }
    /^\[\[motion\]\]/ { skip = 1 }
    /^\[zero_offset/ && !done {
        done = 1; skip = 0
        for (a = 1; a <= 3; a++) for (d = 1; d <= 6; d++) {
            size = d <= 3 ? 5e-3 : 1e-5
            printf "[[motion]]\ncomponent = \"E%s%s\"\nkind = \"polynomial\"\ncoefficients = [", direction[d], axis[a]
            for (k = 0; k < 4; k++) printf "%s%.4e", k ? ", " : "", (2 * rand() - 1) * size / 300 ^ k
            print "]"
        }
    }
    !skip' samples/machines/demo.toml > "$folder/cubic.toml"
awk 'BEGIN {
    print "G17 G90 G71 G64\nT7\nM6\nG54 D1 S9000 M3\nG0 X0 Y0 Z20\nG1 Z1 F2500"
    for (k = 0; k < 1000000; k++) {
        row = int(k / 400); place = k % 400; along = row % 2 ? 399 - place : place
        x = along * 0.37; y = row % 1000 * 0.3
        printf "N%d X%.4f Y%.4f Z%.4f\n", k + 10, x, y, -5 * sin(x * 0.05) * cos(y * 0.03)
    }
    print "M30"
}' > "$folder/three.mpf"
awk 'BEGIN {
    print "G17 G90 G71 G64\nS9000 M3\nG0 X0 Y0 Z200 B0 C0\nG1 Z150 F2500"
    for (k = 0; k < 300000; k++) {
        row = int(k / 400); place = k % 400; along = row % 2 ? 399 - place : place
        x = along * 0.2; y = row % 500 * 0.2
        printf "N%d X%.4f Y%.4f Z%.4f B%.4f C%.4f\n", k + 10, x, y, 150 - 5 * sin(x * 0.05) * cos(y * 0.03), 20 + 10 * sin(x * 0.02), 30 * sin(y * 0.03)
    }
    print "M30"
}' > "$folder/five.mpf"
whole() { # name, program, machine, threads
    for ((round = 0; round < rounds; round++)); do
        start=$(date +%s%N)
        "$ncfix" fix "$folder/$2.mpf" --machine "$3" -o "$folder/out.mpf" --threads "$4" --quiet
        echo $(($(date +%s%N) - start))
    done | sort -n | awk -v name="$1" -v blocks="$(grep -c . "$folder/out.mpf")" '{ t[NR] = $1 / 1e9 }
        END { printf "%s\t%.4f\t%.4f\t%d\n", name, t[1], t[int((NR + 1) / 2)], blocks }' >> "$folder/times"
}
: > "$folder/out.mpf"
"$ncfix" fix "$folder/three.mpf" --machine "$folder/cubic.toml" -o "$folder/out.mpf" --quiet
whole "ncfix fix, three axes, 21 cubic errors, one thread" three "$folder/cubic.toml" 1
whole "the same on two cores" three "$folder/cubic.toml" 3
"$ncfix" fix "$folder/five.mpf" --machine samples/machines/esmaeili_xyz5.toml -o "$folder/out.mpf" --quiet
whole "ncfix fix, five axes, rotary axes corrected, one thread" five samples/machines/esmaeili_xyz5.toml 1
whole "the same on two cores" five samples/machines/esmaeili_xyz5.toml 3

awk -F'\t' -v lines="$lines" 'BEGIN { print "| what | million blocks/s |\n| --- | ---: |" } { printf "| %s | %.2f |\n", $1, ($4 ? $4 : lines) / $3 / 1e6 }' "$folder/times" > "$folder/table"
cat "$folder/table"
if [ "${1:-}" != --print ]; then
    awk -v table="$folder/table" '
        /<!-- compare begins -->/ { print; while ((getline line < table) > 0) print line; skip = 1 }
        /<!-- compare ends -->/ { skip = 0 }
        !skip' docs/explanation/speed.md > "$folder/speed.md"
    cp "$folder/speed.md" docs/explanation/speed.md
fi
