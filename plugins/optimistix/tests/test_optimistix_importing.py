"""What a run needs is imported late; where that fails, a sentence says so."""

import sys

import numpy as np
import pytest
from stereorecal_optimistix import Adam

from stereorecal.strategies import Objective, StrategyError, run_strategy


def test_a_library_that_is_missing_ends_a_run_with_a_sentence(strategy_class, problem, monkeypatch):
    for name in ("_loop", "_simplex"):
        monkeypatch.setitem(sys.modules, f"stereorecal_optimistix.{name}", None)
    with pytest.raises(StrategyError, match=r"\(stereorecal-optimistix .*\) cannot import .*Error.*; reinstall"):
        run_strategy(strategy_class(), Objective(problem()), np.zeros(3))


def test_adam_alone_needs_optax(problem, monkeypatch):
    monkeypatch.setitem(sys.modules, "stereorecal_optimistix._adam", None)
    with pytest.raises(StrategyError, match=r"optimistix-adam .* cannot import .*_adam"):
        run_strategy(Adam(), Objective(problem()), np.zeros(3))


def test_a_library_that_breaks_while_it_is_imported_is_no_crash_of_the_strategy(problem, tmp_path, monkeypatch):
    (tmp_path / "optax.py").write_text("import jax\njax.NoLongerThere")
    monkeypatch.syspath_prepend(tmp_path)
    for name in ("stereorecal_optimistix._adam", "optax"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    with pytest.raises(StrategyError, match=r"optimistix-adam .* cannot import .*no attribute 'NoLongerThere'"):
        run_strategy(Adam(), Objective(problem()), np.zeros(3))
