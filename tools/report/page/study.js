// Fills the page of decid study, after common.js and method_table.js. The figures are the SVG files that the program drew.
(() => {
const main = document.getElementById("main");
document.title = `${report.model} \u2013 study`;

// ---- tables --------------------------------------------------------------------------------------------------------

const number = text => element("th", { scope: "col", class: "number" }, text);
const cells = list => list.map(text => element("td", { class: "number" }, text));

function comparison() {
  return element("div", { class: "scroll" }, element("table", {},
    element("caption", {}, report.convention),
    element("thead", {}, element("tr", {}, element("th", { scope: "col" }), number("MSE, or the figure"),
      number("MATLAB\u2019s loss"), number("By the paper\u2019s SD"), number("The paper"))),
    element("tbody", {}, ...report.rows.map(([what, ...values]) =>
      element("tr", {}, element("th", { scope: "row" }, what), ...cells(values))))));
}

function distributions(set) {
  const digits = value => absent(value) ? "n/a" : minus(String(Number(value.toPrecision(5))));
  return element("div", { class: "scroll" }, element("table", {},
    element("caption", {}, "Distribution of the trials\u2019 parameters after enrichment, and the paper\u2019s table. No variable " +
      "within the paper\u2019s ranges can have the paper\u2019s standard deviations."),
    element("thead", {}, element("tr", {}, element("th", { scope: "col" }, "Parameter"), number("Mean"), number("SD"),
      number("Paper\u2019s mean"), number("Paper\u2019s SD"))),
    element("tbody", {}, ...Object.entries(set.after_enrichment).map(([name, { mean, sd }]) => element("tr", {},
      element("th", { scope: "row" }, name),
      ...cells([mean, sd, report.paper.mean[name], report.paper.sd[name]].map(digits)))))));
}

function faults() {
  return element("div", { class: "scroll" }, element("table", {},
    element("caption", {}, report.faults_convention),
    element("thead", {}, element("tr", {}, element("th", { scope: "col" }), number("MSE"), number("Predicted variance"),
      number("90% coverage"), number("Warned"))),
    element("tbody", {}, ...report.fault_rows.map(([what, values]) =>
      element("tr", {}, element("th", { scope: "row" }, what), ...cells(values))))));
}

// ---- figures -------------------------------------------------------------------------------------------------------

function drawnBefore({ id, title, caption, svg }) {
  const source = "data:image/svg+xml;charset=utf-8," + encodeURIComponent(svg);
  return element("figure", { id }, element("h3", {}, title), element("img", { src: source, alt: title, class: "drawing" }),
    element("figcaption", {}, `${caption} Files: ${id}.svg, ${id}.csv.`));
}

// ---- the page ------------------------------------------------------------------------------------------------------

const { errors, data_set, training, double_pendulum } = report;
main.append(element("h2", {}, report.model), element("p", { class: "about" }, describeProtocol(report.protocol)));
const quoted = errors.validation ?? errors.fresh;
main.append(element("dl", { class: "figures" },
  figure(errors.validation ? "Validation MSE" : "MSE on test trials", fixed(quoted.mse, 4),
    `MATLAB\u2019s loss ${fixed(quoted.matlab_loss, 4)}; the paper prints ${report.paper.validation_loss}`),
  ...(training ? [figure("Epochs", String(training.epochs), `the model of epoch ${training.kept_epoch} was kept`)] : []),
  ...(double_pendulum ? [figure("Double pendulum, SE", fixed(double_pendulum.squared_error, 2),
    `the paper prints ${report.paper.double_pendulum_squared_error}`)] : []),
  ...Object.entries(report.seconds).map(([name, seconds]) => figure(`Time, ${name}`, `${compact(seconds)} s`, ""))));
if (report.notes.length > 0) main.append(element("div", { class: "warning" }, element("ul", {}, ...report.notes.map(note => element("li", {}, note)))));
main.append(element("h3", {}, "Comparison with the paper"), comparison());
if (data_set) main.append(element("h3", {}, "Parameters of the trials"), distributions(data_set));
if (report.fault_rows.length > 0) main.append(element("h3", {}, "Recordings with faults"), faults());
for (const one of report.comparisons) main.append(...methodComparison(one));
main.append(...report.figures.map(drawnBefore));
document.getElementById("footer").append(element("p", {}, "decid ", report.version, ", weights ", element("code", {}, report.weights_sha256), "."), ...callTexts(report.call));
finish();
})();
