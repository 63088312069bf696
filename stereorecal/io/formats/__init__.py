"""Calibration files: one module per format, or per family of small ones.

A format works in the file's own unit, refuses a rig that it cannot hold, and names one that can; `docs/CONTRIBUTING.md`
says how to add one.

- Texts are parsed, and changed in place, by `text/`; each value is read by `_numbers.py`.
- `_load_rig.py` has `load_rig`, and finds the files and their format; `_read_rig.py` makes the rig, says which camera
  is the left one, converts the unit, and lets the rig remember its file (`_rig_file.py`).
- `_save_rig.py` has `save_rig`: it writes into a copy of that file, or of a blank one, and reads what it wrote.
- `_rectification_matrices.py` computes the values that follow from the calibration.
- A bad file raises an `InputError`, one sentence that names the file (`io/_read_files.py`) and the key; a camera model
  that is not supported raises an `UnsupportedModelError`.
"""
