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

// The number of bytes, a blank, then eleven digits for nine bytes. pack.py writes it.
function fromBase94(text) {
  const begin = text.indexOf(" ") + 1, count = Number(text.slice(0, begin)), bytes = new Uint8Array(9 * Math.ceil(count / 9));
  for (let at = begin, to = 0; to < bytes.length; to += 9) {
    let high = 0, middle = 0, low = 0;  // 24 bits each
    for (const end = at + 11; at < end; ++at) {
      const code = text.charCodeAt(at);
      low = low * 94 + code - (code > 60 ? 33 : 32);
      middle = middle * 94 + (low >>> 24);
      high = high * 94 + (middle >>> 24);
      low &= 0xffffff;
      middle &= 0xffffff;
    }
    [high, middle, low].forEach((limb, i) => bytes.set([limb >>> 16, limb >>> 8 & 255, limb & 255], to + 3 * i));
  }
  return bytes.subarray(0, count);
}

const unpacked = async id => {
  const packed = fromBase94(at(id).textContent);
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

// ---- one task at a time --------------------------------------------------------------------------------------------

let turn = 0;        // counts tasks, so that a task that another one replaced does not go on
let working = null;  // {command, state} of the task, null if there is none
let stop = null;     // ends its run of the program

function end() {
  ++turn;
  stop?.();
  stop = working = null;
  busy(null);
}

// Ends the task before it. Returns the number of the new one. command: null before there are recordings.
function begin(command, what) {
  end();
  working = { command, state: state() };
  busy(what);
  return turn;
}

// Returns false if another task has taken the place of this one.
function finish(mine) {
  if (mine !== turn) return false;
  stop = working = null;
  busy(null);
  return true;
}

// Runs the program for the present task; its outcome is {code, out, errors, files}. Null if the task ends before it.
async function run(args, files) {
  const mine = turn;
  await ready;
  if (mine !== turn) return null;
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

let largestCount = 1000, largestBytes = 500e6;  // docs/web.md states them
let recordings = [];   // [name, bytes]
let chosen = 0;        // counts choices of recordings
let notes = [];        // what was wrong with this choice
let overlooked = [];   // what was dropped during the task
let results = new Map();
let answered = null;  // {command, names, title, settings, state, messages} of the answer that is shown

const title = names => names.length === 1 ? names[0] : counted(names.length);
const counted = count => count === 1 ? "1 recording" : `${count} recordings`;

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

// The files in a folder and in its folders, as {name, read}. Chromium reads folders for a page that is a file only through
// handles; browsers that have no handles have entries.
async function* filesOfHandle(handle, name) {
  if (handle.kind === "file") yield { name, read: () => handle.getFile() };
  else for await (const inner of handle.values()) yield* filesOfHandle(inner, `${name}/${inner.name}`);
}
async function* filesOfEntry(entry, name) {
  if (entry.isFile) yield { name, read: () => new Promise((resolve, reject) => entry.file(resolve, reject)) };
  if (!entry.isDirectory) return;
  const reader = entry.createReader(), more = () => new Promise((resolve, reject) => reader.readEntries(resolve, reject));
  for (let some = await more(); some.length > 0; some = await more())
    for (const inner of some) yield* filesOfEntry(inner, `${name}/${inner.name}`);
}

const plainFiles = files => files.map(file => ({ name: file.name, read: async () => file }));
const isHidden = name => name.split("/").some(part => part.startsWith("."));
const isRecording = name => at("files").accept.split(",").some(ending => name.toLowerCase().endsWith(ending));

// What a drop holds: {name, read} of a file, {name, files} of a folder. The event's items are gone after it.
function droppedOn(transfer) {
  return [...transfer.items].filter(({ kind }) => kind === "file").flatMap(item => {
    const entry = item.webkitGetAsEntry?.();
    if (!entry?.isDirectory) return plainFiles([item.getAsFile()].filter(file => file !== null));
    const handle = item.getAsFileSystemHandle?.();
    return [{ name: entry.name, files: async function* () {
      if (handle) yield* filesOfHandle(await handle, entry.name);
      else yield* filesOfEntry(entry, entry.name);
    } }];
  });
}

// Adds the recordings of a folder to `found`. Throws a text if it cannot be read or holds none.
async function addFolder({ name, files }, found, isCurrent) {
  const before = found.length;
  try {
    for await (const file of files()) {
      if (!isCurrent() || found.length > largestCount) return;
      if (!isHidden(file.name) && isRecording(file.name)) found.push(file);
    }
  } catch (error) {
    throw `${name}: the browser does not read this folder (${error.name}); drop the files in it instead`;
  }
  found.push(...found.splice(before).sort((a, b) => a.name < b.name ? -1 : 1));
  if (found.length === before) throw `${name}: the folder holds no recording; their names end in ${at("files").accept.replaceAll(",", ", ")}`;
}

async function readAll(found) {
  const read = [];
  let sum = 0;
  for (const { name, read: open } of found) {
    let content = null;
    try {
      const file = await open();
      sum += file.size;
      if (sum <= largestBytes) content = await file.arrayBuffer();
    } catch (error) {
      notes.push(`${name}: the browser does not read this file (${error.name}); choose it again, or the files in it if it is a folder`);
      continue;
    }
    if (content === null) throw `these files hold more than ${largestBytes / 1e6} MB; choose fewer at a time`;
    read.push({ name, content });
  }
  return read;
}

// Takes files and folders as the recordings, and answers them.
async function take(sources) {
  if (working) {
    overlooked = [`Not taken while the page computes: ${sources.map(({ name }) => name).join(", ")}. Cancel, or give it again afterwards`];
    return say([...notes, ...overlooked]);
  }
  if (sources.length === 0) return say(["That was no file: drop files or folders, or paste a table"]);
  const mine = begin(null, "Reading files"), found = [];
  notes = overlooked = [];
  say([]);
  let read = [];
  try {
    for (const source of sources) {
      if (!source.files) found.push(source);
      else await addFolder(source, found, () => mine === turn).catch(problem => notes.push(problem));
    }
    if (mine !== turn) return;
    if (found.length > largestCount) throw `more than ${largestCount} recordings; choose fewer at a time`;
    read = await readAll(found);
  } catch (problem) {
    if (typeof problem !== "string") throw problem;
    notes.push(problem);
    read = [];
  }
  if (!finish(mine)) return;
  document.body.dataset.taken = String(read.length);
  if (read.length === 0) return say([...notes, ...overlooked]);
  const names = namesOf(read);
  recordings = read.map(({ content }, i) => [names[i], new Uint8Array(content)]);
  ++chosen;
  await compute("identify");
}

// ---- settings ------------------------------------------------------------------------------------------------------

// A number as people write it, with a point or a comma, or null. The page reads it itself: a browser's field for numbers
// makes 455 of "45,5", or nothing of "76,5", by the language of its menus.
function numberIn(text) {
  const found = text.match(/^[+-]?([0-9]+([.,][0-9]*)?|[.,][0-9]+)$/);
  return found ? text.replace(",", ".") : null;
}

const fields = [...at("settings").querySelectorAll("input, select")];  // each is called after its option
const labelOf = field => field.parentElement.firstChild.textContent.trim();
const textOf = field => field.value.trim();
const given = () => fields.filter(field => textOf(field) !== "");
const isWrong = field => field.className === "number" && textOf(field) !== "" && numberIn(textOf(field)) === null;
const bodyIsHalf = () => (textOf(at("mass")) === "") !== (textOf(at("height")) === "");
const settingsText = () => given().map(field => `${labelOf(field)} ${textOf(field)}`).join("; ") || "no settings";
// What an answer is an answer to.
const state = () => JSON.stringify([chosen, fields.map(textOf)]);

// The options that the fields say, or null if a field that wants a number has none: it is named, and has the focus.
function optionsOf() {
  for (const field of fields) field.setAttribute("aria-invalid", String(isWrong(field)));
  const wrong = fields.find(isWrong);
  if (!wrong) return given().flatMap(field => ["--" + field.id, field.className === "number" ? numberIn(textOf(field)) : textOf(field)]);
  say([...notes, `${labelOf(wrong)}: "${textOf(wrong)}" is not a number; correct it, and the page answers`]);
  for (let around = wrong.closest("details"); around; around = around.parentElement.closest("details")) around.open = true;
  wrong.focus();
  return null;
}

// Options are names of the command line. The page's messages name its fields instead, and mark what only the program has.
// names: of files, which stay as they are.
function translator(names) {
  const files = names.map(name => name.replace(/[.*+?^${}()|[\]\\]/g, "\\$&"));
  const option = new RegExp([...files, "--([a-z][a-z-]*)"].join("|"), "g");
  return text => {
    const lacking = new Set();
    const translated = text.replace(/; see decid[a-z ]* --help$/, "").replace(option, (whole, name) => {
      if (name === undefined) return whole;
      const field = fields.find(({ id }) => id === name);
      if (!field) lacking.add(`\u2039${name}\u203a`);
      return field ? `\u201c${labelOf(field)}\u201d` : `\u2039${name}\u203a`;
    });
    return lacking.size === 0 ? translated : `${translated} (${[...lacking].join(", ")}: only in the program decid, not in this page)`;
  };
}

// A page keeps no files to go on with.
const messagesOf = (errors, names) =>
  errors.filter(line => !line.includes("--resume")).map(line => translator(names)(line.replace(/^decid: /, "")));

// The report as the page shows it. Its texts are JSON in it.
function shownReport(bytes, names) {
  const translate = translator(names);
  return new TextDecoder().decode(bytes).replace(/(<script type="application\/json"[^>]*>)([^<]*)/g, (block, tag, json) =>
    !json.includes("--") ? block : tag + JSON.stringify(JSON.parse(json, (_, value) =>
      typeof value === "string" && value.includes("--") ? translate(value) : value)).replaceAll("<", "\\u003c"));
}

// ---- answers -------------------------------------------------------------------------------------------------------

const outputs = { json: "decid/result.json", html: "decid/report.html", csv: "decid/table.csv" };

// goesOn: the settings are being changed, so that they keep the focus.
async function compute(command, goesOn = false) {
  const names = recordings.map(([name]) => name);
  const options = optionsOf();
  document.body.dataset.refused = String(options === null);
  if (options === null) return mark();
  say([...notes, ...overlooked]);
  const asked = { command, names, title: title(names), settings: settingsText(), state: state() };
  const mine = begin(command, command === "fit" ? `Fitting ${counted(names.length)}, about a minute each` : `Identifying ${counted(names.length)}`);
  mark();
  const started = performance.now();
  const outcome = await run([command, ...names, ...options, "-o", outputs.json, "--report", outputs.html, "--table", outputs.csv], recordings);
  if (!finish(mine)) return;
  asked.messages = [...notes, ...messagesOf(outcome.errors, names)];
  say([...asked.messages, ...overlooked]);
  const files = new Map(outcome.files);
  document.body.dataset.done = `${command} ${outcome.code}`;
  if (files.has(outputs.html)) {
    const stays = goesOn && answered !== null;
    results = files;
    answered = asked;
    show(stays);
  }
  mark();
  document.body.dataset.seconds = ((performance.now() - started) / 1000).toFixed(2);
}

// Answers the same recordings with settings that have changed.
function renew() {
  if (recordings.length === 0 || working?.command === null) return;
  overlooked = [];
  const isCurrent = (working ?? answered)?.state === state();
  if (isCurrent && !working) say(answered.messages);
  if (isCurrent || bodyIsHalf()) return mark();
  compute((working ?? answered)?.command ?? "identify", true);
}

// Says of an answer that is shown what it is an answer to, where that is no longer what is chosen.
function mark() {
  const stale = answered !== null && answered.state !== state();
  at("stale").hidden = !stale;
  if (!stale) return;
  at("stale-note").textContent = `An earlier answer: ${answered.title}, ${answered.settings}. ` +
    (working ? "The new one is being computed." : `Now chosen: ${title(recordings.map(([name]) => name))}, ${settingsText()}.` +
      (bodyIsHalf() ? " Give both mass and height." : ""));
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
function show(stays) {
  at("bar-title").textContent = (answered.command === "fit" ? "Posterior of " : "") + answered.title;
  // From here the frame cannot be reached: the report prints itself, and says when it is drawn (tools/report/common.js).
  if (reportAddress !== null) URL.revokeObjectURL(reportAddress);
  reportAddress = URL.createObjectURL(new Blob([shownReport(results.get(outputs.html), answered.names)], { type: "text/html" }));
  at("report").src = reportAddress;
  at("report").title = "Report of " + answered.title;
  for (const id of ["bar", "report"]) at(id).hidden = false;
  at("fit").hidden = answered.command === "fit";
  if (stays) return;
  if (!document.body.classList.contains("answered")) at("settings").open = false;
  document.body.classList.add("answered");
  at("bar-title").focus();
}

// Shows the place to drop files again, above the answer.
function showSetup() {
  document.body.classList.remove("answered");
  at("settings").open = true;
  at("files").value = "";
  at("files").focus();
}

function save(kind, type) {
  const stem = answered.names.length === 1 ? answered.names[0].replace(/^.*\//, "").replace(/\.[^.]*$/, "") : "recordings";
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([results.get(outputs[kind])], { type }));
  link.download = `${stem}-${answered.command}.${kind}`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}

addEventListener("message", event => {
  if (event.source === at("report").contentWindow) document.body.dataset.report = String(event.data);
});

// ---- what is done --------------------------------------------------------------------------------------------------

at("files").addEventListener("change", event => take(plainFiles([...event.target.files])));
document.addEventListener("dragover", event => {
  event.preventDefault();
  at("drop").classList.add("over");
});
for (const kind of ["dragleave", "drop"]) document.addEventListener(kind, () => at("drop").classList.remove("over"));
document.addEventListener("drop", event => {
  event.preventDefault();
  take(droppedOn(event.dataTransfer));
});
at("settings").addEventListener("input", mark);
at("settings").addEventListener("change", renew);
at("renew").addEventListener("click", renew);
at("identify-pasted").addEventListener("click", () => take(plainFiles([new File([at("pasted").value], "pasted.csv")])));
at("example").addEventListener("click", async () => {
  const mine = begin(null, "Simulating a recording");
  const outcome = await run(["simulate", "--seed", "3", "-o", "simulated.csv"], []);
  if (finish(mine)) take(plainFiles(outcome.files.map(([name, bytes]) => new File([bytes], name))));
});
at("fit").addEventListener("click", () => {
  overlooked = [];
  compute("fit");
});
at("again").addEventListener("click", showSetup);
at("cancel").addEventListener("click", () => {
  end();
  mark();
});
at("save-json").addEventListener("click", () => save("json", "application/json"));
at("save-csv").addEventListener("click", () => save("csv", "text/csv"));
at("save-html").addEventListener("click", () => save("html", "text/html"));
at("print").addEventListener("click", () => at("report").contentWindow.postMessage("print", "*"));
