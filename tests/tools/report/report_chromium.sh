#!/usr/bin/env bash
# Opens a report in headless Chromium: are all its charts drawn, without an error?
#   report_chromium.sh CHROMIUM REPORT_SAMPLE [KIND]  writes the page with the program report_sample
#   report_chromium.sh CHROMIUM PAGE.html             checks that page
# FRAGMENT=recording-2 opens the page there; LEAST_CHARTS=20 asks for at least 20; KEEP_SCREENSHOT=FILE.png also takes a picture.
set -euo pipefail
chromium=$1 source=$2 scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

page=$source
if [[ $source != *.html ]]; then
  page=$scratch/page.html
  "$source" "$page" "${@:3}"
fi
# The checks of the charts come behind the page, as a script that its policy allows.
checks=$(cat "$(dirname "$0")/chart_checks.js")
hash=$(printf '%s' "$checks" | python3 -c "import base64, hashlib, sys; print(base64.b64encode(hashlib.sha256(sys.stdin.buffer.read()).digest()).decode())")
{ sed "s|script-src |&'sha256-$hash' |" "$page" && printf '<script>%s</script>\n' "$checks"; } >"$scratch/checked.html"
page=$scratch/checked.html

browse() {
  timeout 120 "$chromium" --headless --no-sandbox --disable-gpu --disable-quic --no-first-run \
    --disable-background-networking --disable-component-update --disable-sync --disable-dev-shm-usage \
    --user-data-dir="$scratch/profile" --window-size=1200,2400 --hide-scrollbars \
    --enable-logging=stderr --virtual-time-budget=10000 "$@" "file://$page${FRAGMENT:+#$FRAGMENT}" </dev/null
}

browse --dump-dom >"$scratch/dom.html" 2>"$scratch/log"
body=$(grep -o '<body[^>]*>' "$scratch/dom.html" | head -n 1 || true)
fail() {
  printf 'report_chromium: %s\nbody: %s\n' "$1" "$body" >&2
  grep -m 5 CONSOLE "$scratch/log" >&2 || true
  exit 1
}
grep -q 'CONSOLE' "$scratch/log" && fail "the console is not empty"
[[ $body == *data-error* ]] && fail "the script failed"
[[ $body == *data-drawn=* && $body =~ data-charts=\"([0-9]+)/([0-9]+)\" ]] || fail "the script did not finish"
drawn=${BASH_REMATCH[1]} all=${BASH_REMATCH[2]}
((all >= ${LEAST_CHARTS:-1} && drawn == all)) || fail "$drawn of $all charts are drawn"
if [[ -n ${KEEP_SCREENSHOT:-} ]]; then browse --screenshot="$KEEP_SCREENSHOT" 2>"$scratch/log"; fi
echo "report_chromium: $all charts drawn, no error"
