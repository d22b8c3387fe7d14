#!/usr/bin/env bash
# Opens a report in headless Chromium: are all its charts drawn, without an error? With a number of SHEETS also its layout: nothing wider than a
# phone (375 px), half a screen (900 px) or a screen (1200 px), the answer on the first screen, names and headings for those who hear it, contrast
# by day and by night (WCAG 2.1: 4.5), and few sheets of paper.
#   report_chromium.sh CHROMIUM REPORT_SAMPLE [KIND [SHEETS]]            writes the page with the program report_sample
#   report_chromium.sh CHROMIUM PAGE.html [NAME SHEETS [OTHER.html...]]  checks that page, and the charts of the others
# FRAGMENT=recording-2 opens the page there; LEAST_CHARTS=20 asks for at least 20; KEEP_DOM=FILE keeps the page as it is when it has drawn
# itself; KEEP_SCREENSHOT=FILE.png also takes a picture.
set -euo pipefail
chromium=$1 source=$2 name=${3:-page} sheets=${4:-} here=$(dirname "$0") scratch=$(mktemp -d)
others=("${@:5}")
trap 'rm -rf "$scratch"' EXIT

page=$source
if [[ $source != *.html ]]; then
  page=$scratch/page.html
  "$source" "$page" "${@:3:1}"
fi
# The checks of the charts come behind a page, as a script that its policy allows.
checks=$(cat "$here/chart_checks.js")
hash=$(printf '%s' "$checks" | python3 -c "import base64, hashlib, sys; print(base64.b64encode(hashlib.sha256(sys.stdin.buffer.read()).digest()).decode())")
with_chart_checks() { sed "s|script-src |&'sha256-$hash' |" "$1" && printf '<script>%s</script>\n' "$checks"; }
with_chart_checks "$page" >"$scratch/charts.html"

browse() {
  timeout 120 "$chromium" --headless --no-sandbox --disable-gpu --disable-quic --no-first-run \
    --disable-background-networking --disable-component-update --disable-sync --disable-dev-shm-usage \
    --user-data-dir="$scratch/profile" --enable-logging=stderr --virtual-time-budget=10000 "$@" </dev/null
}
fail() {
  printf 'report_chromium: %s: %s\n' "$name" "$1" >&2
  grep -m 5 CONSOLE "$scratch/log" >&2 || true
  exit 1
}

# Charts and paper.
look=("--window-size=1200,2400" --hide-scrollbars)
address=file://$scratch/charts.html${FRAGMENT:+#$FRAGMENT}
print=()
if [[ -n $sheets ]]; then print=(--no-pdf-header-footer --print-to-pdf="$scratch/page.pdf"); fi
browse "${look[@]}" --dump-dom "${print[@]}" "$address" >"$scratch/dom.html" 2>"$scratch/log"
if [[ -n ${KEEP_DOM:-} ]]; then cp "$scratch/dom.html" "$KEEP_DOM"; fi
body=$(grep -o '<body[^>]*>' "$scratch/dom.html" | head -n 1 || true)
grep -q 'CONSOLE' "$scratch/log" && fail "the console is not empty; $body"
[[ $body == *data-error* ]] && fail "the script failed; $body"
[[ $body == *data-drawn=* && $body =~ data-charts=\"([0-9]+)/([0-9]+)\" ]] || fail "the script did not finish; $body"
drawn=${BASH_REMATCH[1]} all=${BASH_REMATCH[2]}
((all >= ${LEAST_CHARTS:-1} && drawn == all)) || fail "$drawn of $all charts are drawn; $body"
if [[ -n ${KEEP_SCREENSHOT:-} ]]; then browse "${look[@]}" --screenshot="$KEEP_SCREENSHOT" "$address" 2>"$scratch/log"; fi
echo "report_chromium: $all charts drawn, no error"
[[ -n $sheets ]] || exit 0
printed=$(grep -a -c '/Type /Page$' "$scratch/page.pdf")
((printed > 0 && printed <= sheets)) || fail "$printed sheets of paper, at most $sheets"

# A browser's window is never as narrow as a phone, so the page stands in frames and tells what is wrong with it. A frame's colour scheme is what
# the page in it takes for the system's. Its policy would let no other script than its own run.
{ grep -v Content-Security-Policy "$page" && echo "<script>" && cat "$here/layout_checks.js" && echo "</script>"; } >"$scratch/layout.html"
frames=()
frame() {  # name, file, scheme, width, height
  echo "<iframe name='$1' src='$2' style='color-scheme:$3;width:$4px;height:$5px;border:0'></iframe>"
  frames+=("$1")
}
{
  echo "<body>"
  for width in 375 900 1200; do frame "$width px, light" layout.html light $width 812; done
  for width in 375 1200; do frame "$width px, dark" layout.html dark $width 812; done
  for other in "${!others[@]}"; do
    with_chart_checks "${others[other]}" >"$scratch/other$other.html"
    frame "other page $other" "other$other.html" light 1200 2400
  done
  echo "<script>
    addEventListener('message', said => {
      const frame = [...document.querySelectorAll('iframe')].find(one => one.contentWindow === said.source);
      document.body.dataset.found = (document.body.dataset.found ?? '') + frame.name + ': ' + said.data + '. ';
    });
  </script>"
} >"$scratch/frames.html"
found=$(browse --window-size=1300,900 --dump-dom "file://$scratch/frames.html" 2>"$scratch/log" | grep -o 'data-found="[^"]*"') ||
  fail "the page said nothing"
for one in "${frames[@]}"; do [[ $found == *"$one: none. "* ]] || fail "$found"; done
grep -q 'CONSOLE' "$scratch/log" && fail "the console is not empty in frames"
echo "report_chromium: the layout is as it should be, $printed sheets; other pages: ${#others[@]}"
