#!/usr/bin/env bash
# What deny.toml says of the dependencies. Needs cargo-deny, and gets it where crates.io can be reached; says so and ends well elsewhere.
set -euo pipefail
cd "$(dirname "$0")/.."

if ! cargo deny --version > /dev/null 2>&1 && ! cargo install --quiet --locked cargo-deny; then
    echo "cargo-deny cannot be had here: dependencies are not looked at"
    exit 0
fi
printf '\n== cargo deny check licenses bans sources\n'
cargo deny --locked check licenses bans sources
printf '\n== cargo deny check advisories\n'
if ! cargo deny fetch db > /dev/null 2>&1; then
    echo "the advisories of RustSec cannot be had here: what was fetched before is used, if anything"
    databases=("${CARGO_HOME:-$HOME/.cargo}"/advisory-dbs/*/)
    [ -d "${databases[0]}" ] || exit 0
    cargo deny --locked --offline check advisories
    exit 0
fi
cargo deny --locked check advisories
