#!/usr/bin/env python3
"""Makes each call that a command asks of the system fail once, in turn, and checks what is left.

    tests/faults/faults.py DECID LIBRARY [--stride N] [--only COMMAND] [--function NAME]

A command whose call failed ends with one line that begins "decid: " and exit code 2, or 1 if a disk or memory failed, or
does without the call and makes the same bytes. It leaves no temporary file, and every output is what it was before or what it should become. The
same command again, undisturbed, makes the bytes that an undisturbed one makes. Two things are let pass where memory is
missing: a temporary or lock file left behind, since libgomp ends the program where it gets none; and what matio leaves out
of a version 7.3 file, since it does not report that it had no memory. --stride: only every Nth call of each
function, of allocations every (50 N)th. LIBRARY: faults.c, compiled.
"""
import argparse
import errno
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

ERRNO = {"open": errno.EMFILE, "fopen": errno.EMFILE, "allocate": errno.ENOMEM, "write": errno.ENOSPC, "pwritev": errno.EDQUOT,
         "fork": errno.EAGAIN, "pipe": errno.EMFILE, "flock": errno.ENOLCK, "rename": errno.EROFS, "mkdir": errno.EROFS}
PROTOCOL = {"name": "tiny", "sequence": {"feedback": [0, 0, -1, 1], "start": [0, 0, 0, 1], "state_s": 0.05,
                                         "amplitude_deg": 1, "offset_s": 0, "cycles": 1}, "sample_rate_hz": 20}
# Files as written, compared by their first bytes or as a whole, without a result's run time.
EPOCH_1 = b",0.05"  # the log of one epoch ends with its learning rate
TIMES = re.compile(rb'"(seconds|simulations)": [-+.e0-9]+')

MODEL = ["--model", "model.safetensors"]
COMMANDS = {
    "simulate": ["simulate", "--protocol", "tiny.json", "-o", "out.csv"],
    "stimulus": ["stimulus", "--protocol", "tiny.json", "-o", "out.csv", "--plot", "out.html"],
    "dataset": ["dataset", "--count", "8", "--protocol", "tiny.json", "-o", "out.npz", "--report", "out.html"],
    "train": ["train", "--data", "data.npz", "--architecture", "net.txt", "--head", "point", "--image", "image.json", "--epochs",
              "2", "--report", "out.html", "-o", "out.safetensors"],
    "evaluate": ["evaluate", *MODEL, "--data", "fresh.npz", "--json"],
    "identify": ["identify", "trial.csv", *MODEL, "--detrend", "offset", "-o", "out.json", "--report", "out.html",
                 "--table", "out.csv"],
    "mat_5": ["identify", "v5.mat", "--column", "COM_x", "--rate", "5", *MODEL, "-o", "out.json"],
    "mat_73": ["identify", "v73_h5py.mat", "--rate", "5", "--tilt-column", "none", *MODEL, "-o", "out.json"],
    "fit": ["fit", "trial.csv", *MODEL, "--max-draws", "8", "-o", "out.json", "--draws", "out.npz"],
    "calibrate": ["calibrate", "--trials", "2", "--protocol", "tiny.json", *MODEL, "--max-draws", "8", "--groups", "1", "-o",
                  "out.json"],
    "image": ["image", "data.npz", *MODEL, "-o", "out.npz"],
    "export_c": ["export", "c", "model.safetensors", "-o", "firmware"],
    "export_controller": ["export", "controller", "result.json", "--force", "-o", "firmware"],
    "export_onnx": ["export", "onnx", "model.safetensors", "-o", "out.onnx"],
    "export_sway": ["export", "sway", "trial.csv", *MODEL, "-o", "out.bin"],
}

RECORDINGS = {"identify", "mat_5", "mat_73", "fit"}  # commands whose results have the errors of recordings

ERROR = re.compile(r"((?!decid: )[^\n]+\n)*decid: [^\n]+\n")  # behind what a recording is warned of
UNWRITTEN = re.compile(r": (writing failed|cannot be written): ")  # a disk is no bad input
LEFT = re.compile(r"(^|/)\.decid-[0-9]+-[0-9]+\.tmp$|\.lock$")


def contents(folder, without_left=False):
    """Name and content of each file."""
    files = {str(p.relative_to(folder)): p for p in sorted(folder.rglob("*")) if p.is_file()}
    return {name: TIMES.sub(b"", p.read_bytes()) for name, p in files.items() if not (without_left and LEFT.search(name))}


class Runner:
    def __init__(self, decid, library, inputs):
        self.decid, self.library, self.inputs = decid, library, inputs
        self.failures, self.checked, self.survived = [], 0, 0

    def run(self, arguments, folder, **settings):
        environment = {**os.environ, "OMP_NUM_THREADS": "1", **settings}
        if settings:
            environment["LD_PRELOAD"] = self.library
        return subprocess.run([self.decid, *arguments, "--quiet", "--threads", "1"], cwd=folder, env=environment, timeout=300,
                              stdin=subprocess.DEVNULL, capture_output=True)

    def fresh(self, root):
        folder = pathlib.Path(tempfile.mkdtemp(dir=root))
        for name in self.inputs.iterdir():
            os.symlink(name, folder / name.name)
        return folder

    def check(self, command, function, call, wanted, root):
        arguments = COMMANDS[command]
        folder = self.fresh(root)
        before = contents(folder)
        result = self.run(arguments, folder, DECID_FAULT=f"{function}:{call}:{ERRNO.get(function, errno.EIO)}")
        after, text = contents(folder, function == "allocate"), result.stderr.decode(errors="replace")
        self.checked += 1

        def fail(problem):
            self.failures.append(f"{command}: {function} {call}: {problem}")
            print("FAILED", self.failures[-1], flush=True)

        if result.returncode == 0:
            self.survived += 1
            if after != wanted and (command, function) != ("mat_73", "allocate"):
                fail(f"exit 0, but other bytes in {sorted(n for n in wanted.keys() | after.keys() if after.get(n) != wanted.get(n))}")
        elif result.returncode not in (1, 2):
            fail(f"exit {result.returncode}: {text[-300:]}")
        elif function != "allocate" and (result.returncode != (1 if UNWRITTEN.search(text) else 2) or not ERROR.fullmatch(text)):
            fail(f"exit {result.returncode}, not one clear line: {text[-300:]!r}")
        elif function == "allocate" and "decid: " not in text and "libgomp: Out of memory" not in text:
            fail(f"exit {result.returncode} without a line: {text[-300:]!r}")
        else:
            # Unfinished work that the same command goes on from is kept; else an output is whole or not there. A recording that
            # could not be read has its error in the result.
            problem = text.strip().split("\n")[-1].removeprefix("decid: ").split(": ", 1)[-1].split(";")[0]
            for name, content in after.items():
                if command in RECORDINGS and problem.encode() in content:
                    continue
                going_on = re.search(r"\.(partial|journal|checkpoint)$", name) is not None
                if name not in before and not going_on and content != wanted.get(name) and command != "calibrate":
                    # Training writes its page and its log again after each epoch.
                    if not (command == "train" and content.rstrip().endswith((b"</html>", EPOCH_1))):
                        fail(f"left {name} of {len(content)} bytes")
        again = self.run(arguments, folder)
        now = contents(folder, function == "allocate")
        if again.returncode != 0 or now != wanted:
            fail(f"run again: exit {again.returncode}, differing "
                 f"{sorted(n for n in wanted.keys() | now.keys() if now.get(n) != wanted.get(n))}: {again.stderr.decode()[-300:]}")
        subprocess.run(["rm", "-rf", folder], check=True)

    def command(self, command, stride, only, root):
        folder = self.fresh(root)
        counts_file = pathlib.Path(root) / "counts"
        result = self.run(COMMANDS[command], folder, DECID_FAULT_COUNT=str(counts_file))
        assert result.returncode == 0, (command, result.stderr.decode())
        wanted = contents(folder)
        again = self.fresh(root)
        self.run(COMMANDS[command], again)
        assert contents(again) == wanted, f"{command} is not the same twice"
        for line in counts_file.read_text().splitlines():
            function, count = line.split()
            step = stride * (50 if function == "allocate" else 1)
            if only and function != only:
                continue
            for call in range(1 + (step - 1) // 2 % max(1, int(count)), int(count) + 1, step):
                self.check(command, function, call, wanted, root)


def make_inputs(decid, folder, repository):
    def run(*arguments):
        subprocess.run([decid, *arguments, "--quiet"], cwd=folder, check=True, stdout=subprocess.DEVNULL)

    (folder / "tiny.json").write_text(json.dumps(PROTOCOL))
    (folder / "net.txt").write_text("globalavgpool\nfc 7\n")
    (folder / "image.json").write_text('{"window": 10, "half_spectrum": true, "channels": ["log_modulus"]}')
    run("dataset", "--count", "40", "--protocol", "tiny.json", "-o", "data.npz")
    run("dataset", "--count", "20", "--seed", "9", "--protocol", "tiny.json", "-o", "fresh.npz")
    run("train", "--data", "data.npz", "--architecture", "net.txt", "--head", "point", "--image", "image.json", "--epochs", "1", "-o",
        "model.safetensors")
    run("simulate", "--protocol", "tiny.json", "-o", "trial.csv")
    run("identify", "trial.csv", *MODEL, "-o", "result.json")
    result = json.loads((folder / "result.json").read_text())  # of a network that has learned nothing: some body's instead
    for found, value in zip(result["recordings"][0]["parameters"], (800, 250, 150, 100, 0.2, 0.001, 0.1)):
        found["value"] = value
    (folder / "result.json").write_text(json.dumps(result))
    for name in ("v5.mat", "v73_h5py.mat"):
        (folder / name).write_bytes((repository / "tests/recording/mat" / name).read_bytes())


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("decid")
    parser.add_argument("library")
    parser.add_argument("--stride", type=int, default=1)
    parser.add_argument("--only")
    parser.add_argument("--function")
    arguments = parser.parse_args()
    repository = pathlib.Path(__file__).resolve().parents[2]
    root_of = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None
    with tempfile.TemporaryDirectory(dir=root_of) as root:
        inputs = pathlib.Path(root) / "inputs"
        inputs.mkdir()
        decid = os.path.abspath(arguments.decid)
        make_inputs(decid, inputs, repository)
        runner = Runner(decid, os.path.abspath(arguments.library), inputs)
        for command in COMMANDS:
            if arguments.only in (None, command):
                before = runner.checked
                runner.command(command, arguments.stride, arguments.function, root)
                print(f"{command}: {runner.checked - before} calls made to fail", flush=True)
        print(f"{runner.checked} calls made to fail, {runner.survived} of them could be done without, "
              f"{len(runner.failures)} failures")
        sys.exit(1 if runner.failures else 0)


main()
