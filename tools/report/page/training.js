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
    figure("Epochs", `${log.length} of ${epochs}`, report.finished ? "finished" : "decid rewrites this page after each; reload it"),
    figure("Validation MSE", fixed(kept.validation, 4), `of epoch ${kept.epoch}; guessing the mean gives 1`),
    figure("Best epoch", String(best), `validation MSE ${fixed(log[best - 1].validation, 4)}`),
    figure("Trials per epoch", String(report.training_trials),
      `in batches of ${report.batch}; ${report.validation_trials} for validation`)));
const mse = "Mean squared error of the parameters, in units of their variance: guessing the mean gives 1.";
if (distribution) {
  chart("Validation error", mse + " Measured on trials that are not in the training.",
    `Line chart: validation error over ${log.length} epochs`, "MSE", [{ key: "validation", name: "Validation" }]);
  chart("Training loss", "Minus the logarithm of the predicted density at the true parameters, per parameter. It may be below 0.", `Line chart: training loss over ${log.length} epochs`, "Loss",
    [{ key: "training", name: "Training" }]);
} else {
  chart("Error", mse + " If the validation error rises while the training error falls, the network is overfitted.",
    `Line chart: training and validation error over ${log.length} epochs`, "MSE",
    [{ key: "training", name: "Training" }, { key: "validation", name: "Validation" }]);
}
chart("Learning rate", "Learning rate of the last step of each epoch.", `Line chart: learning rate, ${compact(last.rate)} in the end`, "Rate",
  [{ key: "rate", name: "Learning rate" }]);
document.getElementById("footer").append(element("p", {}, "decid ", report.version, "."), ...callTexts(report.call));
finish();
})();
