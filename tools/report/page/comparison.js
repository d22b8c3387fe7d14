// Draws the page of decid compare, after common.js and method_table.js.
(() => {
const classes = ["draw", "again", "mark", "third", "fourth", "tilt"];
const names = Object.keys(report.methods[0].mse_per_parameter);

// Draws one group of bars per parameter, one bar per method.
function errorChart() {
  const width = 0.84 / report.methods.length;
  const bars = (method, index) => [...names.map(name => method.mse_per_parameter[name]), method.mse].map((mse, place) =>
    [place - 0.42 + width * index, place - 0.42 + width * (index + 0.92), mse]);
  return chartFigure("Error of each parameter", "Dashed: error of predicting the mean, 1.",
    plot({ title: "Bars: MSE of each parameter by method", x: { names: [...names, "all"] }, y: { text: "MSE, z-scored", zero: true },
      marks: [...report.methods.map((method, index) => ({ name: method.name, class: classes[index % classes.length], bars: bars(method, index) })),
        { name: "the mean", class: "edge", level: 1 }] }));
}

const main = document.getElementById("main");
main.append(element("h2", {}, "Compared methods"), element("p", { class: "about" }, describeProtocol(report.protocol)), ...methodComparison(report),
  errorChart());
document.getElementById("footer").append(element("p", {}, "decid ", report.version, "."), ...callTexts(report.call));
finish();
})();
