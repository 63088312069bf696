"""The documentation as a site: `python -m sphinx -W -n docs build/site`."""

import enum
import inspect
import os
import re

import stereorecal
from stereorecal.cli import parser

os.environ["COLUMNS"] = "88"  # of what `--help` says
project = "stereorecal"
author = copyright = "The stereorecal authors"  # Sphinx reads it under this name
version = release = stereorecal.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
exclude_patterns = ["conftest.py"]
html_theme = "furo"
html_title = f"stereorecal {version}"
myst_heading_anchors = 4  # links such as method.md#the-soft-count, as repository pages have them

# Docstrings are Google's, types stand in the signatures, and what a class holds is told in its own docstring.
autodoc_default_options = {"members": True, "imported-members": True}
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
autodoc_typehints_format = "short"
napoleon_use_ivar = True
napoleon_use_rtype = False
default_role = "code"  # `name` in a docstring, as in Markdown
python_use_unqualified_type_names = True
suppress_warnings = ["ref.python"]  # one name of two classes

# Strict about our own public names; what other libraries call theirs, and shapes in types, lead nowhere.
nitpick_ignore_regex = [
    ("py:.*", r"(jax|jaxlib|jaxtyping|numpy|ndarray|collections|concurrent|cv2|matplotlib|os|pathlib|types|rich)\b.*"),
    ("py:.*", r"'.*"),
    ("py:.*", r".*\[.*"),
    ("py:exc", "NeedNotMet"),
    ("py:.*", r"stereorecal\w*(\.\w+)*\._\w+\.\w+"),  # what one is given, and never makes
]


def _said_already(app, what, name, member, skip, options):
    """On the page of a package: what is public at the top has its place on the page of the library."""
    top = {id(getattr(stereorecal, known)) for known in dir(stereorecal)}
    return True if options.imported_members and id(member) in top else skip


def _as_written(app, what, name, member, options, lines):
    """After Napoleon: a property's "What it is: more" names no type, "left, right: …" are two names of one kind, and
    |x| is a magnitude, not a substitution."""
    if what == "class" and issubclass(member, enum.Enum):
        lines += ["", *(f"- `{one.name}`: {one.value if isinstance(one.value, str) else ''}" for one in member), ""]
    if what == "property":
        lines[:] = [*(inspect.getdoc(member) or "").splitlines(), ""]
    for index, line in enumerate(lines):
        field = re.match(r":(ivar|param) ([\w, ]+):", line)
        names = field[0].replace(", ", ",") if field else ""
        lines[index] = (names + line[len(names) + field[0].count(", ") :] if field else line).replace("|", r"\|")


def _with_help(app, page, source):
    """On the page of the command line: what `--help` says of each command."""
    if page == "reference/command-line":
        commands = next(action.choices for action in parser()._actions if action.metavar == "COMMAND")
        helps = (f"### `{name}`\n\n```text\n{one.format_help()}```\n" for name, one in commands.items())
        source[0] += "\n" + "\n".join(helps)


def setup(app):
    """Sphinx calls it."""
    app.connect("source-read", _with_help)
    app.connect("autodoc-skip-member", _said_already)
    app.connect("autodoc-process-docstring", _as_written, priority=900)
