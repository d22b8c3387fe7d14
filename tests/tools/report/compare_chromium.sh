#!/usr/bin/env bash
# Opens the page of decid compare in headless Chromium: is its chart drawn, without an error?
#   compare_chromium.sh CHROMIUM DECID
set -euo pipefail
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
# A network of trials of 16 s, whose fits take little time.
echo '{"name": "tiny", "sample_rate_hz": 20, "sequence": {"feedback": [0, 0, -1, 1], "start": [0, 0, 0, 1], "state_s": 0.1,
  "amplitude_deg": 4, "offset_s": 0, "cycles": 2}}' >"$scratch/tiny.json"
printf 'globalavgpool\nfc 7\n' >"$scratch/net.txt"
"$2" train --quiet --stream --stream-trials 40 --validation-trials 20 --epochs 1 --head point --protocol "$scratch/tiny.json" \
  --architecture "$scratch/net.txt" -o "$scratch/model.safetensors"
"$2" compare --quiet --model "$scratch/model.safetensors" --trials 2 --starts 1 --simulations 6500 --max-draws 8 --sensor-noise 0.1 \
  --report "$scratch/page.html"
"$(dirname "$0")/report_chromium.sh" "$1" "$scratch/page.html" compare 2
