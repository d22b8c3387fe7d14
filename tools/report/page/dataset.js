// Draws the report of decid dataset, after common.js.
(() => {
const classes = { base: "draw", enriched: "again" };
const enriched = report.children > 0;
const sets = enriched ? ["base", "enriched"] : ["base"];
const titles = { base: enriched ? "Before enrichment" : "All trials", enriched: "After enrichment" };
const count = value => value.toLocaleString("en-US");
const distributions = Object.entries(report.distributions).map(([name, figures]) => ({ name, ...figures }));
const amplitude = distributions.at(-1), parameters = distributions.slice(0, -1);
const degrees = radians => radians * 180 / Math.PI;
const titleOf = distribution => distribution === amplitude ? amplitude.description : distribution.name;
const withUnit = distribution => titleOf(distribution) + (unitOf(distribution) && ` (${unitOf(distribution)})`);

// ---- tables --------------------------------------------------------------------------------------------------------

function distributionTable() {
  const number = text => element("th", { scope: "col", class: "number" }, text);
  const group = set => element("th", { scope: "colgroup", colspan: "4", class: "number" },
    `${titles[set]}: ${count(set === "base" ? report.base_trials : report.trials)} trials`);
  const rows = distributions.map(distribution => {
    const decimals = decimalsOf(distribution) + 1;
    const cells = sets.flatMap(set => ["mean", "sd", "min", "max"].map(key =>
      element("td", { class: "number" }, fixed(distribution[set][key], decimals))));
    return element("tr", {},
      element("th", { scope: "row" }, titleOf(distribution), distribution === amplitude ? null
        : element("span", { class: "description" }, distribution.description)),
      element("td", {}, unitOf(distribution) || "\u2013"), ...cells);
  });
  return element("div", { class: "scroll" }, element("table", {},
    element("caption", {}, "Mean, standard deviation, lowest and highest value of the valid trials. The peak-to-peak sway is of the noise-free sway."),
    element("thead", {},
      element("tr", {}, element("td", { colspan: "2" }), ...sets.map(group)),
      element("tr", {}, element("th", { scope: "col" }, "Parameter"), element("th", { scope: "col" }, "Unit"),
        ...sets.flatMap(() => [number("Mean"), number("SD"), number("Min"), number("Max")]))),
    element("tbody", {}, ...rows)));
}

// ---- histograms ----------------------------------------------------------------------------------------------------

// Draws the counts of both sets over each other: the base trials are a part of the enriched set, and stand in front.
function histogram(distribution, height, sheet, threshold = [], legend = true) {
  const { low, high } = distribution, width = (high - low) / distribution.base.counts.length;
  const bars = set => distribution[set].counts.map((count, bin) => [low + (bin + 0.03) * width, low + (bin + 0.97) * width, count]);
  return plot({ title: `Histogram of ${titleOf(distribution)}, ` + sets.map(set => `${titles[set].toLowerCase()}: mean ${compact(distribution[set].mean)}, ` +
      `SD ${compact(distribution[set].sd)}`).join("; "), x: { text: withUnit(distribution), low, high }, y: { text: "Trials", zero: true }, height, sheet, legend,
    marks: [...[...sets].reverse().map(set => ({ name: titles[set], class: classes[set], bars: bars(set) })), ...threshold] });
}

const amplitudeFigure = () => chartFigure("Peak-to-peak sway", `Most bodies sway little. Trials above ${report.parent_threshold_rad} rad ` +
  `(${inDegrees(degrees(report.parent_threshold_rad), 2)}, the dashed line) are the parents of the enrichment: ` +
  `${count(report.parents)} of ${count(report.base_trials)} base trials. A trial is valid while the body stays within 5\u00b0.`,
  histogram(amplitude, 320, 688, [{ class: "truth dashed", upright: report.parent_threshold_rad, text: `${report.parent_threshold_rad} rad` }]));

function parameterFigure() {
  return element("figure", {}, element("h3", {}, "Parameters"),
    element("div", { class: "panels" }, ...parameters.map(parameter =>
      element("div", {}, element("h4", {}, parameter.description), histogram(parameter, 240, 330, [], false).made))),
    element("figcaption", {}, "decid draws parameters uniformly from these ranges. Deviations come from trials that fell and were left out" +
      (enriched ? ", and from the children of the parents above." : ".")));
}

// ---- the page ------------------------------------------------------------------------------------------------------

const main = document.getElementById("main");
document.title = `${report.file} \u2013 data set report`;
main.append(element("h2", {}, report.file),
  element("p", { class: "about" }, `${describeProtocol(report.protocol)} Seed ${report.seed}, ${count(report.samples)} samples per trial.`));
main.append(element("dl", { class: "figures" },
  figure("Trials", count(report.trials), `${count(report.base_trials)} base trials, ${count(report.children)} children`),
  figure("Acceptance", fixed(100 * report.acceptance_rate, 1) + "%",
    `${count(report.base_trials)} of ${count(report.base_attempts)} base attempts stay within 5\u00b0`),
  figure("Parents", count(report.parents), `base trials above ${report.parent_threshold_rad} rad peak to peak`),
  ...(enriched ? [figure("Acceptance of children", fixed(100 * report.child_acceptance_rate, 1) + "%",
    `${count(report.children)} of ${count(report.child_attempts)} attempts`)] : [])));
main.append(element("h3", {}, "Distributions"), distributionTable(), amplitudeFigure(), parameterFigure());
document.getElementById("footer").append(element("p", {}, "decid ", report.version, ", ",
  fixed(report.bytes / 1e6, 1), " MB, SHA-256 ", element("code", {}, report.sha256), "."), ...callTexts(report.call));
finish();
})();
