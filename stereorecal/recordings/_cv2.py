"""OpenCV, or one sentence that says why it cannot be used.

Four distributions (`opencv-python`, `-headless`, `-contrib`, `-contrib-headless`) install the one package `cv2` over
each other: the one installed last works, and removing any of them leaves an empty folder.
"""

_LEAST = (4, 13)
_REMEDY = "run: pip install --force-reinstall opencv-python-headless"

try:
    import cv2 as cv2
except ImportError as error:
    raise ImportError(f"OpenCV cannot be imported ({error}); {_REMEDY}", name="cv2") from error

_found = getattr(cv2, "__version__", None)
if _found is None:
    raise ImportError(f"OpenCV was removed in part, as happens where two of its packages were; {_REMEDY}", name="cv2")
if tuple(map(int, _found.split(".")[:2])) < _LEAST:
    raise ImportError(f"OpenCV {_found} is too old: it must be 4.13 or newer; {_REMEDY}", name="cv2")
