#!/usr/bin/env python3
"""Makes the seeds that no program writes: tests/fuzz/seeds/make.py"""
import hashlib
import pathlib
import struct
import zlib

seeds = pathlib.Path(__file__).resolve().parent


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


for seed in range(4):  # the target draws calls and arguments from these bytes
    put("c_interface", f"bytes_{seed}", b"".join(hashlib.sha256(f"{seed} {i}".encode()).digest() for i in range(32)))
# An entry: the lengths of a key and of a result, and both; no result is that short.
put("fit_journal", "entry", struct.pack("<Q", 4) + b"name" + struct.pack("<Q", 8) + bytes(8))
put("mat", "v7_inflated.mat", plain((seeds.parents[1] / "recording/mat/v7_struct.mat").read_bytes()))
