"""Calibration files: one module per format.

A new format is one new module here. It offers a function `load_NAME(path, ...)` that returns a `StereoRig`: OpenCV's
pinhole model, metres, `x_right = R x_left + T`. Units and conventions of the file are converted there and nowhere else.

- Text comes from `io/_text.py`, JSON from `io/_json.py`, YAML from `_file_storage.py`, each value from `_numbers.py`.
- Whatever is wrong with a file is an `InputError` of one sentence that names the file (`io/_about.py`) and the key; a
  camera model that is not supported is an `UnsupportedModelError`.

`_rigs.py` has `load_rig` and `save_rig`, which users call. Which files a data set has, and where, is not known here:
see `io/layouts`.
"""
