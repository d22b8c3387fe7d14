#!/usr/bin/env python3
"""Makes the workbook beside it with openpyxl (Debian's python3-openpyxl 3.0.9).

A sway of k / 8 degrees, k = 1..20, at 50 Hz with a missing cell in row 8, a column of words and one of true and false, a second sheet.
"""
import os

import openpyxl

os.chdir(os.path.dirname(os.path.abspath(__file__)))
book = openpyxl.Workbook()
sheet = book.active
sheet.append(["time (s)", "sway (deg)", "note", "ok"])
for k in range(1, 21):
    sheet.append([(k - 1) / 50, None if k == 7 else k / 8, "a & b <c>" if k == 3 else None, k % 2 == 0])
book.create_sheet("other").append([1, 2])
book.save("openpyxl.xlsx")
