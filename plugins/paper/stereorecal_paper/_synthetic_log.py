"""The synthetic mission log: rendered on demand, cached in the user's folder."""

import hashlib
from pathlib import Path

from platformdirs import user_cache_path

from stereorecal import InputError, geometry, synthetic
from stereorecal.cli import Progress
from stereorecal.io import json_line, load_log, make_folder, write_text
from stereorecal.recordings import Log
from stereorecal.synthetic import default_rig
from stereorecal_paper import _missions
from stereorecal_paper._missions import plan_missions
from stereorecal_paper._plain_log import has_mission, save_calibrations, save_mission

_QUICK_SIZE, _QUICK_PAIRS, _QUICK_MISSIONS = (256, 192), 3, 2


def synthetic_log(
    seed: int = 0, *, quick: bool = False, folder: Path | None = None, progress: Progress | None = None
) -> Log:
    """The log of `plan_missions`, as a plain log on the disk; existing sequences are not rendered again.

    Args:
        seed: draws drift and scenes.
        quick: images of 256x192, three pairs of the first two sequences.
        folder: of the log; default a folder of the user's cache, one for each edition of the renderer.
        progress: called with (finished, total) after each sequence.

    Raises:
        InputError: if the place holds something else or cannot be written to, or what is there is damaged.
    """
    if quick:
        plan = plan_missions(seed, rig=default_rig().resized(_QUICK_SIZE), most_pairs=_QUICK_PAIRS)
    else:
        plan = plan_missions(seed)
    missions = plan.missions[:_QUICK_MISSIONS] if quick else plan.missions
    if folder is None:
        size = "quick" if quick else "full"
        folder = user_cache_path("stereorecal") / "logs" / _edition() / f"missions-{seed}-{size}"
    _check_plan(folder, {"seed": seed, "quick": quick, "edition": _edition()})
    save_calibrations(plan.calibrations, folder, overwrite=True)
    for index, planned in enumerate(missions):
        if not has_mission(folder, planned.mission.name):
            save_mission(planned.photographed(), folder)
        if progress is not None:
            progress(index + 1, len(missions))
    return load_log(folder)


def _check_plan(folder: Path, plan: dict[str, object]) -> None:
    """Say in the folder which plan it holds; a folder that holds another is left alone."""
    path, text = folder / "plan.json", json_line(plan)
    make_folder(folder)
    if not path.exists() and not any(folder.iterdir()):
        write_text(path, text)
    if not path.exists() or path.read_text() != text:
        raise InputError(f"{folder}: holds something other than this log; choose another folder, or remove it.")


def _edition() -> str:
    """Changes whenever the renderer, the geometry beneath it or the plan does."""
    folders = [Path(module.__file__ or "").parent for module in (synthetic, geometry)]
    sources = [
        Path(__file__),
        Path(_missions.__file__),
        *(path for folder in folders for path in sorted(folder.rglob("*.py"))),
    ]
    return hashlib.sha256(b"".join(path.read_bytes() for path in sources)).hexdigest()[:12]
