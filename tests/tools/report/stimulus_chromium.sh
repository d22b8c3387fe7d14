#!/usr/bin/env bash
# Opens the pages of decid stimulus in headless Chromium: are all charts drawn, without an error, and does the layout hold?
#   stimulus_chromium.sh CHROMIUM DECID PROTOCOLS
set -euo pipefail
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
pages=()
for protocol in "$3"/raised_cosines.json default short "$3"/measured.json "$3"/sines.json; do
  pages+=("$scratch/${#pages[@]}.html")
  "$2" stimulus --quiet --protocol "$protocol" --plot "${pages[-1]}"
done
"$(dirname "$0")/report_chromium.sh" "$1" "${pages[0]}" stimulus 2 "${pages[@]:1}"
