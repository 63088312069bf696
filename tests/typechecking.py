"""The run-time type checker of the test suite: beartype, with an int where a float is asked for (PEP 484).

The first calls of each test are checked, whichever functions they go to. A search asks thousands of times the same
way, and checking all of them takes ten times as long as the search. Functions within functions are not checked: they
are made at each call of the outer one, and their checks would be made anew as well, a sixth of all the suite's time.
"""

import ast
from collections.abc import Callable
from functools import wraps
from typing import Any

import pytest
from beartype import BeartypeConf, beartype
from jaxtyping import _import_hook, config

_beartype = beartype(conf=BeartypeConf(is_pep484_tower=True))
_left = [0]  # checks of this test


class _Outermost(_import_hook.JaxtypingTransformer):
    """Marks functions of modules and methods for checking, and not what is within them."""

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.FunctionDef:
        within, node.body = node.body, []
        super().visit_FunctionDef(node)
        node.body = within
        return node


_import_hook.JaxtypingTransformer = _Outermost  # pyright: ignore[reportPrivateImportUsage]


def outermost(function: Callable[..., Any]) -> Callable[..., Any]:
    """Check what goes in and out of `function`, and count down. The check is made when it is needed first."""
    looks: list[Callable[..., Any]] = []

    @wraps(function)
    def counted(*arguments: Any, **options: Any) -> Any:
        _left[0] -= 1
        if not _left[0]:
            config.update("jaxtyping_disable", True)
        if not looks:
            looks.append(_beartype(function))
        return looks[0](*arguments, **options)

    return counted


@pytest.fixture
def unchecked() -> None:
    """As users have it: what is of another type meets the library's own words."""
    config.update("jaxtyping_disable", True)


def pytest_runtest_setup(item: pytest.Item) -> None:
    """A test begins, and checks with it: a thousand take a tenth of a second."""
    _left[0] = 1000 if item.config.option.slow else 200
    config.update("jaxtyping_disable", False)
