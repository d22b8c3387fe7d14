// The page: takes recordings, has the worker run the program on them, and shows the report that it writes. Text of files
// and of the program goes in through textContent only; the report stands in a frame that may do nothing but draw itself.

// ---- recordings ----------------------------------------------------------------------------------------------------

let recordings = [];   // [name, bytes]
let chosen = 0;        // counts choices of recordings
let notes = [];        // what was wrong with this choice
let overlooked = [];   // what was dropped during the task
let results = new Map();
let answered = null;  // {command, names, title, settings, state, messages} of the answer that is shown

const title = names => names.length === 1 ? names[0] : counted(names.length);
const counted = count => count === 1 ? "1 recording" : `${count} recordings`;

// Takes files and folders as the recordings, and answers them.
async function take(sources) {
  if (sources.length === 0) return say([...notes, "No file was dropped: drop files or folders, or paste a table"]);
  if (working) {
    overlooked = [`Not taken during an analysis: ${title(sources.map(({ name }) => name))}. Cancel, or drop it again afterwards`];
    return say([...notes, ...overlooked]);
  }
  const mine = begin(null, "Reading files"), found = [];
  notes = [];
  overlooked = [];
  say([]);
  for (const source of sources) {
    if (source.files) await addFolder(source, found, () => mine === turn).catch(problem => notes.push(problem.message));
    else found.push(source);
  }
  const read = await readAll(found, () => mine === turn).catch(problem => {
    notes.push(problem.message);
    return [];
  });
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
const actsOn = (field, command) => field.id !== "controller" || command === "fit";  // the network is of one controller
const given = command => fields.filter(field => textOf(field) !== "" && actsOn(field, command));
const isWrong = field => field.className === "number" && textOf(field) !== "" && numberIn(textOf(field)) === null;
const bodyIsHalf = () => (textOf(at("mass")) === "") !== (textOf(at("height")) === "");
const settingsText = command => given(command).map(field => `${labelOf(field)} ${textOf(field)}`).join("; ") || "no settings";
// Identifies the recordings and settings of a command's answer; the page compares it to see whether an answer is out of date.
const state = command => JSON.stringify([chosen, given(command).map(field => [field.id, textOf(field)])]);
// The time of a detailed analysis of a recording with the chosen controller.
const fitTime = () => `about ${at("controller").selectedOptions[0].dataset.minutes} min`;

// The options of a command that the fields say, or null if a field that wants a number has none: it is named, and has the focus.
function optionsOf(command) {
  for (const field of fields) field.setAttribute("aria-invalid", String(isWrong(field)));
  const wrong = fields.find(isWrong);
  if (!wrong) return given(command).flatMap(field => ["--" + field.id, field.className === "number" ? numberIn(textOf(field)) : textOf(field)]);
  say([...notes, `${labelOf(wrong)}: "${textOf(wrong)}" is not a number. Correct it, and the page analyses again`]);
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

// A page keeps no files to continue.
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
  const options = optionsOf(command);
  document.body.dataset.refused = String(options === null);
  if (options === null) return mark();
  say([...notes, ...overlooked]);
  const asked = { command, names, title: title(names), settings: settingsText(command), state: state(command) };
  const mine = begin(command, `Analysing ${counted(names.length)}` + (command === "fit" ? `: ${fitTime()} each` : ""));
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
  const command = (working ?? answered)?.command ?? "identify";
  const isCurrent = (working ?? answered)?.state === state(command);
  if (isCurrent && !working) say(answered.messages);
  if (isCurrent || bodyIsHalf()) return mark();
  compute(command, true);
}

// Names the settings of the shown result where they differ from the current choice.
function mark() {
  const stale = answered !== null && answered.state !== state(answered.command);
  at("stale").hidden = !stale;
  if (!stale) return;
  at("stale-note").textContent = `Earlier result: ${answered.title}, ${answered.settings}. ` +
    (working ? "The page computes the new result." : `Now chosen: ${title(recordings.map(([name]) => name))}, ${settingsText(answered.command)}.` +
      (bodyIsHalf() ? " Give both weight and height." : ""));
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
  const found = line.match(/([0-9.]+)(?:%| of ([0-9]+))/);
  if (!found) {
    if (line.trim() !== "") at("status").textContent = line.trim();
    return;
  }
  const part = Number(found[1]) / Number(found[2] ?? 100), left = line.match(/(?:about )?([0-9][0-9a-z ]*) left/);
  at("progress").value = part;
  at("status").textContent = `Analysing: ${Math.round(100 * part)}%` + (left ? `, about ${left[1]} left` : "");
}

let reportAddress = null;
function show(stays) {
  at("bar-title").textContent = (answered.command === "fit" ? "Detailed analysis of " : "") + answered.title;
  // From here the frame cannot be reached: the report prints itself, and says when it is drawn (tools/report/page/common.js).
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

// The button states the time of the chosen controller.
function nameFit() {
  at("fit").textContent = `Detailed analysis (${fitTime()})`;
}

// Shows the place to drop files again, above the answer.
function showSetup() {
  document.body.classList.remove("answered");
  at("settings").open = true;
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

at("files").addEventListener("change", event => {
  const files = [...event.target.files];
  event.target.value = "";  // so that the same file can be chosen again
  if (files.length > 0) take(plainFiles(files));
});
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
at("controller").addEventListener("change", nameFit);
addEventListener("pageshow", nameFit);  // browsers restore fields after the script
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
