# `just` lists the recipes (https://just.systems). Each runs the step of `.ci/run` with the same name.

_list:
    @just --list --unsorted

# the program: target/release/ncfix
build:
    .ci/run build

# tests that take about a minute in total, each in a process of its own (cargo-nextest)
quick:
    .ci/run quick

# all tests
test:
    .ci/run test

# longer runs of `adversary` (controls that answer falsely) and `differential` (random programs)
slow:
    .ci/run slow

# format of all files
fmt:
    .ci/run fmt

# lints, without and with the feature opcua
clippy:
    .ci/run clippy

# documentation without broken links
doc:
    .ci/run doc

# the book of docs/, into book/ (mdbook)
book:
    .ci/run book

# licences, sources and advisories of dependencies
deny:
    .ci/run deny

# build with the oldest supported Rust
msrv:
    .ci/run msrv

# the packages of all crates
package:
    .ci/run package

# the benches build and run
benches:
    .ci/run benches

# comparison with LinuxCNC's interpreter
oracle:
    .ci/run oracle

# tests of the pages in Chromium
browser:
    .ci/run browser

# links and sensors with independent programs at the other end
counterparts:
    .ci/run counterparts

# all checks that must pass before a change lands
all:
    .ci/run all

# all checks that must pass before a release
release:
    .ci/run release
