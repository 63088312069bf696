"""Calibration files: one module per format.

A new format is one new module here, with what `_format.py` says (`NAME`, `can_read`, `read`, `blank`, `write`), and its
place in the list in `_registry.py`. It works in the file's own unit and knows its keys and its direction; it says what
it cannot hold in a sentence that names a format that can.

- Texts are parsed, and changed in place, by `text/`; each value is read by `_numbers.py`.
- `_reading.py` finds the format, converts the unit, and lets the rig remember its file (`_source.py`); `_writing.py`
  writes into a copy of that file, or of a blank one, and reads what it wrote.
- What files hold beside the calibration is computed anew in `_derived.py`.
- Whatever is wrong with a file is an `InputError` of one sentence that names the file (`io/_about.py`) and the key; a
  camera model that is not supported is an `UnsupportedModelError`.

`_rigs.py` has `load_rig` and `save_rig`, which users call. Which files a data set has, and where, is not known here:
see `io/layouts`.
"""
