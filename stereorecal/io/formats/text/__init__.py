"""Texts of calibration files: one module per syntax, which knows no keys. It says which values a text has, and, of those
that are written, where they stand: a tree of nodes (`_nodes.py`), into whose places other values go.
"""
