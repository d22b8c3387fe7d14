// Draws the page of decid train, after common.js.
(() => {
const { log, epochs, best, distribution } = report;
const colours = { training: "#c0561f", validation: "#17527f", rate: "#5b6770" };

// Errors are logarithmic where they are positive, as all but the logarithms of densities are, and differ much.
function chart(title, caption, label, y, lines) {
  const canvas = element("canvas", { role: "img", "aria-label": label });
  document.getElementById("main").append(element("figure", {}, element("h3", {}, title),
    element("div", { class: "chart" }, canvas), element("figcaption", {}, caption)));
  const values = lines.flatMap(({ key }) => log.map(line => line[key])), least = Math.min(...values), [{ key }] = lines;
  const scale = axis(y);
  const logarithmic = { ...scale, type: "logarithmic", ticks: { ...scale.ticks,
    callback: (value, index, ticks) => ticks[index].major || ticks.length < 12 ? String(value) : "" } };
  new Chart(canvas, {
    type: "line",
    data: { datasets: lines.map(({ key, name }) => ({ label: name, borderColor: colours[key], backgroundColor: colours[key],
      data: log.map(line => ({ x: line.epoch, y: line[key] })), borderWidth: 1.6, pointRadius: log.length < 60 ? 2.5 : 0,
      pointHitRadius: 6 })) },
    options: {
      animation: false, normalized: true, parsing: false, responsive: true, maintainAspectRatio: false,
      interaction: { mode: "nearest", axis: "x", intersect: false },
      scales: { x: { ...axis("Epoch"), min: 0, max: Math.max(epochs, log.length) },
        y: key !== "rate" && least > 0 && Math.max(...values) > 5 * least ? logarithmic : scale },
      plugins: { legend: { display: lines.length > 1 }, tooltip: { callbacks: {
        title: items => items.length ? `Epoch ${items[0].parsed.x}` : "",
        label: item => `${item.dataset.label}: ${minus(String(Number(item.parsed.y.toPrecision(4))))}` } } },
    },
  });
  for (const { key } of lines) checks.push(() => hasColour(canvas, colours[key]));
}

const last = log[log.length - 1], kept = log[(report.keeps_best ? best : log.length) - 1];
document.title = `${report.model} \u2013 training`;
document.getElementById("main").append(
  element("p", {}, `${report.model}, preset ${report.preset}. ` + describeProtocol(report.protocol)),
  element("dl", { class: "figures" },
    figure("Epochs", `${log.length} of ${epochs}`, report.finished ? "finished" : "this page is rewritten after each; load it anew"),
    figure("Validation MSE", fixed(kept.validation, 4), `of epoch ${kept.epoch}; guessing the mean gives 1`),
    figure("Best epoch", String(best), `validation MSE ${fixed(log[best - 1].validation, 4)}`),
    figure("Trials an epoch", String(report.training_trials),
      `in batches of ${report.batch}; ${report.validation_trials} for validation`)));
const mse = "Mean squared error of the parameters, in units of their variance: guessing the mean gives 1.";
if (distribution) {
  chart("Validation error", mse + " On trials that the network does not learn from.",
    `Line chart: validation error over ${log.length} epochs`, "MSE", [{ key: "validation", name: "Validation" }]);
  chart("Training loss", "What the network learns by: minus the logarithm of the density that it gives the true parameters, " +
    "a parameter. It may be below 0.", `Line chart: training loss over ${log.length} epochs`, "Loss",
    [{ key: "training", name: "Training" }]);
} else {
  chart("Error", mse + " A validation error that rises while that of the training falls shows trials learnt by heart.",
    `Line chart: training and validation error over ${log.length} epochs`, "MSE",
    [{ key: "training", name: "Training" }, { key: "validation", name: "Validation" }]);
}
chart("Learning rate", "Of each epoch\u2019s last step.", `Line chart: learning rate, ${compact(last.rate)} in the end`, "Rate",
  [{ key: "rate", name: "Learning rate" }]);
document.getElementById("footer").append(element("p", {}, "decid ", report.version, "."));
finish();
})();
