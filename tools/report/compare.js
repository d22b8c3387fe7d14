// Draws the page of decid compare, after common.js.
(() => {
const palette = ["#17527f", "#e08a3c", "#b3322c", "#3f8f5b", "#7a5ba6"];
const names = Object.keys(report.methods[0].mse_per_parameter);
const count = value => value.toLocaleString("en-US", { maximumFractionDigits: 0 });
const noise = report.sensor_noise_deg;
const noiseText = noise[1] === 0 ? "no sensor noise"
  : `sensor noise of ${compact(noise[0])}${noise[1] === noise[0] ? "" : ` to ${compact(noise[1])}`} deg`;

function methodTable() {
  const number = text => element("th", { scope: "col", class: "number" }, text);
  const cell = text => element("td", { class: "number" }, text);
  const rows = report.methods.map(method => element("tr", {},
    element("th", { scope: "row" }, method.name, element("span", { class: "description" }, method.description)),
    cell(`${fixed(method.mse, 3)} \u00b1 ${fixed(method.mse_standard_error, 3)}`),
    ...names.map(name => cell(fixed(method.mse_per_parameter[name], 3))),
    cell(count(method.simulations)), cell(compact(method.seconds))));
  return element("div", { class: "scroll" }, element("table", {},
    element("caption", {}, "MSE over the trials of the z-scored parameters: predicting the mean gives 1. \u00b1 is the standard " +
      "error over the trials. Simulations and seconds are those of one trial; the network's training is not counted."),
    element("thead", {}, element("tr", {}, element("th", { scope: "col" }, "Method"), number("MSE"), ...names.map(number),
      number("Simulations"), number("Seconds"))),
    element("tbody", {}, ...rows)));
}

function errorChart(main) {
  const canvas = element("canvas", { role: "img", "aria-label": "Bars: MSE of each parameter by method" });
  main.append(element("figure", {}, element("h3", {}, "Error of each parameter"), element("div", { class: "chart" }, canvas),
    element("figcaption", {}, "The dashed height 1 is what predicting the mean reaches; above it, an estimate is worse than none.")));
  const labels = [...names, "all"];
  new Chart(canvas, {
    type: "bar",
    data: { labels, datasets: [
      ...report.methods.map((method, index) => ({ label: method.name, backgroundColor: palette[index % palette.length],
        data: [...names.map(name => method.mse_per_parameter[name]), method.mse] })),
      { type: "line", label: "the mean", borderColor: "#56616d", borderDash: [6, 4], borderWidth: 2, pointRadius: 0,
        data: labels.map(() => 1) }] },
    options: {
      animation: false, responsive: true, maintainAspectRatio: false,
      scales: { x: { grid: { display: false }, ticks: { color: "#3d4853" } }, y: { ...axis("MSE, z-scored"), beginAtZero: true } },
      plugins: { legend: { position: "top", align: "end", labels: { color: "#1c2733" } } },
    },
  });
  checks.push(() => report.methods.every((method, index) => hasColour(canvas, palette[index % palette.length])));
}

const main = document.getElementById("main");
main.append(element("h2", {}, `${count(report.trials)} trials, ${noiseText}`),
  element("p", { class: "about" }, `${describeProtocol(report.protocol)} Trials: ${report.trials_from}. Network: ${report.model}. ` +
    `Fits: up to ${count(report.budget)} simulations, ${report.starts} start${report.starts === 1 ? "" : "s"} (from the network: 1), ` +
    `${report.threads} thread${report.threads === 1 ? "" : "s"}.`),
  methodTable(), ...report.methods.filter(method => !absent(method.error_per_standard_error)).map(method =>
    element("p", { class: "note" }, `${method.name}: errors are ${fixed(method.error_per_standard_error, 2)} times the ` +
      "standard errors that the fit states (root mean square; 1 if these are right).")));
errorChart(main);
document.getElementById("footer").append(element("p", {}, "decid ", report.version, "."));
finish();
})();
