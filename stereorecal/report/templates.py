"""Pages from templates, in which everything that is not markup is escaped; and settings as rows of a table."""

import base64
import hashlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup as Markup  # which jinja2 brings: the one that people install is missed first

from stereorecal.report.number_text import between, change, count, distance, number, percent


def rendered(template: str | Path, *, script: Path | None = None, **values: Any) -> str:
    """The page of a template: one of this folder, or a file that may include them. It has the text of its script, and
    the hash by which it allows that one and no other."""
    if script is not None:
        text = script.read_text(encoding="utf-8")
        digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode("ascii")
        values |= {"script": Markup(text), "script_hash": digest}
    environment = Environment(
        loader=FileSystemLoader([Path(__file__).parent, Path(template).parent]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {one.__name__: one for one in (between, change, count, distance, number, percent)}
    return environment.get_template(Path(template).name).render(values)


def flat_settings(settings: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, str]]:
    """Nested settings as a flat list of names, such as "matcher block_size", and values."""
    for key, value in settings.items():
        if isinstance(value, Mapping):
            yield from flat_settings(value, f"{above}{key} ")
        else:
            parts = value if isinstance(value, list) else ["-" if value is None else value]
            yield above + key, "; ".join(_inline(part) if isinstance(part, Mapping) else str(part) for part in parts)


def _inline(settings: Mapping[str, Any]) -> str:
    return ", ".join(f"{name} {value}" for name, value in flat_settings(settings))
