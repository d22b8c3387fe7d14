// What the pages of decid identify and decid fit share, after common.js: text about recordings, their contents.
const normalizedUnit = parameter => parameter.unit.includes(" s/") ? " s" : "";

// The same value in the unit a reader may think in.
function inOtherWords(parameter) {
  if (absent(parameter.value)) return null;
  if (parameter.unit === "rad/s") return fixed(parameter.value * 180 / Math.PI, 3) + " deg/s";
  return parameter.unit === "s" ? fixed(1000 * parameter.value, 0) + " ms" : null;
}

// Whether the answer can be used, and everything that was noticed, the gravest first.
function trustBox({ trust, warnings }) {
  const verdict = { usable: "Usable: no check found anything odd", caution: "Use with caution", "not usable": "Not usable" }[trust];
  return element("div", { class: trust === "usable" ? "verdict" : "warning", role: "note", "aria-label": "Can it be used?" },
    element("strong", {}, verdict),
    warnings.length === 0 ? null : element("ul", {}, ...warnings.map(({ text, severity }) => element("li", {}, (severity === "info" ? "Note: " : "") + text))));
}

const describeTilt = tilt => absent(tilt) ? "" : ` By the tilt measured (\u201c${tilt.column}\u201d) the protocol starts ` +
  `${fixed(tilt.delay_s, 3)} s after the recording (correlation ${fixed(tilt.correlation, 3)}, gain ${fixed(tilt.gain, 3)}).`;


// what: "Not identified".
function failures(what) {
  if (report.failed.length === 0) return;
  document.getElementById("main").append(element("div", { class: "warning", role: "note", "aria-label": what },
    element("strong", {}, what), element("ul", {}, ...report.failed.map(text => element("li", {}, text)))));
}

// valueCell: of a parameter; last: the last column's heading and, for a recording, what is in it.
function contents(valueCell, [heading, last]) {
  const recordings = report.recordings;
  if (recordings.length < 2) return;
  const rows = recordings.map((recording, index) => element("tr", {},
    element("th", { scope: "row", class: "file" }, element("a", { href: `#recording-${index + 1}` }, recording.file),
      recording.trust === "usable" ? null : element("span", { class: "description" }, recording.trust === "caution" ? "with caution" : "not usable")),
    ...recording.parameters.map(parameter => element("td", { class: "number" }, valueCell(parameter))),
    element("td", { class: "number" }, last(recording))));
  const nav = document.getElementById("contents");
  nav.append(element("h2", {}, `${recordings.length} recordings`), element("div", { class: "scroll" }, element("table", {},
    element("thead", {}, element("tr", {}, element("th", { scope: "col" }, "Recording"),
      ...recordings[0].parameters.map(parameter => element("th", { scope: "col", class: "number" }, parameter.name,
        element("span", { class: "description" }, unitOf(parameter)))),
      element("th", { scope: "col", class: "number" }, heading))),
    element("tbody", {}, ...rows))));
  nav.hidden = false;
}

