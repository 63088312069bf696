"""Texts of calibration files: one module per syntax, which knows no keys. It says which values a text has, and where
those stand that may be written: in a tree of nodes (`_nodes.py`), into whose places other values go.
"""
