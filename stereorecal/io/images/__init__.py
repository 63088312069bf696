"""Images: finding, reading and writing image files, and which of them are the left and right image of a pair.

A new kind of image file goes into `_image_files.py`; a new rule by which names of files correspond into
`_match_by_name.py`; a new source of frames (such as a video) is a `FrameSource`, opened in `_open_pairs.py`.
`_load_pairs.py` has `load_pair` and `load_pairs`, which users call.
"""
