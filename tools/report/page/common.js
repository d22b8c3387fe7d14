// Functions that every page shares: its data, text and elements. Text enters only through textContent, never as markup. The
// body's attributes report the state: data-drawn="number of charts" when all is drawn, and data-error with an exception's
// text.
"use strict";
// In another page's frame (bindings/web/page), the report also sends its state to that page, and prints on request.
const framed = window.parent !== window;
const tell = text => { if (framed) window.parent.postMessage(text, "*"); };
if (framed) window.addEventListener("message", event => { if (event.data === "print") window.print(); });
const blame = message => { tell(document.body.dataset.error = String(message)); };
window.addEventListener("error", event => blame(event.message));
window.addEventListener("unhandledrejection", event => blame(event.reason));

const report = JSON.parse(document.getElementById("report-data").textContent);

// ---- text ----------------------------------------------------------------------------------------------------------

function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children.filter(child => child !== null));
  return made;
}

const absent = value => value === null || value === undefined;
const minus = text => text.replace("-", "\u2212");
const fixed = (value, decimals) => absent(value) ? "n/a" : minus(value.toFixed(decimals).replace(/^-(0\.?0*)$/, "$1"));  // no minus before 0
const compact = value => absent(value) ? "n/a" : minus(String(Number(value.toPrecision(3))));
const percent = value => absent(value) ? "n/a" : fixed(100 * value, 0) + "%";
// Units as they follow a figure. Degrees have no blank before their sign: inDegrees.
const unitOf = ({ unit }) => unit === "1" ? "" : unit.replace("deg", "\u00b0");
const inDegrees = (value, decimals) => absent(value) ? "n/a" : fixed(value, decimals) + "\u00b0";

// Decimals that resolve a thousandth of the range.
const decimalsOf = parameter => Math.max(0, Math.floor(3 - Math.log10(parameter.high - parameter.low)));

function figure(name, value, remark) {
  return element("div", {}, element("dt", {}, name), element("dd", {}, value, element("small", {}, remark)));
}

function describeProtocol({ name, duration_s, amplitude_deg, cycles, cycle_s, sample_rate_hz }) {
  return `Protocol \u201c${name}\u201d: ${compact(duration_s)} s, platform tilt ${compact(amplitude_deg)}\u00b0 peak to ` +
    `peak, ${cycles} cycle${cycles === 1 ? "" : "s"} of ${compact(cycle_s)} s, sampled at ${compact(sample_rate_hz)} Hz.`;
}

// The call that made the report, and its inputs. again: how to repeat it.
function callTexts(call, again = "decid rerun computes its JSON again.") {
  const rows = call.inputs.map(({ file, sha256 }) => element("li", {}, file, " ", element("code", {}, sha256 ?? "no hash")));
  return [element("p", {}, "Command: ", element("code", {}, call.command), `; protocol \u201c${call.protocol}\u201d. `, again),
    element("details", {}, element("summary", {}, "SHA-256 of the inputs"), element("ul", {}, ...rows))];
}

// Call it when the page is complete.
function finish() {
  redraw();
  tell(document.body.dataset.drawn = document.querySelectorAll("[role=img], img").length);
}
