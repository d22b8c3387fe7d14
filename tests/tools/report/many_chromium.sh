#!/usr/bin/env bash
# The page of many recordings in headless Chromium: closed, it draws the group alone; a recording is drawn where it is opened.
#   many_chromium.sh CHROMIUM REPORT_SAMPLE
set -euo pipefail
here=$(dirname "$0") scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
"$2" "$scratch/page.html" many
closed=$("$here/report_chromium.sh" "$1" "$scratch/page.html" many 6)
opened=$(FRAGMENT=recording-17 LEAST_CHARTS=15 "$here/report_chromium.sh" "$1" "$scratch/page.html")
echo "closed: $closed; opened: $opened"
[[ $closed == *": 7 charts drawn"* ]]  # one a parameter
