// What the pages of decid share: text, figures, and checks of what was drawn. Stands before each page's own script.
// When all is drawn, the body says so: data-charts-drawn="drawn/all", data-error if anything was thrown.
"use strict";
const page = (() => {
const blame = message => { document.body.dataset.error = String(message); };
window.addEventListener("error", event => blame(event.message));
window.addEventListener("unhandledrejection", event => blame(event.reason));

const checks = [];   // a function each canvas: does it show what it should?
const finish = () => {
  document.body.dataset.chartsDrawn = `${checks.filter(check => check()).length}/${checks.length}`;
};
const data = id => JSON.parse(document.getElementById(id).textContent);

function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children.filter(child => child !== null));
  return made;
}

const absent = value => value === null || value === undefined;
const minus = text => text.replace("-", "\u2212");
const fixed = (value, decimals) => absent(value) ? "n/a" : minus(value.toFixed(decimals));
const compact = value => absent(value) ? "n/a" : minus(String(Number(value.toPrecision(3))));

function figure(name, value, remark) {
  return element("div", {}, element("dt", {}, name), element("dd", {}, value, element("small", {}, remark)));
}

const rgb = hex => [1, 3, 5].map(at => parseInt(hex.slice(at, at + 2), 16));

// A copy is read: reading a canvas on the screen makes it slow, and browsers complain.
function pixelsOf(canvas) {
  const copy = element("canvas", { width: canvas.width, height: canvas.height }).getContext("2d", { willReadFrequently: true });
  copy.drawImage(canvas, 0, 0);
  return copy;
}

function hasColour(canvas, hex) {
  const wanted = rgb(hex);
  const { data } = pixelsOf(canvas).getImageData(0, 0, canvas.width, canvas.height);
  for (let at = 0; at < data.length; at += 4) {
    if (data[at + 3] > 128 && wanted.every((value, channel) => Math.abs(value - data[at + channel]) < 40)) return true;
  }
  return false;
}

const axis = text => ({ type: "linear", title: { display: true, text, color: "#1c2733" },
  ticks: { color: "#3d4853", includeBounds: false }, grid: { color: "#e6eaee" } });

return { element, absent, minus, fixed, compact, figure, rgb, pixelsOf, hasColour, axis, checks, finish, data };
})();
