"""Runs the Python blocks of every page, and compares what they print with the block `output` that follows; names carry
through a page. (The tests of pages about the shell run its commands.)"""

import re
from contextlib import redirect_stdout
from io import StringIO

from printed_output import agrees
from sybil import Example, Sybil
from sybil.evaluators.python import PythonEvaluator
from sybil.parsers.markdown import CodeBlockParser

_PRINTED = "printed_by_the_last_block"
_evaluate = PythonEvaluator()


def run(example: Example) -> None:
    """Run a block, and keep what it prints."""
    example.namespace.pop(_PRINTED, None)
    with redirect_stdout(StringIO()) as printed:
        _evaluate(example)
    example.namespace[_PRINTED] = printed.getvalue()


def compare(example: Example) -> None:
    """Compare what a page shows with what the block before has printed."""
    *_, language = re.findall(r"^```(\w+)$", example.document.text[: example.region.start], re.MULTILINE)
    if language == "python" and _PRINTED in example.namespace:  # else that block has failed, which is said
        printed = example.namespace[_PRINTED]
        assert agrees(example.parsed, printed), f"the page shows:\n{example.parsed}\nprinted was:\n{printed}"


pytest_collect_file = Sybil(
    parsers=[CodeBlockParser("python", run), CodeBlockParser("output", compare)], patterns=["*.md"]
).pytest()
