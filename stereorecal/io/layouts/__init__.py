"""Data sets: one module per layout, that is, per arrangement of folders and file names.

A new layout is one new module with what `Layout` says: here, with its place in the list in `_load_data_set.py`, where
`load_log` and `load_scene` are, or in a distribution, with an entry point `stereorecal.layouts` that names the module.
It finds the files, pairs the images (`load_matched`), reads the calibration (`read_files`), and makes a log of them
(`log_of`).
"""

from stereorecal.io.formats._format import Hints as Hints
from stereorecal.io.formats._load_rig import read_files as read_files
from stereorecal.io.images._image_files import natural_order as natural_order
from stereorecal.io.images._load_pairs import load_matched as load_matched
from stereorecal.io.images._match_by_name import Matched as Matched, by_stem as by_stem, match_keys as match_keys
from stereorecal.io.layouts._data_sets import Sequence as Sequence, log_of as log_of
from stereorecal.io.layouts._load_data_set import Layout as Layout
