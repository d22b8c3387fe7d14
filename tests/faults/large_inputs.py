#!/usr/bin/env python3
"""Files of just under 10 MB that are made to be expensive to read: decid ends clearly, within 1 GB of memory.

    tests/faults/large_inputs.py DECID [--time] [--only PART] [--size BYTES]

Prints a row a file: the processor's time, user's and system's, the most memory, exit code and first line of the error. Fails
where more memory was taken, or the program ended by a signal, or otherwise than with exit code 0, or 2 and "decid: ". --time
fails too where more than 1 s of processor time was taken. --only: the files whose names have PART in them. --size: bytes, with
a limit of 200 MB and 80 bytes of memory a byte, at least 500 MB: what a compressed file expands to does not depend on its size.
"""
import argparse
import io
import itertools
import json
import os
import pathlib
import re
import resource
import signal
import struct
import sys
import tempfile
import zipfile
import zlib

TESTS = pathlib.Path(__file__).resolve().parents[1]
GOLDEN = TESTS / "golden/0.2.0"
MOST_S = 1.0
SIZE = 9_990_000


def golden(name):
    return (GOLDEN / name).read_bytes()


def lines(line, before="", size=None):
    """As often as fits."""
    size = size or SIZE
    return (before + line * ((size - len(before)) // len(line))).encode()


def numbered(form, between, size=None):
    """form % 0, form % 1, .. as often as fits."""
    size = size or SIZE
    each = len(form % 1_000_000) + len(between)
    return between.join(form % i for i in range(size // each)).encode()


# --- recordings as text

def trc(name):
    head = "PathFileType\t4\n" + "DataRate\tUnits\n" + "100\tmm\n"
    rest = SIZE - len(head) - len(name) - 100
    return (head + "Frame#\tTime\t" + name + "\n" + "\t\tX1" + "\tY1" * (rest // 3) + "\n1\t0\t1\n").encode()


def wide(cell, columns, header=None):
    row = (cell + ",") * (columns - 1) + cell + "\n"
    return lines(row, header or "")


def texts():
    named = ",".join(f"c{i}" for i in range(1000)) + "\n"
    return {
        "one row of columns": lambda: b"1," * (SIZE // 2),
        "one header of columns": lambda: lines("a,", size=SIZE - 4) + b"\n1,2",
        "one header of names of sheets": lambda: lines("taille,", size=SIZE - 4) + b"\n1,2",
        "two equal rows of columns": lambda: b"1," * (SIZE // 4) + b"\n" + b"1," * (SIZE // 4),
        "rows of 1000 columns": lambda: wide("1", 1000),
        "rows of 1000 named columns": lambda: wide("1", 1000, named),
        "rows of 1000 quoted columns": lambda: wide('"1"', 1000, named),
        "rows of 1000 times": lambda: "\n".join(",".join([str(i)] * 1000) for i in range(SIZE // 4900)).encode(),
        "rows of 1000 clocks": lambda: wide("10:00:00", 1000, named),
        "short rows": lambda: lines("1\n"),
        "short rows of two": lambda: lines("1,2\n", "time,sway\n"),
        "short rows that grow": lambda: numbered("%d,1", "\n"),
        "short rows below a header": lambda: b"time,sway_deg\n" + numbered("%d,1", "\n", SIZE - 20),
        "rows at 100 Hz": lambda: b"time,sway_deg\n" + numbered("%d0,1", "\n", SIZE - 20),
        "rows with gaps": lambda: b"time,sway_deg\n" + numbered("%d,", "\n", SIZE - 20),
        "rows of nan": lambda: b"time,sway_deg\n" + numbered("%d,nan", "\n", SIZE - 20),
        "empty lines": lambda: lines("\n"),
        "lines of remarks": lambda: lines("#\n"),
        "lines of blanks": lambda: lines(" \n"),
        "one line of blanks": lambda: lines(" "),
        "blanks between cells": lambda: lines("1 ") + b"\n",
        "one line of letters": lambda: lines("a"),
        "one line of quotes": lambda: lines('"'),
        "lines of quotes": lambda: lines('"",""\n'),
        "one number of digits": lambda: lines("1"),
        "one fraction of digits": lambda: b"0." + lines("0", size=SIZE - 3) + b"1",
        "rows of numbers of digits": lambda: lines("0." + "1" * 20000 + ",1e-" + "9" * 5000 + "\n"),
        "rows of 800 digits": lambda: lines("1.00000000000000011102230246251565404236316680908203125" + "0" * 700 + "1,1\n"),
        "quoted cells": lambda: lines('"1","2"\n', '"time","sway"\n'),
        "cells with decimal commas": lambda: lines("1,5;2,5\n", "time;sway\n"),
        "clock cells": lambda: "\n".join(f"{i // 3600 % 24:02}:{i // 60 % 60:02}:{i % 60:02},1" for i in range(SIZE // 11)).encode(),
        "dated cells": lambda: lines("2024-01-01T10:00:00.000,1\n", "time,sway\n"),
        "clock cells of digits": lambda: lines("10:00:00." + "1" * 30000 + ",1\n", "time,sway\n"),
        "preamble of cells": lambda: (("a," * 16600 + "\n") * 300).encode(),
        "preamble of times": lambda: (("time," + "a," * 16600 + "\n") * 299).encode() + b"1,2\n1,2\n",
        "preamble of units": lambda: (("deg," * 8300 + "\n") * 299).encode() + b"1," * 8300,
        "preamble of rates": lambda: (("rate " + "1 " * 16600 + "\n") * 300).encode(),
        "table below one long line": lambda: lines("rate", size=SIZE - 100) + b"\n1,2\n1,2\n1,2\n",
        "rows of separators": lambda: lines(",,,,,,,,,\n", "1,2,3,4,5,6,7,8,9,10\n"),
        "TRC of markers": lambda: trc("marker"),
        "TRC of long names": lambda: trc("m" * (SIZE // 2)),
        "TRC of rows": lambda: lines("1\t0\t1\t2\t3\n", "PathFileType\t4\nDataRate\tUnits\n100\tmm\nFrame#\tTime\tM\n\t\tX1\tY1\tZ1\n"),
        "UTF-16": lambda: b"\xff\xfe" + lines("1,2\n", size=SIZE // 2 - 2).decode().encode("utf-16-le"),
        "UTF-16 of Chinese": lambda: b"\xff\xfe" + "\u6c34".encode("utf-16-le") * (SIZE // 2 - 2),
        "UTF-16, no mark": lambda: lines("1,2\n", size=SIZE // 2 - 2).decode().encode("utf-16-be"),
        "Windows-1252": lambda: b"\x80" * SIZE,
        "Windows-1252 cells": lambda: b"\x80,\x80\n" * (SIZE // 4),
        "zero bytes": lambda: b"1,2\n" + b"\0" * (SIZE - 4),
        "lines ended by CR": lambda: lines("1,2\r"),
    }


# --- MAT-files

def element(kind, data):
    return struct.pack("<II", kind, len(data)) + data + b"\0" * (-len(data) % 8)


def matrix(name, height, width, kind, rest):
    return element(14, element(6, struct.pack("<II", kind, 0)) + element(5, struct.pack("<ii", height, width)) +
                   element(1, name.encode()) + rest)


def doubles(name, height, width):
    return matrix(name, height, width, 6, element(9, struct.pack("<d", 1.5) * (height * width)))


def bytes_of(name, height, width):
    """Numbers of a byte each."""
    return matrix(name, height, width, 6, element(2, b"\1" * (height * width)))


def deflated(data, level=9):
    packed = zlib.compress(data, level)
    return struct.pack("<II", 15, len(packed)) + packed


def mat(*parts):
    return b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack("<HH", 0x0100, 0x4D49) + b"".join(parts)


def many(make, size=None):
    made, size = [], size or SIZE - 200
    for i in itertools.count():
        part = make(i)
        size -= len(part)
        if size < 0:
            return made
        made.append(part)


def mat_4(name, height, width, kind=0, bytes_each=8):
    return struct.pack("<iiiii", kind, height, width, 0, len(name) + 1) + name.encode() + b"\0" + b"\1" * (height * width * bytes_each)


def nested(inner, depth):
    for _ in range(depth):
        inner = matrix("s", 1, 1, 2, element(5, struct.pack("<i", 2)) + element(1, b"a\0") + inner)
        if len(inner) > SIZE:
            break
    return inner


def nested_cells(depth):
    inner = matrix("", 0, 0, 1, b"")
    for _ in range(depth):
        inner = matrix("", 1, 1, 1, inner)
    return matrix("c", 1, 1, 1, inner)


def struct_of(fields):
    names = b"".join(f"f{i}".encode().ljust(8, b"\0") for i in range(fields))
    return matrix("s", 1, 1, 2, element(5, struct.pack("<i", 8)) + element(1, names) +
                  b"".join(doubles("", 3, 1) for _ in range(fields)))


def mats():
    return {
        "one column": lambda: mat(doubles("sway", (SIZE - 300) // 8, 1)),
        "one column of bytes": lambda: mat(bytes_of("sway", SIZE - 300, 1)),
        "time and sway of bytes": lambda: mat(bytes_of("time", SIZE // 2 - 300, 1), bytes_of("sway", SIZE // 2 - 300, 1)),
        "1000 columns": lambda: mat(bytes_of("all", SIZE // 1000 - 1, 1000)),
        "most columns": lambda: mat(bytes_of("all", 2, SIZE // 2 - 200)),
        "many variables": lambda: mat(*many(lambda i: doubles(f"v{i}", 1, 2))),
        "9999 variables": lambda: mat(*(bytes_of(f"v{i}", 1, 850) for i in range(9999))),
        "many deflated variables": lambda: mat(*many(lambda i: deflated(doubles(f"v{i}", 1, 2)))),
        "one deflated bomb": lambda: mat(deflated(element(14, b"\0" * 1_000_000_000), 1)),
        "one deflated column": lambda: mat(deflated(bytes_of("sway", 200_000_000, 1))),
        "one deflated column that fits": lambda: mat(deflated(bytes_of("sway", 31_000_000, 1))),
        "two deflated columns that fit": lambda: mat(deflated(bytes_of("time", 9_000_000, 1)), deflated(bytes_of("sway", 9_000_000, 1))),
        "deflated bombs of 255 MB": lambda: mat(*[deflated(element(1, b"\0" * 255_000_000))] * 40),
        "deflated variables of 10 MB": lambda: mat(*[deflated(element(1, b"\0" * 10_000_000))] * 900),
        "claimed numbers": lambda: mat(matrix("sway", 2_000_000_000, 1, 6, element(2, b"\1" * (SIZE - 300)))),
        "nested structures": lambda: mat(nested(doubles("a", 3, 1), 20000)),
        "nested cells": lambda: mat(nested_cells(20000)),
        "a structure of many fields": lambda: mat(struct_of(SIZE // 110)),
        "one long name": lambda: mat(doubles("n" * (SIZE - 400), 1, 2)),
        "long names": lambda: mat(*(doubles("n" * 9000 + str(i), 1, 2) for i in range(1000))),
        "empty elements": lambda: mat(struct.pack("<II", 1, 0) * (SIZE // 8 - 20)),
        "version 4, one column": lambda: mat_4("sway", (SIZE - 100) // 8, 1),
        "version 4, one column of bytes": lambda: mat_4("sway", SIZE - 100, 1, 50, 1),
        "version 4, many variables": lambda: b"".join(many(lambda i: mat_4(f"v{i}", 1, 2))),
        "version 4, most columns": lambda: mat_4("all", 2, SIZE // 2 - 100, 50, 1),
        "version 7.3, nothing else": lambda: b"MATLAB 7.3 MAT-file".ljust(512) + b"\x89HDF\r\n\x1a\n" + b"\0" * (SIZE - 600),
        "version 7.3 and zeros": lambda: (TESTS / "recording/mat/v73_h5py.mat").read_bytes().ljust(SIZE, b"\0"),
    }


# --- C3D files

def c3d(points, channels=0, samples=1, parameters=b"", blocks=2):
    """Integers, all 1, in a file of SIZE bytes whose parameters fill `blocks` blocks."""
    row = 2 * (4 * points + channels * samples)
    frames = min((SIZE - 512 * (1 + blocks)) // row, 65535)
    header = struct.pack("<BBHHHHHfHHf", 2, 0x50, points, channels * samples, 1, frames, 0, 0.1, 2 + blocks, samples, 100.0)
    section = b"\0\0" + struct.pack("BB", blocks % 256, 84) + parameters
    return header.ljust(512, b"\0") + section.ljust(512 * blocks, b"\0") + b"\1\0" * (frames * row // 2)


def c3d_parameters(blocks, name, body):
    """As many parameters of that type, dimensions and values as fill the blocks, and their group."""
    one = struct.pack("BB", len(name), 1) + name + struct.pack("<H", 3 + len(body)) + body + b"\0"
    group = struct.pack("bb", 5, -1) + b"POINT" + struct.pack("<HB", 3, 0)
    return group + one * ((512 * blocks - 20) // len(one))


def c3ds():
    text = b"\xff\2\x10\xff" + b"label           " * 255
    blocks = min(18000, SIZE // 512 - 100)  # of parameters, nearly the whole file
    return {
        "frames of a point": lambda: c3d(1),
        "frames of many points": lambda: c3d(3333),
        "too many points": lambda: c3d(65535),
        "one fast channel": lambda: c3d(1, 1, 60),
        "many channels": lambda: c3d(1, 9000),
        "parameters": lambda: c3d(1, parameters=c3d_parameters(blocks, b"A", b"\1\0\1"), blocks=blocks),
        "parameters of labels": lambda: c3d(1, parameters=c3d_parameters(blocks, b"LABELS", text), blocks=blocks),
        "labels": lambda: c3d(3333, parameters=c3d_parameters(9, b"LABELS", text), blocks=9),
    }


# --- workbooks

def xlsx(rows, shared=""):
    return archive([("xl/workbook.xml", '<workbook><sheets><sheet name="a" r:id="r"/></sheets></workbook>'),
                    ("xl/_rels/workbook.xml.rels", '<R><Relationship Id="r" Target="s.xml"/><Relationship Id="t" Type="/sharedStrings" Target="t.xml"/></R>'),
                    ("xl/s.xml", rows), ("xl/t.xml", shared)])


def xlsxs():
    row = "<row><c><v>1</v></c><c><v>2</v></c></row>"
    return {
        "rows": lambda: xlsx(row * 1_000_000),
        "too many rows": lambda: xlsx(row * 2_000_000),
        "rows without cells": lambda: xlsx("<row/>" * 1_048_576),
        "rows of one far cell": lambda: xlsx("<row><c r='ALL1'><v>1</v></c></row>" * 1_000_000),
        "a shared text": lambda: xlsx("<row><c t='s'><v>0</v></c></row>" * 1_000_000, "<si><t>" + "a" * 1_000_000 + "</t></si>"),
        "shared texts": lambda: xlsx(row, "<si/>" * 20_000_000),
        "a bomb": lambda: xlsx(" " * 200_000_000),
        "a bomb that fits": lambda: xlsx(" " * 130_000_000),
        "attributes": lambda: xlsx("<row " + "a='1' " * 10_000_000 + "/>"),
        "a cell of attributes": lambda: xlsx("<row>" + ("<c " + "a='1' " * 100_000 + "/>") * 100 + "</row>"),
        "entities": lambda: xlsx("<row><c><v>" + "&amp;" * 10_000_000 + "</v></c></row>"),
        "comments": lambda: xlsx("<!---->" * 10_000_000),
    }


# --- archives

def npy(kind, shape, data):
    text = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}".encode()
    return b"\x93NUMPY\1\0" + struct.pack("<H", len(text) + 1) + text + b"\n" + data


def archive(members, method=zipfile.ZIP_DEFLATED):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", method) as file:
        for name, data in members:
            file.writestr(name, data)
    return buffer.getvalue()


def tiny(**others):
    """The seed's members, some of them replaced."""
    with zipfile.ZipFile(io.BytesIO(golden("data.npz"))) as file:
        members = {name: file.read(name) for name in file.namelist()}
    description = members["decid.json.npy"]
    del members["decid.json.npy"]
    members.update({name + ".npy": data for name, data in others.items()})
    return [*members.items(), ("decid.json.npy", description)]


def trials(count):
    return tiny(sway=npy("<f4", (count, 80), b"\0" * (320 * count)), parameters=npy("<f8", (count, 7), b"\0" * (56 * count)),
                group=npy("<i4", (count,), b"\0" * (4 * count)), split=npy("|u1", (count,), b"\0" * count))


def archives():
    return {
        "many members": lambda: archive(((str(i), b"") for i in range(SIZE // 115)), zipfile.ZIP_STORED),
        "a bomb of sway": lambda: archive(tiny(sway=npy("<f4", (2_500_000, 80), b"\0" * 800_000_000))),
        "a bomb of parameters": lambda: archive(tiny(parameters=npy("<f8", (15_000_000, 7), b"\0" * 840_000_000))),
        "a bomb of the description": lambda: archive(
            [*tiny()[:-1], ("decid.json.npy", npy("|S800000000", (), b"\0" * 800_000_000))]),
        "a description of lists": lambda: archive(
            [*tiny()[:-1], ("decid.json.npy", npy("|S16000000", (), (b"[0" + b",0" * 7_999_998 + b"]").ljust(16_000_000)))]),
        "a million trials of zeros": lambda: archive(trials(1_000_000)),
        "300 thousand trials of zeros": lambda: archive(trials(300_000)),
        "20 thousand trials": lambda: archive(trials(20_000), zipfile.ZIP_STORED),
        "an array's long header": lambda: archive(tiny(sway=b"\x93NUMPY\1\0\xff\xff" + b" " * 65535), zipfile.ZIP_STORED),
        "zeros before the archive": lambda: golden("data.npz").rjust(SIZE, b"\0"),
        "zeros behind the archive": lambda: golden("data.npz").ljust(SIZE, b"\0"),
    }


# --- models, JSON

def safetensors(header, data=b""):
    return struct.pack("<Q", len(header)) + header + data


def header_of_many():
    entry = '"t%07d":{"dtype":"F32","shape":[0],"data_offsets":[0,0]}'
    return b"{" + numbered(entry, ",", SIZE - 100) + b"}"


def model_with(key, text):
    content = golden("point.safetensors")
    length = struct.unpack("<Q", content[:8])[0]
    header = json.loads(content[8:8 + length])
    header["__metadata__"][key] = text
    del header["__metadata__"]["sha256"]  # which says that something was changed
    return safetensors(json.dumps(header).encode(), content[8 + length:])


def jsons():
    return {
        "a list": lambda: b"[0" + b",0" * (SIZE // 2 - 2) + b"]",
        "a list of lists": lambda: b"[[]" + b",[]" * (SIZE // 3 - 2) + b"]",
        "a list of objects": lambda: b"[{}" + b",{}" * (SIZE // 3 - 2) + b"]",
        "a list of objects with a key": lambda: b'[{"a":0}' + b',{"a":0}' * (SIZE // 8 - 2) + b"]",
        "a list of texts": lambda: b'[""' + b',""' * (SIZE // 3 - 2) + b"]",
        "a list of numbers": lambda: b"[1e-300" + b",1e-300" * (SIZE // 7 - 2) + b"]",
        "a number of digits": lambda: b"[" + b"1" * (SIZE - 2) + b"]",
        "a fraction of digits": lambda: b"[0." + b"1" * (SIZE - 4) + b"]",
        "brackets": lambda: b"[" * SIZE,
        "lists in lists": lambda: b"[" + b",".join([b"[" * 30 + b"]" * 30] * (SIZE // 61 - 1)) + b"]",
        "an object of keys": lambda: b"{" + numbered('"k%07d":0', ",", SIZE - 2) + b"}",
        "objects of 1000 keys": lambda: b"[" + b",".join(
            [b"{" + b",".join(b'"%03d":0' % i for i in range(1000)) + b"}"] * (SIZE // 8010)) + b"]",
        "an object of one key": lambda: b"{" + b",".join([b'"key":0'] * (SIZE // 8 - 1)) + b"}",
        "one long key": lambda: b'{"' + b"k" * (SIZE - 10) + b'":0}',
        "one long text": lambda: b'{"name":"' + b"k" * (SIZE - 20) + b'"}',
        "a text of escapes": lambda: b'{"name":"' + b"\\u6c34" * (SIZE // 6 - 5) + b'"}',
        "blanks": lambda: b" " * SIZE,
        "blanks before": lambda: b" " * (SIZE - 2) + b"{}",
    }


def within(json_text, key, value):
    """The text of an object, with `value` (text of JSON) put in for one key or added."""
    data = json.loads(json_text)
    data[key] = "@@"
    return json.dumps(data).replace('"@@"', value).encode()


def protocols():
    tilt = lambda n: json.dumps({"name": "m", "measured": {"tilt_deg": [0.1] * n}, "sample_rate_hz": 20})
    long_list = lambda item: "[" + ",".join([item] * (SIZE // (len(item) + 1) - 200)) + "]"
    tiny_text = golden("protocol.json").decode()
    return {
        "states": lambda: within(tiny_text, "sequence", '{"feedback": [0,0,-1,1], "start": ' + long_list("0") + ', "state_s": 0.05}'),
        "measured tilt": lambda: tilt(SIZE // 5 - 100).encode(),
        "sines": lambda: b'{"name": "m", "sines": {"cycle_s": 10, "components": '
                         + long_list('{"frequency_hz":1,"amplitude_deg":0}').encode() + b"}}",
        "raised cosines": lambda: b'{"name": "m", "raised_cosines": {"cycle_s": 10, "moves": '
                                  + long_list('{"shape":"step","start_s":1,"duration_s":1,"amplitude_deg":0}').encode() + b"}}",
        "long name": lambda: within(tiny_text, "name", '"' + "n" * (SIZE - 500) + '"'),
    }


def journals():
    front = b"decid fit journal 6\n"
    return {
        "zeros behind": lambda: front.ljust(SIZE, b"\0"),
        "a length of all": lambda: front + struct.pack("<Q", SIZE - 100) + b"0" * (SIZE - 100),
        "lines": lambda: b"\n" * SIZE,
    }


# --- which command reads what

def cases():
    model = ["--model", str(GOLDEN / "point.safetensors")]
    trial = str(GOLDEN / "trial.csv")
    protocol = ["--protocol", str(GOLDEN / "protocol.json")]
    calibrate = ["calibrate", "--trials", "2", *protocol, *model, "--max-draws", "8", "--groups", "1"]

    def group(kind, files, end, *commands):
        for name, make in files.items():
            for command in commands:
                yield f"{kind}: {name}" + (f" ({command[0]})" if len(commands) > 1 else ""), make, end, command

    yield from group("text", texts(), ".csv", ["identify", "FILE", *model], ["identify", "FILE", *model, "--fill-gaps", "60", "--tilt-column", "none"])
    yield from group("text as response", {k: texts()[k] for k in ("rows of 1000 named columns", "short rows of two", "rows of 1000 quoted columns")},
                     ".csv", ["fit", "--frf", "FILE"])
    yield from group("response", {
        "rows": lambda: b"frequency_hz,gain,phase_deg\n" + numbered("%d,1,-10", "\n", SIZE - 100),
        "columns": lambda: wide("1", 1000, ",".join(["frequency_hz"] * 1000) + "\n"),
    }, ".csv", ["fit", "--frf", "FILE", "--max-draws", "8"])
    yield from group("MAT", mats(), ".mat", ["identify", "FILE", *model])
    yield from group("C3D", c3ds(), ".c3d", ["identify", "FILE", *model, "--column", "1", "--com-height", "0.9", "--unit", "mm"])
    yield from group("workbook", xlsxs(), ".xlsx", ["identify", "FILE", *model])
    yield from group("data set", archives(), ".npz", ["evaluate", "--data", "FILE", *model])
    yield from group("model", {
        "many tensors": lambda: safetensors(header_of_many()),
        "many dimensions": lambda: safetensors(b'{"t":{"dtype":"F32","shape":[1' + b",1" * (SIZE // 2 - 60) + b'],"data_offsets":[0,4]}}', b"\0" * 4),
        "metadata": lambda: safetensors(b'{"__metadata__":{' + numbered('"k%07d":""', ",", SIZE - 100) + b"}}"),
        "brackets in the header": lambda: safetensors(b'{"a":' + b"[" * (SIZE - 100)),
        "lists in the header": lambda: safetensors(b'{"a":[' + b"[]," * (SIZE // 3 - 20) + b"[]]}"),
        "data of no tensor": lambda: safetensors(b"{}", b"\0" * SIZE),
        "a protocol of states": lambda: model_with("protocol", json.dumps({"name": "x", "sequence": {"start": [0] * (SIZE // 3 - 1000)}})),
        "an architecture of lines": lambda: model_with("architecture", "relu\n" * (SIZE // 6 - 1000)),
        "an origin of lists": lambda: model_with("origin", json.dumps({"version": [[]] * (SIZE // 4 - 1000)})),
        "a log of epochs": lambda: model_with("log", "[" + ",".join(["[1,2,3,4]"] * (SIZE // 10 - 1000)) + "]"),
    }, ".safetensors", ["info", "FILE"])
    for kind, end, command in (("protocol", ".json", ["stimulus", "--protocol", "FILE", "-o", "out.csv"]),
                               ("image", ".json", ["image", str(GOLDEN / "data.npz"), "--image", "FILE", "-o", "out.npz"]),
                               ("result", ".json", ["export", "controller", "FILE", "-o", "firmware"]),
                               ("comparison", ".json", ["study", *model, "--trials", "2", "--comparison", "FILE", "-o", "study"])):
        yield from group(kind, jsons(), end, command)
    yield from group("calibration", jsons(), ".json", [*calibrate, "-o", "FILE", "--resume"])
    yield from group("protocol", protocols(), ".json", ["stimulus", "--protocol", "FILE", "-o", "out.csv"])
    yield from group("result", {"recordings": lambda: b'{"recordings":[' + b"{}," * (SIZE // 3 - 20) + b"{}]}"}, ".json",
                     ["export", "controller", "FILE", "-o", "firmware"])
    yield from group("architecture", {"lines": lambda: lines("relu\n"), "one line": lambda: lines("conv ")}, ".txt",
                     ["train", "--data", str(GOLDEN / "data.npz"), "--architecture", "FILE", "-o", "out.safetensors"])
    yield from group("groups", {
        "separators": lambda: b"file,group" + b"," * (SIZE - 20),
        "empty lines": lambda: b"file,group" + b"\n" * (SIZE - 20),
        "lines": lambda: lines("a,b\n", "file,group\n"),
        "folders": lambda: b"file,group\n" + b"../" * (SIZE // 3 - 20) + b"a,b\n",
        "names": lambda: lines("x/" * 50 + "a,b\n", "file,group\n"),
        "quotes": lambda: b'file,group\n"' + b'""' * (SIZE // 2 - 20),
    }, ".csv", ["identify", trial, trial, *model, "--group", "FILE"])
    yield from group("journal of a fit", journals(), ".journal",
                     ["fit", trial, *model, "--max-draws", "8", "-o", "STEM", "--resume"])
    yield from group("learning curve", {
        "rows": lambda: b"trials,mse\n" + numbered("%d,1", "\n", SIZE - 100),
        "rows that shrink": lambda: lines("1,1\n", "trials,mse\n"),
    }, ".csv", ["study", *model, "--trials", "2", "--learning-curve", "FILE", "-o", "study"])
    yield from group("training log", {
        "rows": lambda: b"epoch,training_mse,validation_mse,learning_rate\n" + numbered("%d,1,1,1", "\n", SIZE - 100),
    }, ".csv", ["study", *model, "--trials", "2", "--log", "FILE", "-o", "study"])
    front = golden("dataset.journal")
    yield from group("journal of a data set", {"zeros behind": lambda: front.ljust(SIZE, b"\0"), "zeros": lambda: b"\0" * SIZE,
                                               "a request of 10 MB": lambda: b"decid journal 2\n" + struct.pack("<Q", SIZE - 100) + b"0" * 64 + b"[" * (SIZE - 88)},
                     ".npz.partial.journal", ["dataset", "--count", "3", *protocol, "-o", "STEM"])


def run(decid, command, file, folder):
    """Exit code, text of the error, seconds of the processor's time, MB."""
    stem = re.sub(r"(\.partial)?\.journal$", "", str(file))
    if file.name.endswith(".partial.journal"):
        pathlib.Path(stem + ".partial").write_bytes(b"PK")
    arguments = [{"FILE": str(file), "STEM": stem}.get(word, word) for word in command]
    errors = folder / "errors"
    child = os.fork()
    if child == 0:
        try:
            os.chdir(folder)
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            resource.setrlimit(resource.RLIMIT_CPU, (60, 60))
            resource.setrlimit(resource.RLIMIT_AS, (4 << 30, 4 << 30))  # enough to see that it is too much
            os.dup2(os.open(os.devnull, os.O_RDWR), 0)
            os.dup2(0, 1)
            os.dup2(os.open(errors, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), 2)
            os.environ["OMP_NUM_THREADS"] = "1"
            os.execv(decid, [decid, *arguments, "--quiet", "--threads", "1"])
        finally:
            os._exit(127)
    _, status, usage = os.wait4(child, 0)
    code = -os.WTERMSIG(status) if os.WIFSIGNALED(status) else os.WEXITSTATUS(status)
    with open(errors, "rb") as stream:
        text = stream.read(100_000).decode(errors="replace")
    return code, text, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1000


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("decid")
    parser.add_argument("--time", action="store_true")
    parser.add_argument("--only", default="")
    parser.add_argument("--size", type=int, default=SIZE)
    options = parser.parse_args()
    globals()["SIZE"] = options.size
    decid, failures, max_slip_s, max_mb, count = os.path.abspath(options.decid), [], 0.0, 0.0, 0
    print(f"{'s':>6} {'MB':>6} exit  file")
    for name, make, end, command in cases():
        if options.only not in name:
            continue
        content = make()
        assert len(content) <= 10_000_000, (name, len(content))
        with tempfile.TemporaryDirectory(dir="/dev/shm" if os.access("/dev/shm", os.W_OK) else None) as folder:
            file = pathlib.Path(folder, "input" + end)
            file.write_bytes(content)
            del content  # a child's memory begins with that of its parent
            code, text, seconds, mb = run(decid, command, file, pathlib.Path(folder))
        shown = text.replace(folder + "/", "").strip().split("\n")[-1]
        print(f"{seconds:6.2f} {mb:6.0f} {code:4}  {name}: {shown[:110]}", flush=True)
        count, max_slip_s, max_mb = count + 1, max(max_slip_s, seconds), max(max_mb, mb)
        if mb > max(500, 200 + 80 * options.size / 1e6):
            failures.append(f"{name}: {mb:.0f} MB")
        if options.time and seconds > MOST_S:
            failures.append(f"{name}: {seconds:.2f} s")
        if code not in (0, 2) or (code == 2 and "decid: " not in text):
            failures.append(f"{name}: exit {code}: {text[-200:]}")
        if len(text) > 5000:
            failures.append(f"{name}: {len(text)} characters of messages")
    print(f"{count} files of {options.size} bytes at most: {max_slip_s:.2f} s and {max_mb:.0f} MB at most, {len(failures)} failures")
    for failure in failures:
        print(failure)
    sys.exit(1 if failures else 0)


main()
