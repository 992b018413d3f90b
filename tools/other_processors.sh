#!/usr/bin/env bash
# Plans the shipped scenarios with builds for other processors, and on emulated ones, and compares the digests with the golden
# ones. Takes minutes and about 2 GB: each build is made anew, in a temporary folder unless CARGO_TARGET_DIR is set. The
# emulators are those that are there: valgrind (no SHA extensions), qemu-x86_64 from QEMU (a processor of 2003, one of 2008).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

readonly EMULATED=(flat_walk ibeam_gap)
scratch=$(mktemp -d)
readonly scratch
trap 'rm -rf "$scratch"' EXIT
export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$scratch/target}
failures=0

report() {
  local what=$1
  shift
  if "$@" >"$scratch/log" 2>&1; then
    echo "same plans: $what"
  else
    echo "OTHER PLANS, or a failure: $what"
    tail -n 20 "$scratch/log"
    failures=$((failures + 1))
  fi
}

emulated() {
  local walk expected got
  for walk in "${EMULATED[@]}"; do
    expected=$(awk -v walk="$walk" '$1 == walk { print $3 }' tests/data/golden_digests.txt)
    "$@" "$CARGO_TARGET_DIR/release/surefoot" plan "configs/scenarios/$walk.toml" --quiet --threads 1 --json "$scratch/plan.json"
    got=$(python3 -c 'import json, sys; print(json.load(open(sys.argv[1]))["digest"])' "$scratch/plan.json")
    [[ $got == "$expected" ]] || { echo "$walk: $got, expected $expected"; return 1; }
  done
}

cargo build --release --quiet
command -v valgrind >/dev/null && report "valgrind's processor" emulated valgrind --quiet --tool=none
if command -v qemu-x86_64 >/dev/null; then
  for processor in qemu64 Nehalem; do
    report "qemu's $processor" emulated qemu-x86_64 -cpu "$processor"
  done
fi
for processor in x86-64-v2 x86-64-v3 native; do
  RUSTFLAGS="-C target-cpu=$processor" report "built for $processor" \
    cargo test --release --package surefoot-planner --test determinism every_build
done
exit "$((failures > 0))"
