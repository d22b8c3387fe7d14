# One translation unit an instruction set; only these are compiled for more than the baseline.
