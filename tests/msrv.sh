#!/usr/bin/env bash
# The crate, its tests and its benches build with the oldest Rust that Cargo.toml states. Needs rustup; skipped if it cannot install
# that version.
set -euo pipefail
cd "$(dirname "$0")/.."

version=$(sed -n 's/^rust-version = "\(.*\)"$/\1/p' Cargo.toml).0
if ! rustup toolchain install "$version" --profile minimal > /dev/null 2>&1; then
    echo "skipped: Rust $version is not installed and could not be installed"
    exit 0
fi
printf '\n== cargo +%s check --all-targets\n' "$version"
RUSTFLAGS="-D warnings" CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-target}/msrv" cargo "+$version" check --locked --all-targets
