#!/usr/bin/env bash
# The pages of decid fit in headless Chromium: the comparison of controllers and the page of a frequency response show angles in degrees and times in ms; a fixed parameter is shown as fixed.
#   units_chromium.sh CHROMIUM REPORT_SAMPLE DECID TABLE
set -euo pipefail
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
"$2" "$scratch/fit.html" fit
"$3" fit --quiet --frf "$4" --protocol short --report "$scratch/frf.html" >/dev/null
shown() {
  timeout 120 "$1" --headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-dev-shm-usage \
    --user-data-dir="$scratch/profile" --virtual-time-budget=10000 --dump-dom "file://$2" </dev/null 2>"$scratch/log"
}
# The page has the value of a fixed parameter, and neither a standard deviation nor an interval.
"$3" simulate --quiet --protocol short -o "$scratch/trial.csv"
"$3" fit --quiet --protocol short --max-draws 8 --fix Kp=578 --report "$scratch/fixed.html" "$scratch/trial.csv" >/dev/null
fixed=$(shown "$1" "$scratch/fixed.html")
[[ $fixed == *"578, fixed"* && $fixed != *578.000000* ]] || { echo "a fixed parameter is not shown as fixed" >&2; exit 1; }
check() {
  for unit in 'theta, °/s' 'delay, ms' 'Kp, N m/rad'; do
    [[ $2 == *"$unit"* ]] || { echo "$1: no parameter is shown as '$unit'" >&2; exit 1; }
  done
}
# Behind the first table of parameters, which has other code.
fit=$(shown "$1" "$scratch/fit.html")
check "the comparison of controllers" "${fit#*class=\"controllers\"}"
frf=$(shown "$1" "$scratch/frf.html") main='<main'
check "the page of a frequency response" "$frf"
frf=${frf#*"$main"}
[[ ${frf%%<svg*} == *'Can it be used?'* ]] || { echo "the page of a frequency response does not begin with its verdict" >&2; exit 1; }
