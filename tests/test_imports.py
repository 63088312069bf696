"""What an import costs: nothing is loaded before it is asked for; names mean the same after any order of imports."""

import subprocess
import sys

import pytest

HEAVY = ("jax", "cv2", "scipy", "numpy", "rich", "matplotlib", "rerun", "distributed", "stereorecal.scoring")


def said(code: str) -> str:
    done = subprocess.run([sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_importing_the_library_loads_nothing_heavy():
    loaded = said("import sys, stereorecal; print(*sys.modules)").split()
    assert not set(HEAVY) & set(loaded)


def test_a_repair_and_its_files_load_no_scipy_and_no_reports():
    code = "from stereorecal import SAD, health, io, recalibrate; io.load_rig; import sys; print(*sys.modules)"
    loaded = said(code).split()
    assert "jax" in loaded
    unwanted = (
        "scipy",
        "xml.etree.ElementTree",
        "matplotlib",
        "rerun",
        "rich",
        "jinja2",
        "distributed",
        "stereorecal.comparison",
        "stereorecal.cli",
    )
    assert not set(unwanted) & set(loaded)


def test_describing_the_strategies_loads_no_optimiser():
    """The libraries behind the plug-ins are imported by a run. nlopt may be: it takes a few milliseconds."""
    code = "import sys, stereorecal.strategies as s; s.overview(); print(*sys.modules)"
    loaded = set(said(code).split())
    assert {f"stereorecal_{name}" for name in ("compass", "features", "nlopt", "optimistix")} <= loaded
    assert not {"equinox", "optimistix", "optax", "lineax", "scipy.optimize", "stereorecal.objectives"} & loaded


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
    names = said("import stereorecal as sr; print(*[n for n in dir(sr) if getattr(sr, n) is not None])").split()
    assert {"recalibrate", "count", "prepare", "io", "synthetic", "testing", "Budget", "strategies"} <= set(names)
    assert "recalibrat" in said("import stereorecal as sr\ntry: sr.recalibrat\nexcept AttributeError as e: print(e)")
