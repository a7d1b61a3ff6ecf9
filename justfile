# `just` lists the recipes (https://just.systems). Each is the step of `.ci/run` with its name.

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

# is everything formatted?
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

# the oldest Rust that is promised
msrv:
    .ci/run msrv

# the packages of all crates
package:
    .ci/run package

# the benches build and run
benches:
    .ci/run benches

# LinuxCNC's interpreter as judge
oracle:
    .ci/run oracle

# pages in Chromium
browser:
    .ci/run browser

# programs of others at the other end of links and sensors
counterparts:
    .ci/run counterparts

# everything that must hold before a change lands
all:
    .ci/run all

# everything that must hold before a release
release:
    .ci/run release
