#!/usr/bin/env bash
# Opens pages of `ncfix diff --html` in Chromium and holds them against the JSON object and against arithmetic.
# Skipped if Chromium, Node or playwright-core are not there and cannot be installed. Usage: tests/browser/run.sh [release|debug]
# NCFIX_BIN: a program that is built already. NCFIX_SCREENSHOTS: a folder for pictures. NCFIX_BROWSER_SHORT=1: without a million lines.
set -euo pipefail
cd "$(dirname "$0")/../.."
profile=${1:-debug}
modules="${CARGO_TARGET_DIR:-target}/browser"

browser() { type -P chromium || type -P chromium-browser || type -P google-chrome; }
has_node() { command -v npm >/dev/null && node -e 'process.exit(process.versions.node.split(".")[0] < 20 ? 1 : 0)' 2>/dev/null; }
install() {
    [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null || return 0
    echo "installing $*"
    { apt-get update && DEBIAN_FRONTEND=noninteractive timeout 300 apt-get install -y --no-install-recommends "$@"; } >/dev/null 2>&1 || true
}

browser >/dev/null || install chromium
has_node || install nodejs npm
if ! browser >/dev/null || ! has_node; then
    echo "skipped: Chromium or Node 20 (Debian packages chromium, nodejs, npm) is not installed and could not be installed"
    exit 0
fi
mkdir -p "$modules"
if ! cmp -s tests/browser/package-lock.json "$modules/package-lock.json" || [ ! -d "$modules/node_modules/playwright-core" ]; then
    echo "installing playwright-core"
    cp tests/browser/package.json tests/browser/package-lock.json "$modules/"
    { timeout 300 npm ci --prefix "$modules" --ignore-scripts --no-audit --no-fund; } >/dev/null 2>&1 || true
fi
if [ ! -d "$modules/node_modules/playwright-core" ]; then
    rm -f "$modules/package-lock.json"
    echo "skipped: playwright-core (npm) is not installed and could not be installed"
    exit 0
fi

ncfix=${NCFIX_BIN:-}
if [ -z "$ncfix" ]; then
    if [ "$profile" = release ]; then cargo build --locked --release --quiet; else cargo build --locked --quiet; fi
    ncfix="${CARGO_TARGET_DIR:-target}/$profile/ncfix"
fi
if ! "$ncfix" diff --help | grep -q -e --html; then
    echo "skipped: this ncfix writes no page"
    exit 0
fi

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
NCFIX_BIN=$(realpath "$ncfix") NCFIX_CHROMIUM=$(browser) NCFIX_MODULES=$(realpath "$modules") NCFIX_FOLDER=$folder \
    node --test --test-reporter=spec tests/browser/review.mjs
