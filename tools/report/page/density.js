// Draws parameters that are known within limits, for the pages of decid identify and decid fit. Load it after common.js,
// plot.js and recordings.js.

// ---- densities -----------------------------------------------------------------------------------------------------

// Returns the place of a parameter's value in its range: 0 to 1.
const placeIn = (parameter, value) => (value - parameter.low) / (parameter.high - parameter.low);

// Draws a density: [place in the range, density], with the prior at 1.
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
  const made = drawing(width, height, `Density of ${parameter.description}: mean ${fixed(mean, decimals)}, 90% interval ` +
    `${between(interval90, decimals)}, limits ${between([parameter.low, parameter.high], decimals)} ${unitOf(parameter)}`, children);
  return element("div", {}, element("h4", {}, parameter.description, " ", element("small", {}, symbolAndUnit(parameter))), made);
}

// Draws a panel for each parameter. remark: the end of the caption.
function densityFigure(title, parameters, densities, remark) {
  const known = parameters.some(parameter => "true" in parameter);
  return element("figure", {}, element("h3", {}, title),
    element("div", { class: "densities" }, ...parameters.map((parameter, p) => densityPanel(parameter, densities[p]))),
    element("figcaption", {}, "Curve: probability density after the recording; dashed: before the recording. Below: mean (ring), 50% interval (thick) and 90% interval (thin)." +
      (known ? " Red line: true value." : "") + " A curve as flat as the dashed line: the recording does not determine this parameter." + remark));
}

// ---- correlations --------------------------------------------------------------------------------------------------

function correlationTable({ parameters, correlations }) {
  const cell = value => {
    const made = element("td", {}, fixed(value, 2));
    made.style.background = `rgb(23 82 127 / ${(0.5 * Math.abs(value)).toFixed(2)})`;
    return made;
  };
  return element("div", { class: "scroll" }, element("table", { class: "correlations" },
    element("caption", {}, "Correlations of the errors. Near 1 or \u22121, one parameter can replace the other: the recording determines their " +
      "combination better than either."),
    element("thead", {}, element("tr", {}, element("th", { scope: "col" }, ""),
      ...parameters.slice(0, -1).map(({ name }) => element("th", { scope: "col", class: "number" }, name)))),
    element("tbody", {}, ...parameters.slice(1).map(({ name }, row) => element("tr", {},
      element("th", { scope: "row" }, name), ...correlations[row + 1].map(cell))))));
}
