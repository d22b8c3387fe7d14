#!/usr/bin/env bash
# Opens a page of decid fit --frf with two controllers in headless Chromium: are all charts drawn, without an error, and
# does the layout hold?
#   frf_chromium.sh CHROMIUM DECID TABLE
set -euo pipefail
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
"$2" fit --quiet --frf "$3" --protocol short --controller dec,ic --report "$scratch/page.html" >/dev/null
"$(dirname "$0")/report_chromium.sh" "$1" "$scratch/page.html"
"$(dirname "$0")/layout_chromium.sh" "$1" "$scratch/page.html" frf 5
