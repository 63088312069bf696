"""Calibration files: one module per format.

A new format is one new module here, with a `FORMAT` as `_format.py` describes it, and its place in the list in
`_format_list.py`. It works in the file's own unit and knows its keys and its direction. What it cannot hold, it refuses
with a sentence that names a format that can.

- Texts are parsed, and changed in place, by `text/`; each value is read by `_numbers.py`.
- `_read_rig.py` finds the format, converts the unit, and lets the rig remember its file (`_rig_file.py`);
  `_write_rig.py` writes into a copy of that file, or of a blank one, and reads what it wrote.
- What files hold beside the calibration is computed anew in `_rectification_matrices.py`.
- Whatever is wrong with a file is an `InputError` of one sentence that names the file (`io/_read_files.py`) and the
  key; a camera model that is not supported is an `UnsupportedModelError`.

`_load_and_save.py` has `load_rig` and `save_rig`, which users call. Which files a data set has, and where, is known in
`io/layouts`.
"""
