// Draws the page of tools/bench-report, after common.js and plot.js.
(() => {
const classes = ["", " dashed", " dotted"].flatMap(dash => ["draw", "again", "mark", "third", "fourth", "tilt"].map(kind => kind + dash));
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
    heads("Benchmark", "Time", "Ratio", "% of peak"), rows);
}

// ---- charts --------------------------------------------------------------------------------------------------------

// One bar a row, with its name above it; forty rows a drawing, so that each fits on a sheet.
function bars(main, title, caption, unit, rows, classOf) {
  const width = 1000, right = width - 70, row = 26, most = Math.max(...rows.map(({ value }) => value));
  const drawn = (shown, first) => drawing(width, row * shown.length, `${title}, from row ${first + 1}`, shown.flatMap(({ label: name, value, ...rest }, at) => [
    label(0, row * at + 12, name),
    shape("rect", { x: 0, y: row * at + 15, width: short(Math.max(0.5, right * value / most)), height: 8, class: `bar-${classOf(rest)}` }),
    label(right * value / most + 6, row * at + 23, `${compact(value)} ${unit}`)]));
  const parts = Array.from({ length: Math.ceil(rows.length / 40) }, (_, part) => ({ made: drawn(rows.slice(40 * part, 40 * part + 40), 40 * part) }));
  main.append(chartFigure(title, caption, ...parts));
}

function machineBars(main) {
  const rows = benchmarks.filter(({ percent }) => had(percent, newest))
    .map(({ name, of, percent }) => ({ label: name, value: percent[newest], of }));
  if (rows.length) bars(main, "Part of the machine's peak", "Blue: % of the peak of fused multiply-adds; orange: % of the bandwidth of " +
    `memory; both measured in the same run. Run ${runs[newest].name}.`, "%", rows, ({ of }) => of === "peak" ? "draw" : "again");
}

// Percentages of the peak travel between machines; times do not.
function trends(main) {
  if (runs.length < 2) return;
  const drawn = benchmarks.filter(({ percent }) => percent.some(value => !absent(value)));
  const alone = ({ name }) => drawn.filter(other => kindOf(other.name) === kindOf(name)).length === 1;
  const titleOf = benchmark => alone(benchmark) ? "others" : kindOf(benchmark.name);
  for (const kind of new Set(drawn.map(titleOf))) {
    const lines = drawn.filter(benchmark => titleOf(benchmark) === kind);
    main.append(chartFigure(`Trend: ${kind}`, "% of the machine's peak or bandwidth, from run to run.", plot({ title: `Trend: ${kind}`,
      x: { names: runs.map(({ name }) => name) }, y: { text: "%", zero: true }, marks: lines.map(({ name, percent }, at) =>
        ({ name: plain(name), class: classes[at % classes.length], dots: true, line: percent.map((value, run) => [run, value ?? NaN]).filter(([, value]) => !Number.isNaN(value)) })) })));
  }
}

function peers(main) {
  const run = runs.findLast(({ peers }) => peers.length > 0);
  if (run === undefined) return;
  bars(main, "Compared with peers", `Ours over theirs in run ${run.name}: above 1 is more work in the same time; for memory, below 1 is less.`,
    "ratio", run.peers.map(({ what, ratio }) => ({ label: what, value: ratio })), () => "draw");
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
