#!/usr/bin/env bash
# Opens a page of decid fit --frf with two controllers in headless Chromium: are all charts drawn, without an error, does the layout hold, does
# it begin with its verdict, and does it show angles in degrees and times in ms?
#   frf_chromium.sh CHROMIUM DECID TABLE
set -euo pipefail
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
"$2" fit --quiet --frf "$3" --protocol short --controller dec,ic --report "$scratch/page.html" >/dev/null
KEEP_DOM=$scratch/shown.html "$(dirname "$0")/report_chromium.sh" "$1" "$scratch/page.html" frf 5
shown=$(cat "$scratch/shown.html") main='<main'
for unit in 'theta, °/s' 'delay, ms' 'Kp, N m/rad'; do
  [[ $shown == *"$unit"* ]] || { echo "no parameter is shown as '$unit'" >&2; exit 1; }
done
shown=${shown#*"$main"}
[[ ${shown%%<svg*} == *'Can it be used?'* ]] || { echo "the page does not begin with its verdict" >&2; exit 1; }
