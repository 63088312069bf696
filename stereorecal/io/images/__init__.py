"""Images: finding, reading and writing image files, and which of them are the left and right image of a pair.

A new kind of image file goes into `_files.py`; a new rule by which the names of partners correspond into `_match.py`;
`_pairs.py` has `load_pair` and `load_pairs`, which users call.
"""
