#!/usr/bin/env python3
"""Makes the MAT-files beside it with SciPy (Debian's python3-scipy 1.10): python3 tests/dataset/recording/mat/make.py

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
