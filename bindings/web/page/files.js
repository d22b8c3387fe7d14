// Files and folders that are dropped or chosen: finds the recordings among them, and reads them.

let largestCount = 1000, largestBytes = 500e6;  // docs/guide/web.md states them

// Names that the program cannot take for options, each one once.
function namesOf(files) {
  const taken = new Set();
  return files.map(({ name }) => {
    const safe = name.startsWith("-") ? "./" + name : name, dot = name.lastIndexOf(".");
    const end = dot > 0 ? name.slice(dot) : "", stem = safe.slice(0, safe.length - end.length);
    let own = safe;
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
const isHidden = name => name.split("/").slice(1).some(part => part.startsWith("."));  // below the folder that was dropped
const isRecording = name => at("files").accept.split(",").some(ending => name.toLowerCase().endsWith(ending));

// Returns the dropped files as {name, read} and the folders as {name, files}. Call it in the event's handler: the
// browser clears the items when the handler returns.
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

// Adds the recordings of a folder to `found`. Throws Error if it cannot be read or holds none.
async function addFolder({ name, files }, found, isCurrent) {
  const before = found.length;
  try {
    for await (const file of files()) {
      if (!isCurrent() || found.length > largestCount) return;
      if (!isHidden(file.name) && isRecording(file.name)) found.push(file);
    }
  } catch (error) {
    throw new Error(`${name}: the browser does not read this folder (${error.name}); drop the files in it instead`);
  }
  found.push(...found.splice(before).sort((a, b) => a.name < b.name ? -1 : 1));
  if (found.length === before)
    throw new Error(`${name}: the folder holds no recording; their names end in ${at("files").accept.replaceAll(",", ", ")}`);
}

// Files as {name, content}. Throws Error if they are too many or too large.
async function readAll(found, isCurrent) {
  if (found.length > largestCount) throw new Error(`more than ${largestCount} recordings; choose fewer at a time`);
  const read = [];
  let sum = 0;
  for (const { name, read: open } of found) {
    if (!isCurrent()) return [];
    let content = null;
    try {
      const file = await open();
      sum += file.size;
      if (sum <= largestBytes) content = await file.arrayBuffer();
    } catch (error) {
      notes.push(`${name}: the browser does not read this file (${error.name}); choose it again, or the files in it if it is a folder`);
      continue;
    }
    if (content === null) throw new Error(`these files hold more than ${largestBytes / 1e6} MB; choose fewer at a time`);
    read.push({ name, content });
  }
  return read;
}
