#!/usr/bin/env bash
# Opens the page of decid compare in headless Chromium: is its chart drawn, without an error?
#   compare_chromium.sh CHROMIUM DECID
set -euo pipefail
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
"$2" compare --quiet --trials 2 --starts 1 --simulations 6500 --max-draws 8 --sensor-noise 0.1 --report "$scratch/page.html"
"$(dirname "$0")/report_chromium.sh" "$1" "$scratch/page.html"
"$(dirname "$0")/layout_chromium.sh" "$1" "$scratch/page.html" compare 2
