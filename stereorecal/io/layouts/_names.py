"""Names of folders in messages and results."""

from pathlib import Path


def name_of(folder: Path) -> str:
    """The last two parts of a folder's path: "<parent>/<folder>"."""
    return "/".join(folder.resolve().parts[-2:]).lstrip("/")
