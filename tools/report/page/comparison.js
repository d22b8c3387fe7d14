// Draws the page of decid compare, after common.js and method_table.js.
(() => {
const palette = ["#17527f", "#e08a3c", "#b3322c", "#3f8f5b", "#7a5ba6", "#8a6d3b"];
const names = Object.keys(report.methods[0].mse_per_parameter);
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
main.append(element("h2", {}, "What was compared"), element("p", { class: "about" }, describeProtocol(report.protocol)), ...methodComparison(report));
errorChart(main);
document.getElementById("footer").append(element("p", {}, "decid ", report.version, "."));
finish();
})();
