"""Pages from templates: everything that is not markup is escaped."""

from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup as Markup  # which jinja2 brings: the one that people install is missed first

from stereorecal.report.number_text import change, count, number, percent


def rendered(template: str, **values: Any) -> str:
    """The page of a template of this folder."""
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"number": number, "count": count, "percent": percent, "change": change}
    return environment.get_template(template).render(values)
