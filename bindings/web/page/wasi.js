// The system that the program finds in a page: WASI preview 1 (https://github.com/WebAssembly/WASI), as much of it as the
// program asks for. Files are bytes in memory, in one folder; there is no network to ask for. Standard error is a
// terminal, so that the program shows how far it is.
"use strict";

const ok = 0, badf = 8, exist = 20, inval = 28, noent = 44, nosys = 52, notdir = 54;
const directory = 3, regular_file = 4, character_device = 2;

class Exit extends Error {
  constructor(code) {
    super("exit " + code);
    this.code = code;
  }
}

// Runs `module` with these arguments. files: a Map of paths to Uint8Arrays, to which what is written is added.
// hear(descriptor, text): of standard output (1) and error (2). Returns the exit code.
function runWasi(module, args, environment, files, hear) {
  let memory;
  const view = () => new DataView(memory.buffer);
  const bytes = (at, count) => new Uint8Array(memory.buffer, at, count);
  const text = (at, count) => new TextDecoder().decode(bytes(at, count));
  const plain = path => path.replace(/^(\.?\/)+/, "").replace(/\/$/, "");
  const numbers = new Map();  // of files: what tells one from another
  const numberOf = name => numbers.get(name) ?? numbers.set(name, numbers.size + 1).get(name);
  const decoders = { 1: new TextDecoder(), 2: new TextDecoder() };
  const isFolder = name => name === "" || name === "." || [...files.keys()].some(file => file.startsWith(name + "/"));
  // Descriptors: 0 to 2, the two folders, which are one, then files {name, at, append}.
  const open = [{ device: 0 }, { device: 1 }, { device: 2 }, { folder: "/" }, { folder: "." }];

  const put64 = (at, value) => view().setBigUint64(at, BigInt(value), true);
  const put32 = (at, value) => view().setUint32(at, value, true);
  function putStatus(at, type, name, size) {
    bytes(at, 64).fill(0);
    put64(at + 8, numberOf(name));
    view().setUint8(at + 16, type);
    put64(at + 24, 1);
    put64(at + 32, size);
  }
  function putStrings(strings, pointers, buffer) {
    for (const string of strings) {
      put32(pointers, buffer);
      pointers += 4;
      const encoded = new TextEncoder().encode(string + "\0");
      bytes(buffer, encoded.length).set(encoded);
      buffer += encoded.length;
    }
    return ok;
  }
  function putSizes(strings, count, size) {
    put32(count, strings.length);
    put32(size, strings.reduce((sum, string) => sum + new TextEncoder().encode(string).length + 1, 0));
    return ok;
  }
  function* pieces(vectors, count) {
    for (let i = 0; i < count; ++i) yield bytes(view().getUint32(vectors + 8 * i, true), view().getUint32(vectors + 8 * i + 4, true));
  }
  // Grows by halves: a file is written in many pieces.
  const contents = new Map();  // of files that are being written: {bytes, size}
  function put(name, at, piece) {
    const content = contents.get(name) ?? contents.set(name, { bytes: files.get(name), size: files.get(name).length }).get(name);
    const end = at + piece.length;
    if (end > content.bytes.length) {
      const larger = new Uint8Array(Math.max(end, content.bytes.length * 1.5 | 0));
      larger.set(content.bytes.subarray(0, content.size));
      content.bytes = larger;
    }
    content.bytes.set(piece, at);
    content.size = Math.max(content.size, end);
    files.set(name, content.bytes.subarray(0, content.size));
  }
  function read(file, at, vectors, count, result) {
    let sum = 0;
    for (const piece of pieces(vectors, count)) {
      const part = files.get(file.name).subarray(at + sum, at + sum + piece.length);
      piece.set(part);
      sum += part.length;
    }
    put32(result, sum);
    return sum;
  }
  function write(file, at, vectors, count, written) {
    let sum = 0;
    for (const piece of pieces(vectors, count)) {
      if (file.device !== undefined) hear(file.device, decoders[file.device].decode(piece, { stream: true }));
      else put(file.name, at + sum, piece);
      sum += piece.length;
    }
    put32(written, sum);
    return sum;
  }

  const calls = {
    args_get: (pointers, buffer) => putStrings(args, pointers, buffer),
    args_sizes_get: (count, size) => putSizes(args, count, size),
    environ_get: (pointers, buffer) => putStrings(environment, pointers, buffer),
    environ_sizes_get: (count, size) => putSizes(environment, count, size),
    clock_time_get(clock, precision, result) {
      put64(result, Math.round((clock === 0 ? Date.now() : performance.now()) * 1e6));
      return ok;
    },
    fd_close(fd) {
      if (!open[fd]) return badf;
      open[fd] = undefined;
      return ok;
    },
    fd_fdstat_get(fd, result) {
      const file = open[fd];
      if (!file) return badf;
      bytes(result, 24).fill(0);
      view().setUint8(result, file.folder ? directory : file.device !== undefined ? character_device : regular_file);
      if (file.append) view().setUint16(result + 2, 1, true);
      // A terminal is a device that cannot be searched.
      view().setBigUint64(result + 8, file.device !== undefined ? 0x1fffffffn & ~0x24n : 0x1fffffffn, true);
      view().setBigUint64(result + 16, 0x1fffffffn, true);
      return ok;
    },
    fd_fdstat_set_flags: () => ok,
    fd_filestat_get(fd, result) {
      const file = open[fd];
      if (!file) return badf;
      if (file.name !== undefined) putStatus(result, regular_file, file.name, files.get(file.name).length);
      else putStatus(result, file.folder ? directory : character_device, file.folder ? "" : "/dev/" + fd, 0);
      return ok;
    },
    fd_filestat_set_size(fd, size) {
      const name = open[fd]?.name;
      if (name === undefined) return badf;
      const resized = new Uint8Array(Number(size));
      resized.set(files.get(name).subarray(0, resized.length));
      files.set(name, resized);
      contents.delete(name);
      return ok;
    },
    fd_pread(fd, vectors, count, offset, result) {
      if (open[fd]?.name === undefined) return badf;
      read(open[fd], Number(offset), vectors, count, result);
      return ok;
    },
    fd_prestat_get(fd, result) {
      if (!open[fd]?.folder || fd > 4) return badf;
      put32(result, 0);
      put32(result + 4, open[fd].folder.length);
      return ok;
    },
    fd_prestat_dir_name(fd, buffer, size) {
      bytes(buffer, size).set(new TextEncoder().encode(open[fd].folder));
      return ok;
    },
    fd_read(fd, vectors, count, result) {
      const file = open[fd];
      if (!file) return badf;
      if (file.name === undefined) put32(result, 0);
      else file.at += read(file, file.at, vectors, count, result);
      return ok;
    },
    fd_readdir(fd, buffer, size, cookie, result) {
      put32(result, 0);
      return open[fd]?.folder ? ok : badf;
    },
    fd_seek(fd, offset, from, result) {
      const file = open[fd];
      if (file?.name === undefined) return badf;
      file.at = Number(offset) + [0, file.at, files.get(file.name).length][from];
      put64(result, file.at);
      return ok;
    },
    fd_sync: () => ok,
    fd_pwrite(fd, vectors, count, offset, written) {
      if (open[fd]?.name === undefined) return badf;
      write(open[fd], Number(offset), vectors, count, written);
      return ok;
    },
    fd_write(fd, vectors, count, written) {
      const file = open[fd];
      if (!file || file.folder) return badf;
      if (file.append) file.at = files.get(file.name).length;
      file.at += write(file, file.at, vectors, count, written);
      return ok;
    },
    path_create_directory: () => nosys,
    path_filestat_get(fd, follow, path, size, result) {
      const name = plain(text(path, size));
      if (files.has(name)) putStatus(result, regular_file, name, files.get(name).length);
      else if (isFolder(name)) putStatus(result, directory, "", 0);
      else return noent;
      return ok;
    },
    path_open(fd, follow, path, size, how, rights, inheriting, flags, result) {
      const name = plain(text(path, size));
      const create = how & 1, folder = how & 2, exclusive = how & 4, truncate = how & 8;
      if (!files.has(name) && isFolder(name)) {
        put32(result, open.push({ folder: name || "." }) - 1);
        return ok;
      }
      if (folder) return files.has(name) ? notdir : noent;
      if (files.has(name) && create && exclusive) return exist;
      if (!files.has(name) && !create) return noent;
      if (!files.has(name) || truncate) {
        files.set(name, new Uint8Array(0));
        contents.delete(name);
      }
      put32(result, open.push({ name, at: 0, append: (flags & 1) !== 0 }) - 1);
      return ok;
    },
    path_readlink: () => inval,
    path_remove_directory: () => nosys,
    path_rename(fd, path, size, to, toPath, toSize) {
      const name = plain(text(path, size)), target = plain(text(toPath, toSize));
      if (!files.has(name)) return noent;
      files.set(target, files.get(name));
      files.delete(name);
      contents.delete(name);
      contents.delete(target);
      for (const file of open) if (file?.name === name) file.name = target;
      return ok;
    },
    path_unlink_file(fd, path, size) {
      contents.delete(plain(text(path, size)));
      return files.delete(plain(text(path, size))) ? ok : noent;
    },
    proc_exit(code) {
      throw new Exit(code);
    },
  };

  const instance = new WebAssembly.Instance(module, { wasi_snapshot_preview1: calls });
  memory = instance.exports.memory;
  try {
    instance.exports._start();
    return 0;
  } catch (error) {
    if (error instanceof Exit) return error.code;
    throw error;
  }
}
