"""The type of a path that users give."""

import os

AnyPath = str | os.PathLike[str]
