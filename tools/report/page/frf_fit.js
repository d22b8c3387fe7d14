// Draws the page of decid fit --frf, after common.js and plot.js.
(() => {
const main = document.getElementById("main"), answers = [report, ...(report.controllers ?? []).slice(1)];
const number = text => element("td", { class: "number" }, text), heading = (text, kind = "") => element("th", { scope: "col", class: kind }, text);
const table = (caption, head, rows) => element("div", { class: "scroll" }, element("table", {}, element("caption", {}, caption),
  element("thead", {}, element("tr", {}, ...head)), element("tbody", {}, ...rows)));

function comparison() {
  const rows = report.controllers.map(each => element("tr", {}, element("th", { scope: "row" }, each.controller),
    number(fixed(each.log_predictive_density, 1)),
    number(each.difference < 0 ? `${fixed(each.difference, 1)} \u00b1 ${fixed(each.difference_standard_error, 1)}` : "best"),
    number(fixed(each.weight, 2)), number(fixed(100 * each.relative_error, 1) + "%")));
  return table("Log predictive density: the sum over the frequencies of the density of each row, given all others; larger is better. " +
    "\u00b1 is the standard error of the difference. The weights make the mixture of the controllers that predicts best.",
    [heading("Controller"), ...["Log predictive density", "Difference", "Weight", "Relative error"].map(text => heading(text, "number"))], rows);
}

function responseFigure({ controller, frf, misfit }) {
  const at = (low, high) => frf.frequency_hz.map((x, i) => [x, low[i], high[i]]), line = values => frf.frequency_hz.map((x, i) => [x, values[i]]);
  const bounds = key => [0, 1].map(end => frf[key].map(interval => interval[end]));
  const chart = (title, y, key, legend) => plot({ title, height: 280, legend, y,
    x: { text: "Frequency (Hz)", logarithmic: true, low: frf.frequency_hz[0], high: frf.frequency_hz.at(-1) },
    marks: [{ name: `${controller}, 90 % of the draws`, class: "again-soft", band: at(...bounds(`model_${key}_interval90`)) },
      { name: controller, class: "again dashed", line: line(frf[`model_${key === "gain" ? "gain" : "phase_deg"}`]) },
      { name: "Table", class: "draw", line: line(frf[key === "gain" ? "gain" : "phase_deg"]), dots: true }] });
  return chartFigure(`Response of ${controller}`, `Sway over tilt at the table\u2019s frequencies. The mean of the draws leaves ` +
    `${fixed(100 * misfit.relative_error, 1)} % of the response (root mean square of the relative error).`,
    chart(`Line chart: gain of the table and of ${controller} over frequency`, { text: "Gain (deg/deg)", logarithmic: true }, "gain", true),
    chart(`Line chart: phase of the table and of ${controller} over frequency`, { text: "Phase (deg)" }, "phase", false));
}

function parameterTable({ controller, parameters }) {
  const rows = parameters.map(each => element("tr", {}, element("th", { scope: "row" }, each.name), number(compact(each.value)),
    number(each.fixed ? "fixed" : each.interval90.map(compact).join(" to ")), element("td", {}, unitOf(each)),
    number(absent(each.normalized) ? "" : fixed(each.normalized, 3)), number(fixed(each.contraction, 2)), number(each.range.map(compact).join(" to "))));
  return table(`Parameters of ${controller}. Contraction: the fraction of the prior\u2019s variance that the table removes; at 0 it says nothing.`,
    [heading("Parameter"), heading("Mean", "number"), heading("90 % of the draws", "number"), heading("Unit"), heading("/ (m g h)", "number"),
      heading("Contraction", "number"), heading("Range", "number")], rows);
}

document.title = `${report.file} \u2013 frequency response`;
main.append(element("h2", {}, report.file), element("p", { class: "about" }, `${report.frf.frequency_hz.length} frequencies, protocol \u201c${report.protocol}\u201d.`));
if (report.controllers) main.append(comparison());
for (const answer of answers) {
  main.append(element("h2", {}, `Controller ${answer.controller}: ${answer.trust}`),
    ...answer.warnings.map(({ text }) => element("p", { class: "warning" }, text)), responseFigure(answer));
  if (answer.warnings.some(({ code }) => code === "no_controller"))
    main.append(element("p", {}, "No parameters are shown, as no controller of this model has this response."));
  else main.append(parameterTable(answer));
}
document.getElementById("footer").append(element("p", {}, "decid ", report.decid, "."));
finish();
})();
