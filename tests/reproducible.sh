#!/usr/bin/env bash
# Two release builds in different folders, with different homes of cargo, are the same file to the byte. Takes two cold builds (six minutes on
# two cores), so `.ci/run` leaves it out; run it before a release.
set -euo pipefail
cd "$(dirname "$0")/.."

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
home=${CARGO_HOME:-$HOME/.cargo}
for name in one another/and/deeper; do
    mkdir -p "$work/$name"
    git archive HEAD | tar -x -C "$work/$name"
    # The same crates from another place.
    mkdir -p "$work/$name.home"
    cp -r "$home/registry" "$work/$name.home/registry"
    printf '\n== cargo build --release in %s\n' "$work/$name"
    (
        cd "$work/$name"
        export CARGO_HOME="$work/$name.home" CARGO_TARGET_DIR="$work/$name.target"
        # What panics say of files must not say where the build was.
        export RUSTFLAGS="--remap-path-prefix=$CARGO_HOME=/cargo --remap-path-prefix=$PWD=/ncfix --remap-path-prefix=$CARGO_TARGET_DIR=/target"
        RUSTUP_HOME="${RUSTUP_HOME:-$HOME/.rustup}" "$home/bin/cargo" build --release --locked --offline --quiet
    )
    sha256sum "$work/$name.target/release/ncfix"
done
cmp "$work/one.target/release/ncfix" "$work/another/and/deeper.target/release/ncfix"
echo "both builds are the same"
