#!/usr/bin/env python3
"""Makes the seeds that decid itself writes: tests/fuzz/seeds/make.py build/release/tools/decid

Files of an experiment of 4 s at 20 Hz, so that mutations meet structure and not samples.
"""
import hashlib
import json
import os
import pathlib
import struct
import subprocess
import sys
import tempfile
import zlib

seeds = pathlib.Path(__file__).resolve().parent
decid = os.path.abspath(sys.argv[1])
protocol = {"name": "tiny", "sequence": {"feedback": [0, 0, -1, 1], "start": [0, 0, 0, 1], "state_s": 0.05,
                                         "amplitude_deg": 1, "offset_s": 0, "cycles": 1}, "sample_rate_hz": 20}


def put(target, name, content):
    (seeds / target).mkdir(exist_ok=True)
    (seeds / target / name).write_bytes(content if isinstance(content, bytes) else content.encode())


def plain(mat):
    """A MAT-file of version 7 with its variables inflated."""
    made, at = mat[:128], 128
    while at < len(mat):
        size = int.from_bytes(mat[at + 4:at + 8], "little")
        made += zlib.decompress(mat[at + 8:at + 8 + size])
        at += 8 + size
    return made


for seed in range(8):  # of calls in an order and with arguments drawn from these bytes
    put("c_interface", f"bytes_{seed}", b"".join(hashlib.sha256(f"{seed} {i}".encode()).digest() for i in range(32)))

with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)

    def run(*arguments):
        subprocess.run([decid, *arguments], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def read(name):
        return pathlib.Path(name).read_bytes()

    pathlib.Path("tiny.json").write_text(json.dumps(protocol))
    put("protocol", "tiny.json", read("tiny.json"))
    run("dataset", "--count", "3", "--protocol", "tiny.json", "-o", "tiny.npz")
    put("npz", "tiny.npz", read("tiny.npz"))
    run("dataset", "--count", "200", "--protocol", "tiny.json", "-o", "more.npz")
    pathlib.Path("net.txt").write_text("conv 2 3x3\nbatchnorm\nrelu\nglobalavgpool\nfc 36\n")
    pathlib.Path("point.txt").write_text("globalavgpool\nfc 7\n")
    pathlib.Path("image.json").write_text(json.dumps({"window": 10, "half_spectrum": True, "channels": ["log_modulus"]}))
    for name, head in (("net", "mixture 1"), ("point", "point")):
        run("train", "--data", "more.npz", "--architecture", name + ".txt", "--head", head, "--image", "image.json",
            "--epochs", "1", "-o", name + ".safetensors")
        put("model", name + ".safetensors", read(name + ".safetensors"))
    run("calibrate", "--trials", "2", "--protocol", "tiny.json", "--model", "point.safetensors", "--max-draws", "8",
        "--groups", "1", "-o", "calibration.json")
    put("calibration", "calibration.json", read("calibration.json"))
    run("compare", "--trials", "2", "--simulations", "6400", "--starts", "1",
        "--max-draws", "8",
        "-o", "comparison.json")
    put("comparison", "comparison.json", read("comparison.json"))
    run("simulate", "--protocol", "tiny.json", "-o", "trial.csv")
    put("recording", "trial.csv", read("trial.csv"))
    run("identify", "trial.csv", "--model", "point.safetensors", "-o", "result.json")
    put("result", "result.json", read("result.json"))
    # An entry: the lengths of a key and of a result, and both; no result is that short.
    put("fit_journal", "entry", struct.pack("<Q", 4) + b"name" + struct.pack("<Q", 8) + bytes(8))
    put("mat", "v7_inflated.mat", plain((seeds.parents[1] / "recording/mat/v7_struct.mat").read_bytes()))
