// Draws the page of tools/bench-report, after common.js.
(() => {
const colours = ["#17527f", "#e08a3c", "#b3322c", "#3c7d4e", "#7a4d9e", "#4a9ab5", "#8a6d1f", "#c2568b", "#56616d", "#1c2733"];
const isas = ["reference", "baseline", "avx2", "avx512", "neon"];
const { runs, benchmarks } = report;
const newest = runs.length - 1;
const had = (values, run) => !absent(values[run]);

// "avx512/conv2d/64-64@55/forward" is of the kind conv2d; "NetA/training/..." of NetA.
const kindOf = name => name.split("/").find(word => !isas.includes(word));
const plain = name => name.split("/").filter(word => !isas.includes(word)).join("/");

function time(seconds) {
  if (absent(seconds)) return "\u2013";
  const [unit, scale] = [["s", 1], ["ms", 1e-3], ["\u00b5s", 1e-6], ["ns", 1e-9]].find(([, s]) => seconds >= s) ?? ["ns", 1e-9];
  return `${compact(seconds / scale)} ${unit}`;
}

// The last run before the newest on the same machine, instruction set and compiler: only there times can be compared.
function comparable(values) {
  const same = run => ["machine", "isa", "compiler"].every(key => runs[run][key] === runs[newest][key]);
  for (let run = newest - 1; run >= 0; --run) if (same(run) && had(values, run)) return values[run];
  return null;
}

// ---- tables --------------------------------------------------------------------------------------------------------

const heads = (...names) => element("thead", {}, element("tr", {}, ...names.map((name, at) =>
  element("th", { scope: "col", ...(at ? { class: "number" } : {}) }, name))));
const row = (first, ...cells) => element("tr", {}, element("th", { scope: "row" }, first),
  ...cells.map(cell => element("td", { class: "number" }, cell)));
const table = (caption, head, rows) => element("div", { class: "scroll" },
  element("table", {}, element("caption", {}, caption), head, element("tbody", {}, ...rows)));

function runsTable() {
  return table("Oldest first.", heads("Run", "Date", "Commit", "Machine", "Compiler", "Instruction set", "Threads"),
    runs.map(run => row(run.name, run.date, run.commit, run.machine, run.compiler, run.isa, run.threads)));
}

function figuresTable() {
  const rows = benchmarks.filter(({ seconds }) => had(seconds, newest)).map(({ name, of, percent, seconds }) => {
    const before = comparable(seconds);
    return row(name, time(seconds[newest]), before === null ? "\u2013" : fixed(seconds[newest] / before, 3),
      had(percent, newest) ? `${fixed(percent[newest], 1)} % of ${of}` : "n/a");
  });
  return table(`Run ${runs[newest].name}. Ratio: time over that of the last run before on the same machine; runs of ` +
    "different days differ by more than their code, tools/bench-compare shows what the code did.",
    heads("Benchmark", "Time", "Ratio", "Of the machine"), rows);
}

// ---- charts --------------------------------------------------------------------------------------------------------

// Something of it must be drawn in one of `inks`.
function chart(main, title, caption, height, inks, settings) {
  const canvas = element("canvas", { role: "img", "aria-label": `${title}. ${caption}` });
  main.append(element("figure", {}, element("h3", {}, title),
    element("div", { class: "chart", style: `height: ${height}px` }, canvas), element("figcaption", {}, caption)));
  new Chart(canvas, { ...settings, options: { animation: false, responsive: true, maintainAspectRatio: false, ...settings.options } });
  checks.push(() => inks.some(ink => hasColour(canvas, ink)));
}

// One bar a row, with its name on the left.
function bars(main, title, caption, unit, rows, colourOf) {
  chart(main, title, caption, 60 + 18 * rows.length, [colourOf(rows[0])], {
    type: "bar",
    data: { labels: rows.map(({ label }) => label),
      datasets: [{ data: rows.map(({ value }) => value), backgroundColor: rows.map(colourOf), barPercentage: 0.9 }] },
    options: { indexAxis: "y", plugins: { legend: { display: false } },
      scales: { x: { ...axis(unit), beginAtZero: true }, y: { ticks: { autoSkip: false, color: "#3d4853", font: { size: 11 } } } } },
  });
}

function machineBars(main) {
  const rows = benchmarks.filter(({ percent }) => had(percent, newest))
    .map(({ name, of, percent }) => ({ label: name, value: percent[newest], of }));
  if (rows.length) bars(main, "Part of the machine's peak", "Blue: % of the peak of fused multiply-adds; orange: % of the bandwidth of " +
    `memory; both measured in the same run. Run ${runs[newest].name}.`, "%", rows, ({ of }) => colours[of === "peak" ? 0 : 1]);
}

// Percentages of the peak travel between machines; times do not.
function trends(main) {
  const drawn = benchmarks.filter(({ percent }) => percent.some(value => !absent(value)));
  const alone = ({ name }) => drawn.filter(other => kindOf(other.name) === kindOf(name)).length === 1;
  const titleOf = benchmark => alone(benchmark) ? "others" : kindOf(benchmark.name);
  for (const kind of new Set(drawn.map(titleOf))) {
    const lines = drawn.filter(benchmark => titleOf(benchmark) === kind);
    chart(main, `Trend: ${kind}`, "% of the machine's peak or bandwidth, from run to run.", 260 + 10 * lines.length, colours.slice(0, 4), {
      type: "line",
      data: { labels: runs.map(({ name }) => name), datasets: lines.map(({ name, percent }, at) => ({
        label: plain(name), data: percent, borderColor: colours[at % colours.length], backgroundColor: colours[at % colours.length],
        borderDash: at < colours.length ? [] : [6, 4], pointRadius: 4, borderWidth: 2, spanGaps: true })) },
      options: { plugins: { legend: { position: "right", labels: { color: "#1c2733", boxWidth: 14, font: { size: 11 } } } },
        scales: { x: { offset: true, ticks: { color: "#3d4853" } }, y: { ...axis("%"), beginAtZero: true } } },
    });
  }
}

function peers(main) {
  const run = runs.findLast(({ peers }) => peers.length > 0);
  if (run === undefined) return;
  bars(main, "Beside peers", `Ours over theirs in run ${run.name}: above 1 is more work in the same time; for memory, below 1 is less.`,
    "ratio", run.peers.map(({ what, ratio }) => ({ label: what, value: ratio })), () => colours[0]);
  main.append(table("The same as numbers.", heads("What", "Unit", "Ours over theirs"),
    run.peers.map(({ what, unit, ratio }) => row(what, unit, fixed(ratio, 2)))));
}

// ---- the page ------------------------------------------------------------------------------------------------------

const main = document.getElementById("main");
main.append(element("h3", {}, "Runs"), runsTable());
machineBars(main);
trends(main);
peers(main);
main.append(element("h3", {}, "Figures"), figuresTable());
finish();
})();
