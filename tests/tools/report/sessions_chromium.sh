#!/usr/bin/env bash
# The page of two groups in two sessions in headless Chromium: per group, a table of reliability with all parameters and a table
# of each person's changes.
#   sessions_chromium.sh CHROMIUM REPORT_SAMPLE SHEETS
set -euo pipefail
here=$(dirname "$0") scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
KEEP_DOM=$scratch/dom.html "$here/report_chromium.sh" "$1" "$2" sessions "$3"
count() { grep -o "$1" "$scratch/dom.html" | wc -l; }
reliability=$(count '<table class="answer compared reliability">') changes=$(count '<table class="recordings changes">')
detectable=$(count '<td class="number" data-heading="MDC">') chance=$(count 'The [0-9]* intervals are not adjusted')
# The later session is the minuend.
later=$(count '<h3>Change: [^<]*, after minus [^<]*, before, each person</h3>')
own=$(count '<small>own [^<]* to [^<]*</small>')
echo "sessions_chromium: $own changes by a person's own recordings"
[[ $own -gt 0 && $((own % 7)) == 0 ]]
echo "sessions_chromium: $reliability tables of reliability with $detectable detectable changes, $changes of changes"
[[ $reliability == 2 && $detectable == 14 && $changes == 2 && $chance == 2 && $later == 2 ]]
