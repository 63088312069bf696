"""Pages from templates, in which everything that is not markup is escaped."""

import base64
import hashlib
import json
from functools import partial
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup as Markup  # which jinja2 brings: the one that people install is missed first

from stereorecal.report.number_text import between, change, distance, number, percent


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
    environment.filters |= {one.__name__: one for one in (between, change, distance, number, percent)}
    environment.filters["json"] = partial(json.dumps, indent=1, ensure_ascii=False)
    return environment.get_template(Path(template).name).render(values)
