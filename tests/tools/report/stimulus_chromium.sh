#!/usr/bin/env bash
# Opens the pages of decid stimulus in headless Chromium: are all charts drawn, without an error, and does the layout hold?
#   stimulus_chromium.sh CHROMIUM DECID PROTOCOLS
set -euo pipefail
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
for protocol in default short "$3"/measured.json "$3"/sines.json "$3"/raised_cosines.json; do
  "$2" stimulus --quiet --protocol "$protocol" --plot "$scratch/page.html"
  "$(dirname "$0")/report_chromium.sh" "$1" "$scratch/page.html"
done
"$(dirname "$0")/layout_chromium.sh" "$1" "$scratch/page.html" stimulus 2
