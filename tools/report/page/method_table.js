// Draws the results of decid compare, for its page and the page of decid study: a heading, the compared methods, the table.
function methodTable(comparison) {
  const count = value => value.toLocaleString("en-US", { maximumFractionDigits: 0 });
  const names = Object.keys(comparison.methods[0].mse_per_parameter);
  const number = text => element("th", { scope: "col", class: "number" }, text);
  const cell = text => element("td", { class: "number" }, text);
  const rows = comparison.methods.map(method => element("tr", {},
    element("th", { scope: "row" }, method.name, element("span", { class: "description" }, method.description)),
    cell(`${fixed(method.mse, 3)} \u00b1 ${fixed(method.mse_standard_error, 3)}`),
    ...names.map(name => cell(fixed(method.mse_per_parameter[name], 3))),
    cell(count(method.simulations)), cell(compact(method.seconds))));
  return element("div", { class: "scroll" }, element("table", { class: "methods" },
    element("caption", {}, "MSE over the trials of the z-scored parameters: predicting the mean gives 1. \u00b1 is the standard " +
      "error over the trials. Simulations and seconds are those of one trial; the network's training is not counted."),
    element("thead", {}, element("tr", {}, element("th", { scope: "col" }, "Method"), number("MSE"), ...names.map(number),
      number("Simulations"), number("Seconds"))),
    element("tbody", {}, ...rows)));
}

function methodComparison(comparison) {
  const [low, high] = comparison.sensor_noise_deg;
  const noise = high === 0 ? "no measurement noise" : `measurement noise of ${compact(low)}${low === high ? "" : ` to ${compact(high)}`}\u00b0`;
  const s = number => number === 1 ? "" : "s";
  return [element("h3", {}, `Network, posterior and iterative fit: ${comparison.trials} trials, ${noise}`),
    element("p", { class: "about" }, `Trials: ${comparison.trials_from}. Network: ${comparison.model}. Fits: up to ` +
      `${comparison.budget.toLocaleString("en-US")} simulations, ${comparison.starts} start${s(comparison.starts)} (from the network: 1), ` +
      `${comparison.threads} thread${s(comparison.threads)}.`),
    methodTable(comparison),
    ...comparison.methods.filter(method => !absent(method.error_per_standard_error)).map(method =>
      element("p", { class: "note" }, `${method.name}: errors are ${fixed(method.error_per_standard_error, 2)} times the ` +
        "standard errors that the fit states (root mean square; 1 if these are right)."))];
}
