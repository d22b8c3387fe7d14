#!/usr/bin/env bash
# A page's layout in headless Chromium: nothing wider than a phone (375 px), half a screen (900 px) or a screen (1200 px), the answer on the first
# screen, names and headings for those who hear it, contrast by day and by night (WCAG 2.1: 4.5), and few sheets of paper.
#   layout_chromium.sh CHROMIUM REPORT_SAMPLE KIND SHEETS     a page that the program report_sample writes
#   layout_chromium.sh CHROMIUM PAGE.html NAME SHEETS         that page
set -euo pipefail
chromium=$1 here=$(dirname "$0") scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
if [[ $2 == *.html ]]; then cp "$2" "$scratch/page.html"; else "$2" "$scratch/page.html" "$3"; fi
browse() {
  timeout 120 "$chromium" --headless --no-sandbox --disable-gpu --disable-quic --no-first-run \
    --disable-background-networking --disable-component-update --disable-sync --disable-dev-shm-usage \
    --user-data-dir="$scratch/profile" --window-size=1300,900 --virtual-time-budget=10000 "$@" </dev/null 2>"$scratch/log"
}
# A browser's window is never as narrow as a phone, so the page stands in frames and tells what is wrong with it.
# Its policy would let no other script than its own run.
{ grep -v Content-Security-Policy "$scratch/page.html" && echo "<script>" && cat "$here/layout_checks.js" && echo "</script>"; } >"$scratch/checked.html"
{
  echo "<body>"
  for width in 375 900 1200; do echo "<iframe name='$width px' src='checked.html' style='width:${width}px;height:812px;border:0'></iframe>"; done
  echo "<script>
    addEventListener('message', said => {
      const frame = [...document.querySelectorAll('iframe')].find(one => one.contentWindow === said.source);
      document.body.dataset.found = (document.body.dataset.found ?? '') + frame.name + ': ' + said.data + '. ';
    });
  </script>"
} >"$scratch/frames.html"
for scheme in 1 0; do  # light, dark
  found=$(browse --blink-settings=preferredColorScheme=$scheme --dump-dom "file://$scratch/frames.html" | grep -o 'data-found="[^"]*"') ||
    { echo "$3: the page said nothing" >&2; exit 1; }
  for width in 375 900 1200; do
    [[ $found == *"$width px: none. "* ]] || { echo "$3, scheme $scheme: $found" >&2; exit 1; }
  done
done
browse --no-pdf-header-footer --print-to-pdf="$scratch/page.pdf" "file://$scratch/page.html"
sheets=$(grep -a -c '/Type /Page$' "$scratch/page.pdf")
((sheets > 0 && sheets <= $4)) || { echo "$3: $sheets sheets of paper, at most $4" >&2; exit 1; }
echo "layout_chromium: $3 is as it should be, $sheets sheets"
