"""Data sets: one module per layout, that is, per arrangement of folders and file names.

A new layout is one new module here, with what `_layout.py` says (`LAYOUT`, `recognises`, `read`), and its place in the
list in `_load_data_set.py`, where `load_log` and `load_scene` are. It finds the files, pairs the images (`io/images`),
reads the calibration with a module of `io/formats`, and makes a log of them (`_log_of_sequences.py`).
"""
