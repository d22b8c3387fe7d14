// The section of several fitted controllers, after common.js, plot.js, recordings.js, density.js and responses.js: predictions, parameters, responses,
// what each cannot explain.
const controllersSection = (() => {
const heading = (text, kind = "number") => element("th", { scope: "col", class: kind }, text);
const number = text => element("td", { class: "number" }, text);

function predictions(controllers) {
  const difference = one => one.difference === 0 ? "best" : `${fixed(one.difference, 1)} \u00b1 ${fixed(one.standard_error, 1)}`;
  return element("div", { class: "scroll" }, element("table", {},
    element("thead", {}, element("tr", {}, heading("Controller", ""), heading("Log predictive density"), heading("Difference \u00b1 1 SE"), heading("Weight"),
      heading("Cannot explain", ""))),
    element("tbody", {}, ...controllers.map(one => element("tr", {},
      element("th", { scope: "row" }, one.name, element("span", { class: "description" }, one.description)),
      number(fixed(one.log_density, 1)), number(one.comparable ? difference(one) : `${difference(one)}, not comparable`), number(fixed(one.weight, 2)),
      element("td", {}, one.odd.length === 0 ? "nothing found" : one.odd.join(", ")))))));
}

// A row per parameter that any controller has.
function parameters(controllers) {
  const names = [...new Set(controllers.flatMap(one => one.parameters.map(({ name }) => name)))];
  const cellOf = (one, name) => {
    const parameter = one.parameters.find(other => other.name === name);
    if (!parameter) return number("\u2013");
    const text = parameter.low === parameter.high ? `${compact(parameter.mean)}, fixed` : `${compact(parameter.mean)} (${compact(parameter.low)} to ${compact(parameter.high)})`;
    return number(text);
  };
  const about = name => controllers.flatMap(one => one.parameters).find(parameter => parameter.name === name);
  return element("div", { class: "scroll" }, element("table", {},
    element("thead", {}, element("tr", {}, columnHead("Parameter", "estimate (90% interval)", ""), ...controllers.map(one => heading(one.name)))),
    element("tbody", {}, ...names.map(name => element("tr", {},
      nameCell(about(name)), ...controllers.map(one => cellOf(one, name)))))));
}

// Lists the warnings of the controllers after the first, whose are the recording's.
function warningsOf(controllers) {
  const serious = controllers.flatMap(one => one.warnings.filter(({ severity }) => severity !== "info").map(({ text }) => `${one.name}: ${text}`));
  const title = `Warnings of ${controllers.slice(1).map(({ name }) => name).join(" and ")} (those of ${controllers[0].name} are at the top)`;
  return serious.length === 0 ? null : element("div", { class: "warning", role: "note", "aria-label": title },
    element("strong", {}, title), element("ul", {}, ...serious.map(text => element("li", {}, text))));
}

// ---- correlations --------------------------------------------------------------------------------------------------

// Returns the combination of two correlated parameters of one unit that the recording determines best: "Kp + 0.93 Kp_pass = 977 \u00b1 12 N m/rad".
function combination(a, b, correlation) {
  const factor = -correlation * a.sd / b.sd, sd = a.sd * Math.sqrt(Math.max(0, 1 - correlation ** 2));
  return `: ${a.name} ${factor < 0 ? "\u2212" : "+"} ${compact(Math.abs(factor))} ${b.name} = ${compact(a.mean + factor * b.mean)} \u00b1 ${compact(sd)} ${unitOf(a)}, ` +
    `where ${a.name} alone is \u00b1 ${compact(a.sd)}`;
}

function strongest({ parameters, correlations }) {
  const strong = 0.7, most = 4;
  const pairs = correlations.flatMap((row, p) => row.map((value, q) => [value, parameters[q], parameters[p]]));
  return pairs.filter(([value]) => Math.abs(value) >= strong).sort(([x], [y]) => Math.abs(y) - Math.abs(x)).slice(0, most)
    .map(([value, a, b]) => `${a.name} and ${b.name} ${fixed(value, 2)}` + (a.unit && a.unit === b.unit ? combination(a, b, value) : ""));
}

// Says which parameters can replace each other in each controller.
function dependences(controllers) {
  return element("div", {}, element("h3", {}, "Which parameters of each controller depend on each other"),
    element("p", { class: "note" }, "Correlations of at least 0.7, the strongest four. With such a correlation one parameter can replace the other: the recording " +
      "determines their combination better than either."),
    element("ul", { class: "plain" }, ...controllers.map(one => [one.name, strongest(one)]).map(([name, pairs]) =>
      element("li", {}, element("strong", {}, name), ": " + (pairs.length === 0 ? "none." : pairs.join("; ") + ".")))),
    ...controllers.slice(1).map(one => element("details", { class: "help" }, element("summary", {}, `All correlations of ${one.name}`), correlationTable(one))));
}

// ---- responses and sway --------------------------------------------------------------------------------------------

// Says at how many frequencies the recorded response is outside of a controller's band.
function outside({ name, frf }) {
  const count = (values, intervals) => values.filter((value, i) => value < intervals[i][0] || value > intervals[i][1]).length;
  return `${name}: gain at ${count(frf.gain, frf.model_gain_interval90)} and phase at ${count(frf.phase_deg, frf.model_phase_interval90)} of ${frf.gain.length} frequencies`;
}

function responses(controllers) {
  const shown = controllers.filter(({ frf }) => !absent(frf));
  return shown.length === 0 ? null : responsesFigure(shown.map(one => ({ controller: one.name, frf: one.frf })), ["90% of simulated trials", "Their median"],
    "Sway over platform tilt at the frequencies of the stimulus. The bands are of trials that decid simulates from the posterior, with the controller\u2019s tilt-speed " +
    "threshold as it is and new noise, and measures like the recording. By chance about one frequency in ten is outside of a band; where more are, the controller does not " +
    `explain the response. Outside: ${shown.map(outside).join("; ")}.`);
}

// Recorded sway over the band of each controller's simulated trials.
function bands(controllers, sway) {
  const points = (signal, values, others) => values.map((value, i) =>
    [signal.first_s + i * signal.step_s, value / signal.per_degree, ...(others ? [others[i] / signal.per_degree] : [])]);
  const charts = controllers.filter(one => one.sway.again_low).map(one => {
    const recorded = points(sway, sway.recorded), title = `Sway that ${one.name} predicts`;
    const { made, draw } = plot({ title, x: { text: "Time (s)", low: 0, high: recorded[recorded.length - 1][0] }, y: { text: "Sway (\u00b0)" }, height: 200,
      marks: [{ name: `${one.name}: 90% of simulated trials`, class: "again-soft", band: points(one.sway, one.sway.again_low, one.sway.again_high) },
        { name: "Recorded", class: "recorded", line: recorded }] });
    draw(0, recorded[recorded.length - 1][0]);
    return element("div", { class: "timeline" }, element("h4", {}, title), made);
  });
  return charts.length === 0 ? null : element("div", {}, element("h3", {}, "Recorded sway and each controller\u2019s"), ...charts);
}

return recording => {
  const { controllers } = recording;
  if (controllers.length === 0) return null;
  for (const { parameters } of controllers) parameters.forEach(inShownUnit);
  return element("section", { class: "controllers", "aria-label": "Which controller?" }, element("h3", {}, "Which controller?"),
    element("p", { class: "note" }, "Each controller predicts every part of the recording from the rest. A larger log predictive density is better; a difference below " +
      "two standard errors decides nothing, nor does a fit whose chains do not agree (not comparable). The weights are those of the mixture that predicts best. \u201cCannot explain\u201d lists checks with p below 0.01."),
    predictions(controllers), warningsOf(controllers), parameters(controllers), dependences(controllers), responses(controllers),
    bands(controllers, recording.signals.sway));
};
})();
