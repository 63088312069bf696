"""What an import costs: nothing is loaded before it is asked for; names mean the same after any order of imports."""

import subprocess
import sys

import pytest

import stereorecal as sr

OF_OTHERS = {"scipy", "xml.etree.ElementTree", "matplotlib", "rerun", "rich", "jinja2", "distributed"}
OF_OTHERS |= {"stereorecal.comparison", "stereorecal.cli"}  # what a repair and its files need not
HEAVY = {"jax", "cv2", "numpy", "stereorecal.scoring"} | OF_OTHERS


def said(code: str) -> str:
    done = subprocess.run([sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_nothing_is_loaded_before_it_is_asked_for():
    """In one process: what is loaded stays loaded."""
    steps = (
        "import sys, stereorecal as sr",
        "import stereorecal.strategies as s; s.overview()",
        "from stereorecal import SAD, health, io, recalibrate; io.load_rig",
    )
    loaded = [set(line.split()) for line in said("; print(*sys.modules)\n".join([*steps, ""])).splitlines()]
    assert not HEAVY & loaded[0]
    # The libraries behind the plug-ins are imported by a run. nlopt may be: it takes a few milliseconds.
    assert {f"stereorecal_{name}" for name in ("compass", "features", "nlopt", "optimistix")} <= loaded[1]
    assert not {"equinox", "optimistix", "optax", "lineax", "stereorecal.objectives"} & loaded[1]
    assert "jax" in loaded[2]
    assert not OF_OTHERS & loaded[2]


@pytest.mark.slow(after=2)
@pytest.mark.parametrize(
    "imports",
    [
        "import stereorecal as sr",
        "import stereorecal.strategies; import stereorecal as sr",
        "import stereorecal as sr; sr.strategies(); import stereorecal.strategies",
        "import stereorecal.strategies as s; s(); import stereorecal as sr",
        "from stereorecal import strategies; strategies(); import stereorecal as sr",
        "from stereorecal.strategies import strategies; import stereorecal as sr",
    ],
)
def test_strategies_is_a_function_and_a_package(imports: str):
    """Whatever was imported before it."""
    code = f"{imports}; print(sr.strategies()); import stereorecal.strategies as t; t.Budget; sr.strategies.Budget; t()"
    assert "compass" in said(code)


def test_every_public_name_is_there():
    names = {name for name in dir(sr) if getattr(sr, name) is not None}
    assert {"recalibrate", "count", "prepare", "io", "synthetic", "testing", "Budget", "strategies"} <= names
    with pytest.raises(AttributeError, match="recalibrat"):
        getattr(sr, "recalibrat")  # noqa: B009  a checker would say so
