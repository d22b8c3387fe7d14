"""Model files of decid in Python, with nothing but NumPy: safetensors, float32 alone, and a hash of the content.

    python3 examples/model_file.py MODEL...      writes the hash of its content into each file

docs/reference/model-files.md says which tensors and metadata a model has, and how one that was trained elsewhere becomes such a file.
"""
import hashlib
import json
import struct
import sys

import numpy


def read(path):
    """The metadata, texts by key, and the tensors, arrays by name."""
    raw = open(path, "rb").read()
    (length,) = struct.unpack("<Q", raw[:8])
    header = json.loads(raw[8 : 8 + length])
    metadata = header.pop("__metadata__", {})
    tensors = {}
    for name, entry in sorted(header.items(), key=lambda item: item[1]["data_offsets"]):
        first, last = (8 + length + offset for offset in entry["data_offsets"])
        tensors[name] = numpy.frombuffer(raw[first:last], "<f4").reshape(entry["shape"])
    if metadata.get("sha256", content_hash(metadata, tensors)) != content_hash(metadata, tensors):
        raise ValueError(path + " is damaged: its content is not what its hash says")
    return metadata, tensors


def content_hash(metadata, tensors):
    """SHA-256 over all metadata but the hash itself, and all tensors, in order of their names."""
    found = hashlib.sha256()
    for key in sorted(metadata.keys() - {"sha256"}):
        found.update(key.encode() + b"\0" + metadata[key].encode() + b"\0")
    for name in sorted(tensors):
        shape = ",".join(str(extent) for extent in tensors[name].shape)
        found.update(name.encode() + b"\0" + shape.encode() + b"\0" + tensors[name].astype("<f4").tobytes())
    return found.hexdigest()


def write(path, metadata, tensors):
    metadata = dict(sorted((metadata | {"sha256": content_hash(metadata, tensors)}).items()))
    header, offset, data = {"__metadata__": metadata}, 0, b""
    for name, values in tensors.items():
        data += values.astype("<f4").tobytes()
        header[name] = {"dtype": "F32", "shape": list(values.shape), "data_offsets": [offset, len(data)]}
        offset = len(data)
    text = json.dumps(header, separators=(",", ":"), ensure_ascii=False).encode()
    text += b" " * (-len(text) % 8)
    with open(path, "wb") as file:
        file.write(struct.pack("<Q", len(text)) + text + data)


if __name__ == "__main__":
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    for path in sys.argv[1:]:
        write(path, *read(path))
