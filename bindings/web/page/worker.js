// The worker that computes: one run of the program a message {args, files}, {out, errors, code, files} in return, on the
// way {progress}. A run is stopped by ending the worker.
"use strict";

let program;  // {module, model, environment}
self.onmessage = ({ data }) => {
  if (data.module) {
    program = data;
    return;
  }
  const files = new Map([["decid/built_in.safetensors", program.model], ...data.files]);
  const before = new Set(files.keys());
  const said = { 1: "", 2: "" };
  const hear = (descriptor, text) => {
    said[descriptor] += text;
    if (descriptor === 2 && text.includes("\r")) self.postMessage({ progress: text.slice(text.lastIndexOf("\r") + 1) });
  };
  try {
    const code = runWasi(program.module, ["decid", ...data.args], program.environment, files, hear);
    // Lines of progress end where they began.
    const errors = said[2].split("\n").map(line => line.slice(line.lastIndexOf("\r") + 1)).filter(line => line !== "");
    self.postMessage({ code, out: said[1], errors, files: [...files].filter(([name]) => !before.has(name)) });
  } catch (error) {
    self.postMessage({ code: 1, out: "", errors: ["decid: stopped: " + error.message], files: [] });
  }
};
