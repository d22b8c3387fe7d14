// The section of several fitted controllers, after common.js, plot.js and recordings.js: predictions, parameters, what each cannot explain.
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

// Recorded sway over the band of each controller's simulated trials.
function bands(controllers, sway) {
  const points = (signal, values, others) => values.map((value, i) =>
    [signal.first_s + i * signal.step_s, value / signal.per_degree, ...(others ? [others[i] / signal.per_degree] : [])]);
  return controllers.filter(one => one.sway.again_low).map(one => {
    const recorded = points(sway, sway.recorded), title = `Sway that ${one.name} predicts`;
    const { made, draw } = plot({ title, x: { text: "Time (s)", low: 0, high: recorded[recorded.length - 1][0] }, y: { text: "Sway (\u00b0)" }, height: 200,
      marks: [{ name: `${one.name}: 90% of simulated trials`, class: "again-soft", band: points(one.sway, one.sway.again_low, one.sway.again_high) },
        { name: "Recorded", class: "recorded", line: recorded }] });
    draw(0, recorded[recorded.length - 1][0]);
    return element("div", { class: "timeline" }, element("h4", {}, title), made);
  });
}

return recording => {
  const { controllers } = recording;
  if (controllers.length === 0) return null;
  for (const { parameters } of controllers) parameters.forEach(inShownUnit);
  return element("section", { class: "controllers", "aria-label": "Which controller?" }, element("h3", {}, "Which controller?"),
    element("p", { class: "note" }, "Each controller predicts every part of the recording from the rest. A larger log predictive density is better; a difference below " +
      "two standard errors decides nothing, nor does a fit whose chains do not agree (not comparable). The weights are those of the mixture that predicts best. \u201cCannot explain\u201d lists checks with p below 0.01."),
    predictions(controllers), parameters(controllers), ...bands(controllers, recording.signals.sway));
};
})();
