"""The command line, and what commands are made of: those of plug-ins come as entry points `stereorecal.commands`.

The public names stand in `__init__.pyi`; each is imported when it is first used.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
