"""stereorecal: repair the calibration of a stereo rig from ordinary images.

The public names stand in `__init__.pyi`; each is imported when it is first used.
"""

from importlib import import_module
from typing import Any

import lazy_loader

_named_in_stub, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> Any:
    # A function and a package have this name: the package, which can be called, is both.
    return import_module(f"{__name__}.{name}") if name == "strategies" else _named_in_stub(name)
