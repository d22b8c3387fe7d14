// Draws the page of decid fit --frf, after common.js, plot.js, parameters.js and responses.js.
(() => {
const main = document.getElementById("main"), answers = [report, ...(report.controllers ?? []).slice(1)];
for (const { parameters } of answers) parameters.forEach(inShownUnit);
const number = text => element("td", { class: "number" }, text);
const table = (caption, head, rows) => element("div", { class: "scroll" }, element("table", {}, element("caption", {}, caption),
  element("thead", {}, element("tr", {}, ...head)), element("tbody", {}, ...rows)));

// ---- the controllers side by side ------------------------------------------------------------------------------------

// Returns the frequency that a controller explains least: "48% at 0.05 Hz".
function largestError({ frf }) {
  const errorAt = i => {
    const ratio = frf.model_gain[i] / frf.gain[i], turned = (frf.model_phase_deg[i] - frf.phase_deg[i]) * Math.PI / 180;
    return Math.hypot(ratio * Math.cos(turned) - 1, ratio * Math.sin(turned));
  };
  const errors = frf.gain.map((_, i) => errorAt(i)), worst = errors.indexOf(Math.max(...errors));
  return `${percent(errors[worst])} at ${compact(frf.frequency_hz[worst])} Hz`;
}

function comparison() {
  const rows = report.controllers.map((each, i) => element("tr", {}, element("th", { scope: "row" }, each.controller),
    number(fixed(each.log_predictive_density, 1)),
    number(each.difference < 0 ? `${fixed(each.difference, 1)} \u00b1 ${fixed(each.difference_standard_error, 1)}` : "best"),
    number(fixed(each.weight, 2)), number(fixed(100 * each.relative_error, 1) + "%"), number(largestError(answers[i]))));
  return table("Log predictive density: the sum over the frequencies of the density of each row, given all others; larger is better. " +
    "\u00b1 is the standard error of the difference. The weights make the mixture of the controllers that predicts best. Relative error: the part of the response " +
    "that the mean of the draws does not explain, as root mean square over the frequencies, and at the worst frequency.",
    [columnHead("Controller", "", ""), ...["Log predictive density", "Difference \u00b1 1 SE", "Weight", "Relative error", "Largest error"].map(text => columnHead(text))], rows);
}

const responses = () => responsesFigure(answers, ["Controller, 90% interval", "Mean"],
  "Sway over platform tilt. Where the recorded response leaves the band, the controller does not explain it. " +
    answers.map(({ controller, misfit }) => `${controller} leaves ${fixed(100 * misfit.relative_error, 1)}% of the response`).join("; ") +
    " (root mean square of the relative error).");

// ---- each controller -------------------------------------------------------------------------------------------------

function parameterTable({ controller, parameters }) {
  const rows = parameters.map(each => {
    Object.assign(each, { low: each.range[0], high: each.range[1] });
    const relative = absent(each.normalized) ? "\u2013" : fixed(each.normalized, 3) + normalizedUnit(each);
    return element("tr", {}, nameCell(each), number(valueOf(each)),
      number(intervalOf(each)), number(relative), number(each.fixed ? "\u2013" : fixed(each.contraction, 2)),
      number(each.range.map(compact).join(" to ")));
  });
  return table(`Parameters of ${controller}. Contraction: the fraction of the prior\u2019s variance that the table removes; at 0 the table does not determine the parameter.`,
    [columnHead("Parameter", "", ""), columnHead("Estimate \u00b1 uncertainty", "1 SD"), columnHead("90% interval"), columnHead("Relative to gravity", "over m g h"),
      columnHead("Contraction"), columnHead("Model\u2019s limits", "not a normal range")], rows);
}

document.title = `${report.file} \u2013 frequency response`;
main.append(element("section", { "aria-label": report.file }, element("h2", {}, report.file),
  ...answers.map(answer => trustBox(answer, "table", answers.length > 1 ? `${answer.controller}: ` : "")),
  element("p", { class: "about" }, `${report.frf.frequency_hz.length} frequencies, protocol \u201c${report.protocol}\u201d.`),
  report.controllers ? comparison() : null, responses()));
for (const answer of answers) {
  const explained = answer.warnings.every(({ code }) => code !== "no_controller");
  main.append(element("section", { "aria-label": answer.controller }, element("h2", {}, `Controller ${answer.controller}: ${answer.trust}`),
    ...answer.warnings.filter(({ severity }) => severity === "info").map(({ text }) => element("p", { class: "about" }, "Note: " + text)),
    explained ? parameterTable(answer) : element("p", {}, "No parameters are shown, as no controller of this model has this response.")));
}
document.getElementById("footer").append(element("p", {}, "decid ", report.decid, "."), ...callTexts(report.call));
finish();
})();
