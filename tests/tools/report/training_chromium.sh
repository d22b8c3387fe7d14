#!/usr/bin/env bash
# Opens the pages of decid train in headless Chromium: are all charts drawn, without an error, and does the layout hold?
#   training_chromium.sh CHROMIUM DECID
set -euo pipefail
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
for options in "--preset small --epochs 3" "--preset series --epochs 1"; do
  # shellcheck disable=SC2086
  "$2" train --quiet --threads 1 --stream --stream-trials 64 --validation-trials 16 --protocol short $options \
    --report "$scratch/page.html" -o "$scratch/${options// /}"
  "$(dirname "$0")/report_chromium.sh" "$1" "$scratch/page.html"
done
"$(dirname "$0")/layout_chromium.sh" "$1" "$scratch/page.html" training 2
