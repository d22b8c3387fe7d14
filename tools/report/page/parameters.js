// Functions for verdicts and tables of parameters, which the pages of decid identify, fit and fit --frf share, after common.js.

// Pages show these units instead of SI: [unit, its number per SI unit].
const shownUnits = { "rad/s": ["\u00b0/s", 180 / Math.PI], s: ["ms", 1000] };

// Converts a parameter's values in place, once; factor: the shown value over the value in SI.
function inShownUnit(parameter) {
  const [unit, factor] = shownUnits[parameter.unit] ?? [parameter.unit, 1], converted = value => absent(value) ? value : factor * value;
  for (const key of ["value", "true", "mean", "sd", "low", "high"].filter(key => key in parameter)) parameter[key] = converted(parameter[key]);
  for (const key of ["interval50", "interval90", "range"].filter(key => key in parameter)) parameter[key] = parameter[key].map(converted);
  return Object.assign(parameter, { unit, factor });
}

const verdicts = {
  usable: what => `Usable: ${what} passed all checks`, caution: () => "Caution: read these warnings before you use the values",
  "not usable": () => "Not usable: do not use these values",
};

// Shows if the answer can be used, and the warnings, the most serious first. what: the input, "recording".
function trustBox({ trust, warnings }, what = "recording", label = "") {
  const serious = warnings.filter(({ severity }) => severity !== "info");
  return element("div", { class: trust === "usable" ? "verdict" : "warning", role: "note", "aria-label": label + "Can it be used?" },
    element("strong", {}, label + verdicts[trust](what)),
    serious.length === 0 ? null : element("ul", {}, ...serious.map(({ text }) => element("li", {}, text))));
}

const symbolAndUnit = parameter => parameter.name + (unitOf(parameter) ? ", " + unitOf(parameter) : "");
const normalizedUnit = parameter => parameter.unit.includes(" s/") ? " s" : "";

// Returns a heading of a column, with what it means below in small print.
const columnHead = (text, small, kind = "number") => element("th", { scope: "col", class: kind }, text, small ? element("span", { class: "description" }, small) : null);

// Returns a cell of the results table. heading: the text before the value where the table is too narrow for columns.
const cell = (heading, text) => element("td", { class: text === "\u2013" ? "number none" : "number", "data-heading": heading }, text);
const nameCell = parameter => element("th", { scope: "row" }, parameter.description, element("span", { class: "description" }, symbolAndUnit(parameter)));

// An end that would round to 0 has two significant digits: its sign says on which side of 0 the interval ends.
const endOf = (value, decimals) => absent(value) || value === 0 || Number(value.toFixed(decimals)) !== 0 ? fixed(value, decimals)
  : fixed(value, Math.min(12, 1 - Math.floor(Math.log10(Math.abs(value)))));
const between = ([low, high], decimals) => `${endOf(low, decimals)} to ${endOf(high, decimals)}`;
// --fix, or a controller by convention, gives these parameters one value.
const isFixed = parameter => parameter.fixed === true || parameter.sd === 0;
const digitsOf = parameter => Math.min(12, decimalsOf(parameter));
// Returns decimals that resolve the limits and, if it is known, the standard deviation.
const finestOf = parameter => "sd" in parameter && !isFixed(parameter) ? Math.min(12, Math.max(decimalsOf(parameter), Math.floor(1.5 - Math.log10(parameter.sd)))) : digitsOf(parameter);
const valueOf = (parameter, value = parameter.value) => isFixed(parameter) ? `${compactFixed(value)}, fixed`
  : fixed(value, finestOf(parameter)) + ("sd" in parameter ? ` \u00b1 ${fixed(parameter.sd, finestOf(parameter))}` : "");
// Returns a value as a user gave it: up to six digits, without zeros at its end.
const compactFixed = value => absent(value) ? "n/a" : minus(String(Number(value.toPrecision(6))));
const intervalOf = parameter => isFixed(parameter) ? "\u2013" : between(parameter.interval90, finestOf(parameter));

// Returns a bar from the lower to the upper limit, with the value, its 90% interval and the true value.
function rangeCell(parameter, value) {
  const place = value => Math.min(100, Math.max(0, 100 * (value - parameter.low) / (parameter.high - parameter.low)));
  const bar = element("div", { class: "bar", "aria-hidden": "true" }), decimals = digitsOf(parameter);
  const add = (kind, from, width) => {
    const made = element("span", { class: kind });
    Object.assign(made.style, { left: from + "%" }, width === undefined ? {} : { width: width + "%" });
    bar.append(made);
  };
  if ("interval90" in parameter && !isFixed(parameter)) {
    const [from, to] = parameter.interval90.map(place);
    add("interval", from, to - from);
  }
  if ("true" in parameter) add("truth-mark", place(parameter.true));
  if (!absent(value)) add(parameter.beyond ? "value-mark outside" : "value-mark", place(value));
  return element("td", { class: "range" }, bar,
    element("div", { class: "limits" }, element("span", {}, fixed(parameter.low, decimals)),
      parameter.beyond && !absent(value) ? element("strong", {}, "outside") : null,
      element("span", {}, fixed(parameter.high, decimals))));
}
