"""Texts of calibration files: parsed, and changed in place. One module per syntax, which knows nothing of the keys.

Each has `parsed(text)`, the keys and plain values (matrices as the file has them), and `with_values(text, values)`, the
same text with other values: `{("cam1", "T_cn_cnm1"): [[…], …]}`. Keys that are not named keep theirs, comments and
order included where the syntax has them.
"""
