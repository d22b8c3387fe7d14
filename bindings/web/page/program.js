// The program in the page: unpacks it, has the worker run it, and sees to it that there is one task at a time.
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

// Applies the changes that changes() of pack.py found to `base`.
function changed(base, changes) {
  let at = 0;
  const number = () => {
    let value = 0;
    for (let unit = 1, more = true; more; unit *= 128) {
      more = changes[at] > 127;
      value += (changes[at++] & 127) * unit;
    }
    return value;
  };
  const result = new Uint8Array(number());
  for (let to = 0; to < result.length;) {
    const added = number();
    result.set(changes.subarray(at, at + added), to);
    at += added;
    to += added;
    const place = number(), count = number();
    for (let i = 0; i < count; ++i) result[to + i] = base[place + i] + changes[at + i];
    at += count;
    to += count;
  }
  return result;
}

// Returns true if this processor rounds a relaxed multiply-add once. The probe's results differ if it rounds the product
// first.
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
  const own = new Uint8Array(await unpacked("relaxed"));
  const module = await WebAssembly.compile(relaxed ? own : changed(own, new Uint8Array(await unpacked("plain"))));
  at("plain")?.remove();
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
  working = { command, state: state(command) };
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
