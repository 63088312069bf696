"""Judges: methods compared by data that none of them sees; and the layouts of data sets of research.

- `judges`: what says how good a calibration is.
- `table`: methods x judged cases, and the page of it.
- `layouts`: MODD2, MODS, Middlebury.
"""
