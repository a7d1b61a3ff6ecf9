#!/usr/bin/env bash
# Checks the dependencies against deny.toml. Needs cargo-deny, and installs it if crates.io can be reached; skipped otherwise.
set -euo pipefail
cd "$(dirname "$0")/.."

if ! cargo deny --version > /dev/null 2>&1 && ! cargo install --quiet --locked cargo-deny; then
    echo "skipped: cargo-deny is not installed and could not be installed"
    exit 0
fi
printf '\n== cargo deny check licenses bans sources\n'
cargo deny --locked check licenses bans sources
printf '\n== cargo deny check advisories\n'
if ! cargo deny fetch db > /dev/null 2>&1; then
    echo "the advisories of RustSec could not be fetched: an earlier copy is used if there is one, else this check is skipped"
    databases=("${CARGO_HOME:-$HOME/.cargo}"/advisory-dbs/*/)
    [ -d "${databases[0]}" ] || exit 0
    cargo deny --locked --offline check advisories
    exit 0
fi
cargo deny --locked check advisories
