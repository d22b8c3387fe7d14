#!/usr/bin/env bash
# The page of recordings of which one is not analysed in headless Chromium: it counts them as the text does.
#   counts_chromium.sh CHROMIUM REPORT_SAMPLE
set -euo pipefail
here=$(dirname "$0") scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
KEEP_DOM=$scratch/dom.html "$here/report_chromium.sh" "$1" "$2" several
grep -o '<h2>[0-9]* recordings</h2><p class="about">[^<]*</p>' "$scratch/dom.html" | tee "$scratch/counts"
[[ $(<"$scratch/counts") == '<h2>4 recordings</h2>'*', 1 not analysed.</p>' ]]
