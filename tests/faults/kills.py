#!/usr/bin/env python3
"""Kills long commands at any moment and goes on with them: the final bytes are those of an undisturbed call.

    tests/faults/kills.py DECID [--kills N] [--seed S]

Each of data set, training, fit and calibration is begun, killed with SIGKILL (every fourth time SIGTERM, every fourth
SIGHUP) after a part of the time that it takes undisturbed, drawn from the seed, and run again with what makes it go on,
until it has been killed a few times and then finishes. A folder then holds the same files with the same bytes.
"""
import argparse
import json
import os
import pathlib
import random
import re
import signal
import subprocess
import sys
import tempfile
import time

PROTOCOL = {"name": "tiny", "sequence": {"feedback": [0, 0, -1, 1], "start": [0, 0, 0, 1], "state_s": 0.05,
                                         "amplitude_deg": 1, "offset_s": 0, "cycles": 1}, "sample_rate_hz": 20}
SECONDS = re.compile(rb'"seconds": [-+.e0-9]+')
LEFT = re.compile(r"\.decid-[0-9]+-[0-9]+\.tmp$|\.lock$")  # a killed process cannot remove its own
MODEL = ["--model", "model.safetensors"]
COMMANDS = {
    "dataset": (["dataset", "--count", "20000", "--protocol", "tiny.json", "-o", "out.npz"], []),
    "train": (["train", "--data", "data.npz", "--architecture", "net.txt", "--head", "point", "--image", "image.json", "--epochs",
               "8", "-o", "out.safetensors"], ["--resume"]),
    "fit": (["fit", *[f"trial_{i}.csv" for i in range(4)], *MODEL, "--max-draws", "8", "-o", "out.json"], ["--resume"]),
    "calibrate": (["calibrate", "--trials", "6", "--protocol", "tiny.json", *MODEL, "--max-draws", "8", "--groups", "1", "-o",
                   "out.json"], ["--resume"]),
}


def contents(folder):
    files = {p.name: p for p in folder.iterdir() if p.is_file() and not p.is_symlink() and not LEFT.search(p.name)}
    return {name: SECONDS.sub(b"", p.read_bytes()) for name, p in files.items()}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("decid")
    parser.add_argument("--kills", type=int, default=500)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    decid, draw = os.path.abspath(options.decid), random.Random(options.seed)
    failures, kills, early, rounds = [], 0, 0, 0
    with tempfile.TemporaryDirectory(dir="/dev/shm" if os.access("/dev/shm", os.W_OK) else None) as root:
        inputs = pathlib.Path(root) / "inputs"
        inputs.mkdir()

        def run(*arguments, cwd=inputs):
            subprocess.run([decid, *arguments, "--quiet"], cwd=cwd, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)

        (inputs / "tiny.json").write_text(json.dumps(PROTOCOL))
        (inputs / "net.txt").write_text("conv 16 3x3 pad 1x1\nbatchnorm\nrelu\nglobalavgpool\nfc 7\n")
        (inputs / "image.json").write_text('{"window": 10, "half_spectrum": true, "channels": ["log_modulus"]}')
        run("dataset", "--count", "3000", "--protocol", "tiny.json", "-o", "data.npz")
        run("train", "--data", "data.npz", "--architecture", "net.txt", "--head", "point", "--image", "image.json", "--epochs", "1",
            "-o", "model.safetensors")
        for i in range(4):
            run("simulate", "--protocol", "tiny.json", "--seed", str(i + 1), "-o", f"trial_{i}.csv")

        def fresh():
            folder = pathlib.Path(tempfile.mkdtemp(dir=root))
            for path in inputs.iterdir():
                os.symlink(path, folder / path.name)
            return folder

        wanted, takes = {}, {}
        for name, (arguments, _) in COMMANDS.items():
            folder = fresh()
            begin = time.monotonic()
            run(*arguments, cwd=folder)
            takes[name] = time.monotonic() - begin
            wanted[name] = contents(folder)

        while kills < options.kills:
            name = list(COMMANDS)[rounds % len(COMMANDS)]
            rounds += 1
            arguments, going_on = COMMANDS[name]
            folder = fresh()
            begun = False
            for _ in range(draw.randint(1, 4)):
                process = subprocess.Popen([decid, *arguments, *(going_on if begun else []), "--quiet"], cwd=folder,
                                           stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
                how = (signal.SIGKILL, signal.SIGTERM, signal.SIGKILL, signal.SIGHUP)[kills % 4]
                try:
                    process.wait(draw.random() * takes[name])
                    early += 1  # it had ended before
                except subprocess.TimeoutExpired:
                    process.send_signal(how)
                    kills += 1
                text = process.communicate()[1].decode(errors="replace")
                if process.returncode not in (0, 1, -int(how)):
                    # Going on needs something to go on from.
                    if not (begun and process.returncode == 2 and name == "train" and "--resume" in text):
                        failures.append(f"{name}: exit {process.returncode}: {text[-300:]}")
                # Without what to go on from, --resume is refused by train.
                begun = name != "train" or (folder / "out.safetensors.checkpoint").exists() or (folder / "out.safetensors").exists()
            last = subprocess.run([decid, *arguments, *(going_on if begun else []), "--quiet"], cwd=folder, capture_output=True)
            found = contents(folder)
            if last.returncode != 0 or found != wanted[name]:
                differ = sorted(n for n in found.keys() | wanted[name].keys() if found.get(n) != wanted[name].get(n))
                failures.append(f"{name}: at last exit {last.returncode}, differing {differ}: {last.stderr.decode()[-300:]}")
                print("FAILED", failures[-1], flush=True)
            subprocess.run(["rm", "-rf", folder], check=True)
            if rounds % 50 == 0:
                print(f"{kills} kills in {rounds} runs", flush=True)
    print(f"{kills} kills in {rounds} runs ({early} had ended before), {len(failures)} failures")
    for failure in failures:
        print(failure)
    sys.exit(1 if failures else 0)


main()
