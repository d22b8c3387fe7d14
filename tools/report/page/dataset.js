// Draws the report of decid dataset, after common.js.
(() => {
const colours = { base: "#17527f", enriched: "#e08a3c", threshold: "#b3322c" };
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
    const cells = sets.flatMap(set => ["mean", "deviation", "min", "max"].map(key =>
      element("td", { class: "number" }, fixed(distribution[set][key], decimals))));
    return element("tr", {},
      element("th", { scope: "row" }, titleOf(distribution), distribution === amplitude ? null
        : element("span", { class: "description" }, distribution.description)),
      element("td", {}, unitOf(distribution) || "\u2013"), ...cells);
  });
  return element("div", { class: "scroll" }, element("table", {},
    element("caption", {}, "Mean and standard deviation of the valid trials, their least and largest value. The " +
      "peak-to-peak sway is that of the exact trial, without sensor noise."),
    element("thead", {},
      element("tr", {}, element("td", { colspan: "2" }), ...sets.map(group)),
      element("tr", {}, element("th", { scope: "col" }, "Parameter"), element("th", { scope: "col" }, "Unit"),
        ...sets.flatMap(() => [number("Mean"), number("Deviation"), number("Min"), number("Max")]))),
    element("tbody", {}, ...rows)));
}

// ---- histograms ----------------------------------------------------------------------------------------------------

// An upright line at a value of the x axis, with its name.
const lineAt = (value, text) => ({
  id: "line",
  afterDatasetsDraw({ ctx, chartArea, scales }) {
    const x = scales.x.getPixelForValue(value);
    ctx.save();
    ctx.strokeStyle = ctx.fillStyle = colours.threshold;
    ctx.lineWidth = 2;
    ctx.setLineDash([6, 4]);
    ctx.beginPath();
    ctx.moveTo(x, chartArea.top);
    ctx.lineTo(x, chartArea.bottom);
    ctx.stroke();
    ctx.font = "13px system-ui, 'Liberation Sans', sans-serif";
    ctx.fillText(text, x + 6, chartArea.top + 14);
    ctx.restore();
  },
});

// Draws the counts of both sets over each other: the base trials are a part of the enriched set, and stand in front.
function histogram(holder, canvas, distribution, plugins, legend) {
  const { low, high } = distribution;
  const width = (high - low) / distribution.base.counts.length;
  const bars = set => ({
    label: titles[set], backgroundColor: colours[set], grouped: false, barPercentage: 1, categoryPercentage: 0.94,
    data: distribution[set].counts.map((y, bin) => ({ x: low + (bin + 0.5) * width, y })),
  });
  const edge = value => compact(value) + (unitOf(distribution) && ` ${unitOf(distribution)}`);
  new Chart(canvas, {
    type: "bar",
    data: { datasets: sets.map(bars) },
    plugins,
    options: {
      animation: false, parsing: false, responsive: true, maintainAspectRatio: false,
      interaction: { mode: "index", intersect: false },
      scales: { x: { ...axis(withUnit(distribution)), min: low, max: high, offset: false, grid: { display: false } },
        y: { ...axis("Trials"), beginAtZero: true } },
      plugins: {
        legend: { display: legend, position: "top", align: "end", labels: { color: "#1c2733" } },
        tooltip: { callbacks: { title: items => items.length
          ? `${edge(items[0].parsed.x - width / 2)} to ${edge(items[0].parsed.x + width / 2)}` : "" } },
      },
    },
  });
  checks.push(() => sets.every((set, index) => {
    const hidden = index > 0 && distribution[set].counts.every((y, bin) => y <= distribution.base.counts[bin]);
    return hidden || hasColour(canvas, colours[set]);
  }));
  return holder;
}

function chartOf(distribution) {
  const canvas = element("canvas", { role: "img", "aria-label": `Histogram of ${titleOf(distribution)}, ` +
    sets.map(set => `${titles[set].toLowerCase()}: mean ${compact(distribution[set].mean)}, ` +
      `deviation ${compact(distribution[set].deviation)}`).join("; ") });
  return { canvas, holder: element("div", { class: "chart" }, canvas) };
}

function amplitudeFigure(main) {
  const { canvas, holder } = chartOf(amplitude);
  main.append(element("figure", {}, element("h3", {}, "Peak-to-peak sway"), holder, element("figcaption", {},
    `Most bodies sway little. Trials above ${report.parent_threshold_rad} rad ` +
    `(${fixed(degrees(report.parent_threshold_rad), 2)} deg, the dashed line) are the parents of the enrichment: ` +
    `${count(report.parents)} of ${count(report.base_trials)} base trials. A trial is valid while the body stays within 5 deg.`)));
  histogram(holder, canvas, amplitude, [lineAt(report.parent_threshold_rad, `${report.parent_threshold_rad} rad`)], true);
}

function parameterFigure(main) {
  const charts = parameters.map(chartOf);
  main.append(element("figure", {}, element("h3", {}, "Parameters"),
    element("div", { class: "heatmaps" }, ...charts.map(({ holder }, index) =>
      element("div", {}, element("h4", {}, parameters[index].description), holder))),
    element("figcaption", {}, "Parameters are drawn uniformly from these ranges; what is not uniform here is due to the " +
      "trials that fell over and were left out" + (enriched ? ", and to the children of the parents above." : "."))));
  charts.forEach(({ canvas, holder }, index) => histogram(holder, canvas, parameters[index], [], index === 0));
}

// ---- the page ------------------------------------------------------------------------------------------------------

const main = document.getElementById("main");
document.title = `${report.file} \u2013 data set report`;
main.append(element("h2", {}, report.file),
  element("p", { class: "about" }, `${describeProtocol(report.protocol)} Seed ${report.seed}, ${count(report.samples)} samples a trial.`));
main.append(element("dl", { class: "figures" },
  figure("Trials", count(report.trials), `${count(report.base_trials)} base trials, ${count(report.children)} children`),
  figure("Acceptance", fixed(100 * report.acceptance_rate, 1) + " %",
    `${count(report.base_trials)} of ${count(report.base_attempts)} base attempts stay within 5 deg`),
  figure("Parents", count(report.parents), `base trials above ${report.parent_threshold_rad} rad peak to peak`),
  ...(enriched ? [figure("Acceptance of children", fixed(100 * report.child_acceptance_rate, 1) + " %",
    `${count(report.children)} of ${count(report.child_attempts)} attempts`)] : [])));
main.append(element("h3", {}, "Distributions"), distributionTable());
amplitudeFigure(main);
parameterFigure(main);
document.getElementById("footer").append(element("p", {}, "decid ", report.version, ", ",
  fixed(report.bytes / 1e6, 1), " MB."));
finish();
})();
