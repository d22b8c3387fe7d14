// Draws the page of decid train, after common.js.
(() => {
const { log, epochs, best, distribution } = report;
const classes = { training: "again", validation: "draw", rate: "tilt" };

// Errors are logarithmic where they are positive, as all but the logarithms of densities are, and differ much.
function chart(title, caption, label, y, lines) {
  const values = lines.flatMap(({ key }) => log.map(line => line[key])), least = Math.min(...values), [{ key: first }] = lines;
  document.getElementById("main").append(chartFigure(title, caption, plot({ title: label,
    x: { text: "Epoch", low: 0, high: Math.max(epochs, log.length) },
    y: { text: y, logarithmic: first !== "rate" && least > 0 && Math.max(...values) > 5 * least },
    marks: lines.map(({ key, name }) => ({ name, class: classes[key], line: log.map(line => [line.epoch, line[key]]), dots: log.length < 60 })) })));
}

const last = log[log.length - 1], kept = log[(report.keeps_best ? best : log.length) - 1];
document.title = `${report.model} \u2013 training`;
document.getElementById("main").append(
  element("h2", {}, report.model), element("p", { class: "about" }, `Preset ${report.preset}. ` + describeProtocol(report.protocol)),
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
