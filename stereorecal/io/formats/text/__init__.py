"""Texts of calibration files: parsed, and changed in place. One module per syntax, which knows no keys.

Each has `parsed(text)`, the keys and plain values (matrices as in the file), and `with_values(text, values)`, the text
with new values such as `{("cam1", "T_cn_cnm1"): [[…], …]}`. All other values, comments and the order stay.
"""
