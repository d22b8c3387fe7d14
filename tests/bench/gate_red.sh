#!/usr/bin/env bash
# Does tools/bench-gate see a slow-down? Takes limits from the program as it is, and holds the one with a planted
# slow-down of its convolutions (planted_slow_down.hpp) to them.
#   gate_red.sh SOURCES BENCH_GUARDED BENCH_GUARDED_SLOW
set -euo pipefail
gate=$1/tools/bench-gate program=$2 slow=$3
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
limits=$scratch/limits.json
fail() {
  echo "gate_red: $1" >&2
  cat "$scratch"/*.txt >&2
  exit 1
}
run() {  # exit code wanted, words
  local wanted=$1 code=0
  shift
  "$gate" --limits "$limits" --only 'conv2d/16-32@14/forward|sensor_noise' "$@" >"$scratch/out.txt" 2>"$scratch/err.txt" || code=$?
  ((code == wanted)) || fail "exit code $code of $*, not $wanted"
}
run 2 --program "$program"  # no limits yet
grep -q 'limits.json' "$scratch/err.txt" || fail "does not name the limits that are not there"
run 0 --program "$program" --update
run 0 --program "$program"
grep -q 'within 2% of their limits' "$scratch/out.txt" || fail "does not say that all is well"

run 1 --program "$slow"
grep -q 'RED: conv2d/16-32@14/forward: more instructions' "$scratch/out.txt" || fail "the slow kernel is not named"
grep -q 'RED: sim' "$scratch/out.txt" && fail "what was not slowed down is red"
ratio=$(awk '$1 == "conv2d/16-32@14/forward" { print $4 }' "$scratch/out.txt")
awk -v ratio="$ratio" 'BEGIN { exit !(ratio > 1.05 && ratio < 1.15) }' || fail "the planted slow-down is $ratio, not 5 to 15%"

# test_gate.py tries workloads that took fewer instructions, that are gone and that are new.
sed -i 's/"GNU [0-9]*"/"GNU 99"/' "$limits"
run 2 --program "$program"
grep -q 'the limits are for GNU 99' "$scratch/err.txt" || fail "limits of another compiler are taken"
echo '{' >"$limits"
run 2 --program "$program"
run 2 --program "$program" --update
echo "gate_red: a planted slow-down of $ratio is red, the program as it is green"
