// What the pages of decid identify and decid fit draw of parameters that are known within limits, after common.js and
// recordings.js: SVG in the colours of density.css.

// ---- drawing -------------------------------------------------------------------------------------------------------

function shape(tag, attributes = {}, ...children) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children.filter(child => child !== null));
  return made;
}

const short = value => Number(value.toFixed(1));
const label = (x, y, text, kind = "") => shape("text", { x: short(x), y: short(y), class: kind }, text);
const line = (x1, y1, x2, y2, kind) => shape("line", { x1: short(x1), y1: short(y1), x2: short(x2), y2: short(y2), class: kind });
const pathOf = points => points.map(([x, y], i) => `${i ? "L" : "M"}${short(x)} ${short(y)}`).join("");
const path = (points, kind) => shape("path", { d: pathOf(points), class: kind });

// An SVG of that many units; what is drawn must be there, and be numbers.
function drawing(width, height, text, children) {
  const made = shape("svg", { viewBox: `0 0 ${short(width)} ${short(height)}`, role: "img", "aria-label": text }, ...children);
  return made;
}
function checked(made) {
  checks.push(() => made.querySelector("path, rect, circle") !== null && !/NaN|Infinity|undefined/.test(made.innerHTML));
  return made;
}

// Round numbers between two limits, about as many as wanted.
function ticks(low, high, wanted) {
  const rough = (high - low) / wanted, power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find(factor => factor * power >= rough * 0.999);
  const first = Math.ceil(low / step - 1e-9), count = Math.floor(high / step + 1e-9) - first + 1;
  return Array.from({ length: Math.max(0, count) }, (_, i) => Number(((first + i) * step).toPrecision(12)));
}

// ---- densities -----------------------------------------------------------------------------------------------------

// Decimals that resolve the range and the deviation.
const finestOf = parameter => Math.min(12, Math.max(decimalsOf(parameter), Math.floor(1.5 - Math.log10(parameter.sd))));
const between = ([low, high], decimals) => `${fixed(low, decimals)} to ${fixed(high, decimals)}`;

// Where a parameter's value is in its range: 0 to 1.
const placeIn = (parameter, value) => (value - parameter.low) / (parameter.high - parameter.low);

// density: [place in the range, density], the prior being 1.
function densityPanel(parameter, density) {
  const width = 320, height = 145, left = 18, right = width - 18, top = 6, base = 98, bar = 112;
  const highest = Math.max(1, ...density.map(([, value]) => value));
  const x = place => left + (right - left) * Math.min(1, Math.max(0, place)), y = value => base - (base - top) * value / highest;
  const of = value => x(placeIn(parameter, value));
  const { interval50, interval90, mean } = parameter, decimals = finestOf(parameter);
  const curve = density.map(([place, value]) => [x(place), y(value)]);
  const children = [
    path([[left, base], ...curve, [right, base]], "soft"), path(curve, "draw"),
    line(left, y(1), right, y(1), "prior"), line(left, base, right, base, "frame"),
    line(of(interval90[0]), bar, of(interval90[1]), bar, "ninety"), line(of(interval50[0]), bar, of(interval50[1]), bar, "fifty"),
    "true" in parameter ? line(of(parameter.true), top, of(parameter.true), bar + 8, "truth") : null,
    shape("circle", { cx: short(of(mean)), cy: bar, r: 5, class: "mean" }),
    ...ticks(parameter.low, parameter.high, 5).flatMap(value =>
      [line(of(value), base, of(value), base + 4, "frame"), label(of(value), 138, compact(value), "middle")]),
  ];
  const made = checked(drawing(width, height, `Density of ${parameter.name}: mean ${fixed(mean, decimals)}, 90 % interval ` +
    `${between(interval90, decimals)}, range ${between([parameter.low, parameter.high], decimals)} ${unitOf(parameter)}`, children));
  return element("div", {}, element("h4", {}, parameter.name, " ", element("small", {}, unitOf(parameter))), made);
}

// A panel of each parameter. whose: what density it is; remark: what the caption ends with.
function densityFigure(title, parameters, densities, whose, remark) {
  const known = parameters.some(parameter => "true" in parameter);
  return element("figure", {}, element("h3", {}, title),
    element("div", { class: "densities" }, ...parameters.map((parameter, p) => densityPanel(parameter, densities[p]))),
    element("figcaption", {}, `Density ${whose} over the range that was possible before the recording was seen; dashed: the density ` +
      "before. Below it the mean (ring) and the intervals of 50 % (thick) and 90 % (thin)" +
      (known ? "; the upright red line is the true value." : ".") + " A density as flat as the dashed line says that the recording " +
      "tells nothing of this parameter." + remark));
}
