#!/usr/bin/env bash
# Fuzzes every target, or those that are named, for so long each: fuzz/run.sh SECONDS [TARGET…]. One process at a time, at low priority.
# Needs a nightly toolchain and cargo-fuzz (cargo install cargo-fuzz --locked); says so and ends well without them.
# Samples are copied into fuzz/corpus/TARGET, what breaks a property lies in fuzz/artifacts/TARGET, what was done in fuzz/summary.tsv.
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=${1:?usage: fuzz/run.sh SECONDS [TARGET…]}
shift

if ! cargo +nightly fuzz --version >/dev/null 2>&1; then
    echo "not fuzzed: a nightly toolchain or cargo-fuzz is not installed; cargo test runs the same properties (tests/fuzzing.rs)"
    exit 0
fi
# NAME and folders of each row of TARGETS, where the rows may name a list of folders.
rows=$(python3 - <<'PYTHON'
import re
text = open("fuzz/src/lib.rs", encoding="utf-8").read()
lists = {name: re.findall(r'"([^"]+)"', body) for name, body in re.findall(r"const (\w+): &\[&str\] =\s*&\[(.*?)\];", text, re.S)}
for name, seeds in re.findall(r'name: "(\w+)",\s*seeds: (&\[.*?\]|\w+),\s*run', text, re.S):
    print(name, *(lists.get(seeds) or re.findall(r'"([^"]+)"', seeds)))
PYTHON
)
# No unsafe code of ours: the sanitizers would only cost time.
cargo +nightly fuzz build --fuzz-dir fuzz --sanitizer none
printf 'target\texecutions\tseconds\tfeatures\tfindings\n' >fuzz/summary.tsv
status=0
while read -r target folders; do
    if [ $# -gt 0 ] && [[ " $* " != *" $target "* ]]; then continue; fi
    mkdir -p "fuzz/corpus/$target" "fuzz/artifacts/$target"
    for folder in $folders; do
        find "$folder" -maxdepth 1 -type f -size -40k -exec cp -n {} "fuzz/corpus/$target/" \;
    done
    log="fuzz/artifacts/$target.log"
    # In a process of its own that is begun again behind each finding, so that one does not hide the others.
    nice -n 10 cargo +nightly fuzz run --fuzz-dir fuzz --sanitizer none "$target" -- -fork=1 -ignore_crashes=1 -ignore_timeouts=1 \
        -ignore_ooms=1 -timeout=10 -rss_limit_mb=2048 -max_len=4000 -max_total_time="$seconds" >"$log" 2>&1 || true
    last=$(grep -a '^#.*cov:' "$log" | tail -n 1 || true)
    found=$(find "fuzz/artifacts/$target" -type f | wc -l)
    executions=$(sed -E 's/^#([0-9]+):.*/\1/' <<<"$last")
    features=$(sed -nE 's/.* ft: ([0-9]+).*/\1/p' <<<"$last")
    printf '%s\t%s\t%s\t%s\t%s\n' "$target" "$executions" "$seconds" "$features" "$found" | tee -a fuzz/summary.tsv
    [ "$found" = 0 ] || status=1
done <<<"$rows"
exit $status
