#!/usr/bin/env bash
# The crate, its tests and its benches build with the oldest Rust that Cargo.toml promises. Needs rustup; says so and ends well where that
# version cannot be had.
set -euo pipefail
cd "$(dirname "$0")/.."

version=$(sed -n 's/^rust-version = "\(.*\)"$/\1/p' Cargo.toml).0
if ! rustup toolchain install "$version" --profile minimal > /dev/null 2>&1; then
    echo "Rust $version cannot be had here: nothing is built with it"
    exit 0
fi
printf '\n== cargo +%s check --all-targets\n' "$version"
RUSTFLAGS="-D warnings" CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-target}/msrv" cargo "+$version" check --locked --all-targets
