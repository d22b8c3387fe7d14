#!/usr/bin/env python3
"""Makes the MAT-files beside it with SciPy (Debian's python3-scipy 1.10): python3 tests/recording/mat/make.py

A sway of k / 8 degrees (exact in single precision), k = 1..20, at 50 Hz from 3 s on, and a tilt of -k / 4.
"""
import os

import numpy
from scipy.io import savemat

os.chdir(os.path.dirname(os.path.abspath(__file__)))
k = numpy.arange(1, 21)
time, sway, tilt = 3 + (k - 1) / 50, k / 8, -k / 4

savemat("v4.mat", {"time": time, "COM_x": sway, "tilt_deg": tilt}, format="4")
savemat("v5.mat", {"time": time[:, None], "COM_x": sway[:, None].astype("float32"), "note": "a text", "k": k.astype("int16")})
# Version 7 is version 5, compressed; a struct in a struct, the sway twice so that its name alone is not unique.
savemat("v7_struct.mat", {"trial": {"signals": {"COM_x": sway, "tilt": tilt}, "time": time, "fs": 50.0},
                          "other": {"COM_x": 2 * sway}, "cells": numpy.array([1, "two"], dtype=object)},
        do_compression=True)
savemat("matrix.mat", {"data": numpy.column_stack([time, sway, tilt])})
savemat("wide.mat", {"data": numpy.vstack([sway, tilt]), "fs": 50})
savemat("gaps.mat", {"time": time, "sway": numpy.where(k == 7, numpy.nan, sway)})
savemat("nothing.mat", {"note": "a text", "z": (1 + 2j) * sway, "one": 1.0})


def array_of(names, *elements):
    """A structure array of 1 x N."""
    made = numpy.zeros((1, len(elements)), dtype=[(name, object) for name in names])
    for i, element in enumerate(elements):
        made[0, i] = element
    return made


def cell_of(*elements):
    made = numpy.empty((1, len(elements)), dtype=object)
    for i, element in enumerate(elements):
        made[0, i] = element
    return made


def rows_of(*texts):
    """A matrix of characters, padded with blanks."""
    return numpy.array([text.ljust(max(map(len, texts))) for text in texts])


# Several recordings: arrays of structures and cells, pages, structures beside each other. The second is twice as large.
names = ["time", "com_sway_deg", "fs"]
savemat("struct_array.mat", {"trials": array_of(names, (time, sway, 50.0), (time, 2 * sway, 25.0)), "fs": 10.0})
savemat("cell.mat", {"data": cell_of(numpy.column_stack([time, sway]), numpy.column_stack([time, 2 * sway]))})
pages = numpy.stack([numpy.column_stack([sway, tilt]), numpy.column_stack([2 * sway, tilt])], axis=2)
savemat("pages.mat", {"data": pages, "labels": cell_of("com_sway_deg", "tilt_deg"), "fs": 50.0})
savemat("two_structs.mat", {"S01": {"time": time, "com_sway_deg": sway}, "S02": {"time": time / 2, "com_sway_deg": 2 * sway}})
savemat("trial_column.mat", {"trial": numpy.repeat([3.0, 7.0], 20), "time": numpy.tile(time, 2),
                             "com_sway_deg": numpy.concatenate([sway, 2 * sway]), "fs": 50.0})
# Exports of other programs.
savemat("simulink.mat", {"out": {"time": time, "signals": array_of(["values", "dimensions", "label"], (sway, 1.0, "com_sway_deg"),
                                                                   (tilt, 1.0, "tilt_deg")), "blockName": "model/Scope"}})
savemat("timeseries.mat", {"ts": {"Time": time, "Data": sway, "Name": "lean", "DataInfo": {"Units": "deg"}}})
savemat("labelled.mat", {"data": numpy.column_stack([time, tilt, sway]), "labels": cell_of("time", "tilt_deg", "com_sway_deg")})
marker = 1000 * numpy.sin(numpy.radians(sway))
labelled = numpy.stack([numpy.vstack([100 + height * marker / 1000, 0 * k, height + 0 * k, 0 * k]) for height in (0, 900, 1400)])
savemat("qtm.mat", {"trial0001": {"Frames": 20.0, "FrameRate": 50.0, "Trajectories": {
    "Labeled": {"Count": 3.0, "Labels": cell_of("ANK", "HIP", "C7"), "Data": labelled}},
    "Analog": {"Frequency": 500.0, "Labels": cell_of("com_sway", "EMG"), "Data": numpy.vstack([numpy.repeat(sway, 10)] * 2)}}})
blocks = numpy.concatenate([sway, tilt, 2 * sway, tilt])
savemat("labchart.mat", {"data": blocks[None, :], "datastart": numpy.array([[1.0, 41.0], [21.0, 61.0]]),
                         "dataend": numpy.array([[20.0, 60.0], [40.0, 80.0]]), "titles": rows_of("Sway", "Platform"),
                         "samplerate": numpy.array([[50.0, 25.0], [50.0, 25.0]]), "unittext": rows_of("deg"),
                         "unittextmap": numpy.ones((2, 2)), "blocktimes": numpy.array([1.0, 2.0]), "tickrate": 50.0})
savemat("acqknowledge.mat", {"data": numpy.column_stack([sway, tilt]), "labels": rows_of("Sway", "Platform"),
                             "units": rows_of("deg", "deg"), "isi": 20.0, "isi_units": "ms", "start_sample": 0.0})

# Version 7.3 as h5py writes it: the names of the classes without a null at their end, or none at all.
try:
    import h5py  # Debian's python3-h5py 3.7; the others need none
except ImportError:
    raise SystemExit("v73_h5py.mat is not made: there is no h5py")
with h5py.File("v73_h5py.mat", "w", userblock_size=512) as file:
    for name, values in (("time", time), ("COM_x", sway), ("tilt_deg", tilt)):
        file.create_dataset(name, data=values[None, :])
    file["time"].attrs["MATLAB_class"] = numpy.bytes_("double")
    file["COM_x"].attrs.create("MATLAB_class", numpy.array("double", dtype="S16"))
with open("v73_h5py.mat", "r+b") as file:
    file.write(b"MATLAB 7.3 MAT-file, written by h5py".ljust(116) + bytes(8) + b"\x00\x02IM")
