// The page: takes recordings, has the worker run the program on them, and shows the report that it writes. Text of files
// and of the program goes in through textContent only; the report stands in a frame that may do nothing but draw itself.
"use strict";

const at = id => document.getElementById(id);
const blame = message => { document.body.dataset.error = String(message); };
window.addEventListener("error", event => blame(event.message));
window.addEventListener("unhandledrejection", event => blame(event.reason));
// The policy above refuses to load anything; where the browser asks, leaving for another page is refused too.
window.navigation?.addEventListener("navigate", event => {
  if (event.cancelable && !event.hashChange && event.downloadRequest === null && event.navigationType !== "reload") event.preventDefault();
});

// ---- the program ---------------------------------------------------------------------------------------------------

// Five characters are four bytes; what lacks at the end is as if it were the last digit. pack.py writes it.
function fromBase85(text) {
  const digits = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz!#$%&()*+-;,=>?@^_`{|}~";
  const values = new Uint8Array(128);
  for (let i = 0; i < digits.length; ++i) values[digits.charCodeAt(i)] = i;
  const groups = Math.ceil(text.length / 5), words = new DataView(new ArrayBuffer(4 * groups));
  for (let group = 0, at = 0; group < groups; ++group) {
    let word = 0;
    for (let i = 0; i < 5; ++i, ++at) word = word * 85 + (at < text.length ? values[text.charCodeAt(at)] : 84);
    words.setUint32(4 * group, word);
  }
  return new Uint8Array(words.buffer, 0, Math.floor(text.length / 5) * 4 + Math.max(text.length % 5 - 1, 0));
}

const unpacked = async id => {
  const packed = fromBase85(at(id).textContent);
  at(id).remove();
  return new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
};

// Bytes 0, 4, 8 ..., then 1, 5, 9 ...: pack.py has put them apart.
function together(apart) {
  const bytes = new Uint8Array(apart.length);
  for (let first = 0, from = 0; first < 4; ++first)
    for (let at = first; at < bytes.length; at += 4) bytes[at] = apart[from++];
  return bytes;
}

// Whether relaxed multiply-adds are one rounding here: where the product is rounded first, these differ.
async function fuses() {
  const bytes = await unpacked("probe");
  if (!WebAssembly.validate(bytes)) return false;
  const { doubles, floats } = new WebAssembly.Instance(new WebAssembly.Module(bytes)).exports;
  const holds = (multiply_add, e) => multiply_add(1 + e, 1 - e, -1) === -e * e && multiply_add(1 - e, -1 - e, 1) === e * e &&
    multiply_add(1 + e, 1 + e, -1 - 2 * e) === e * e && multiply_add(3, 1 / 3, -1) !== undefined;
  return holds(doubles, 2 ** -30) && holds(floats, 2 ** -13);
}

const workerAddress = URL.createObjectURL(new Blob([at("worker").textContent], { type: "text/javascript" }));
const program = (async () => {
  const relaxed = location.hash !== "#plain" && await fuses();
  document.body.dataset.kernels = relaxed ? "relaxed" : "wasm";
  const module = await WebAssembly.compile(await unpacked(relaxed ? "relaxed" : "plain"));
  at(relaxed ? "plain" : "relaxed").remove();
  return { module, model: together(new Uint8Array(await unpacked("model"))), environment: [] };
})();

let worker;
async function startWorker() {
  worker = new Worker(workerAddress);
  worker.postMessage(await program);
}
const ready = startWorker().then(() => { document.body.dataset.ready = "yes"; });

// Runs the program; what it says is {code, out, errors, files}. Null if it was cancelled.
let stop = null;
async function run(args, files) {
  await ready;
  return new Promise(resolve => {
    worker.onmessage = ({ data }) => data.progress === undefined ? resolve(data) : showProgress(data.progress);
    worker.onerror = event => resolve({ code: 1, out: "", errors: ["decid: " + event.message], files: [] });
    stop = () => {
      worker.terminate();
      startWorker();
      resolve(null);
    };
    worker.postMessage({ args, files });
  });
}

// ---- recordings ----------------------------------------------------------------------------------------------------

let recordings = [];  // [name, bytes]
let results = new Map();
let shown = "identify";

// Names that the program cannot take for options, each one once.
function namesOf(files) {
  const taken = new Set();
  return files.map(({ name }) => {
    const dot = name.lastIndexOf("."), stem = dot > 0 ? name.slice(0, dot) : name, end = dot > 0 ? name.slice(dot) : "";
    let own = name.startsWith("-") ? "./" + name : name;
    for (let i = 2; taken.has(own); ++i) own = `${stem} (${i})${end}`;
    taken.add(own);
    return own;
  });
}

async function take(files) {
  if (files.length === 0) return;
  const names = namesOf(files);
  const contents = await Promise.all(files.map(file => file.arrayBuffer()));
  recordings = contents.map((content, i) => [names[i], new Uint8Array(content)]);
  await compute("identify");
}

// A number as people write it, with a point or a comma, or null. The page reads it itself: a browser's field for numbers
// makes 455 of "45,5", or nothing of "76,5", by the language of its menus.
function numberIn(text) {
  const found = text.match(/^[+-]?([0-9]+([.,][0-9]*)?|[.,][0-9]+)$/);
  return found ? text.replace(",", ".") : null;
}

// The options that the fields say, or null if a field that wants a number has none: it is named, and has the focus.
function optionsOf() {
  const options = [];
  let wrong = null;
  for (const id of ["mass", "height", "column", "unit", "com-height", "rate", "tilt-column", "begin", "detrend", "invert", "fill-gaps"]) {
    const field = at(id), text = field.value.trim();
    const value = field.className === "number" && text !== "" ? numberIn(text) : text;
    field.setAttribute("aria-invalid", String(value === null));
    if (value === null) wrong ??= field;
    else if (value !== "") options.push("--" + id, value);
  }
  if (wrong === null) return options;
  if (at("setup").hidden) showSetup();
  say([`${wrong.parentElement.firstChild.textContent.trim()}: "${wrong.value.trim()}" is no number; correct it, and give the recordings again`]);
  at("files").value = "";
  const folded = wrong.closest("details");
  if (folded) folded.open = true;
  wrong.focus();
  return null;
}

const counted = count => count === 1 ? "1 recording" : `${count} recordings`;
const outputs = { json: "decid/result.json", html: "decid/report.html", csv: "decid/table.csv" };

async function compute(command) {
  const names = recordings.map(([name]) => name);
  const options = optionsOf();
  document.body.dataset.refused = String(options === null);
  if (options === null) return;
  say([]);
  busy(command === "fit" ? `Fitting ${counted(names.length)}, about a minute each` : `Identifying ${counted(names.length)}`);
  const started = performance.now();
  const said = await run([command, ...names, ...options, "-o", outputs.json, "--report", outputs.html, "--table", outputs.csv], recordings);
  busy(null);
  if (said === null) return;
  say(said.errors.map(line => line.replace(/^decid: /, "")));
  const files = new Map(said.files);
  document.body.dataset.done = `${command} ${said.code}`;
  if (!files.has(outputs.html)) return;
  results = files;
  shown = command;
  show(names);
  document.body.dataset.seconds = ((performance.now() - started) / 1000).toFixed(2);
}

// ---- what is seen --------------------------------------------------------------------------------------------------

function say(lines) {
  at("problems").hidden = lines.length === 0;
  at("problems").textContent = lines.join("\n");
}

function busy(what) {
  at("work").hidden = what === null;
  at("status").textContent = what ?? "";
  at("progress").removeAttribute("value");
  for (const button of document.querySelectorAll("button:not(#cancel)")) button.disabled = what !== null;
}

function showProgress(line) {
  const found = line.match(/([0-9.]+) of ([0-9]+)/);
  if (found) at("progress").value = Number(found[1]) / Number(found[2]);
  const text = line.replace(/\[[#.]*\] /, "").trim();
  if (text !== "") at("status").textContent = text;
}

let reportAddress = null;
function show(names) {
  const title = names.length === 1 ? names[0] : counted(names.length);
  at("bar-title").textContent = (shown === "fit" ? "Posterior of " : "") + title;
  // From here the frame cannot be reached: the report prints itself, and says when it is drawn (tools/report/common.js).
  if (reportAddress !== null) URL.revokeObjectURL(reportAddress);
  reportAddress = URL.createObjectURL(new Blob([results.get(outputs.html)], { type: "text/html" }));
  at("report").src = reportAddress;
  at("report").title = "Report of " + title;
  for (const id of ["bar", "report"]) at(id).hidden = false;
  at("setup").hidden = true;
  document.body.classList.add("answered");
  at("fit").hidden = shown === "fit";
  at("bar-title").focus();
}

function showSetup() {
  for (const id of ["bar", "report"]) at(id).hidden = true;
  at("setup").hidden = false;
  document.body.classList.remove("answered");
  say([]);
  at("files").value = "";
  at("files").focus();
}

function save(kind, type) {
  const stem = recordings.length === 1 ? recordings[0][0].replace(/^.*\//, "").replace(/\.[^.]*$/, "") : "recordings";
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([results.get(outputs[kind])], { type }));
  link.download = `${stem}-${shown}.${kind}`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}

addEventListener("message", event => {
  if (event.source === at("report").contentWindow) document.body.dataset.report = String(event.data);
});

// ---- what is done --------------------------------------------------------------------------------------------------

at("files").addEventListener("change", event => take([...event.target.files]));
document.addEventListener("dragover", event => {
  event.preventDefault();
  at("drop").classList.add("over");
});
for (const kind of ["dragleave", "drop"]) document.addEventListener(kind, () => at("drop").classList.remove("over"));
document.addEventListener("drop", event => {
  event.preventDefault();
  if (at("work").hidden) take([...event.dataTransfer.files]);
});
at("identify-pasted").addEventListener("click", () => take([new File([at("pasted").value], "pasted.csv")]));
at("example").addEventListener("click", async () => {
  busy("Simulating a recording");
  const said = await run(["simulate", "--seed", "3", "-o", "simulated.csv"], []);
  busy(null);
  if (said !== null) take(said.files.map(([name, bytes]) => new File([bytes], name)));
});
at("fit").addEventListener("click", () => compute("fit"));
at("again").addEventListener("click", showSetup);
at("cancel").addEventListener("click", () => stop?.());
at("save-json").addEventListener("click", () => save("json", "application/json"));
at("save-csv").addEventListener("click", () => save("csv", "text/csv"));
at("save-html").addEventListener("click", () => save("html", "text/html"));
at("print").addEventListener("click", () => at("report").contentWindow.postMessage("print", "*"));
