"""Real scenes, of the folder STEREORECAL_DATA (default: ../shared/data beside the checkout)."""

import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import stereorecal as sr

CHECKOUT = Path(__file__).resolve().parents[2]
DATA = Path(os.environ.get("STEREORECAL_DATA", CHECKOUT / "../shared/data"))
BUMBLEBEE = tuple(f"boofcv_bumblebee2/{name}" for name in ("garden01", "stones01", "sundial01", "chair01"))


def present(*names: str) -> bool:
    """Whether all of these are at hand; says which are not."""
    missing = [str(DATA / name) for name in names if not (DATA / name).exists()]
    if missing:
        print(f"skipped: {', '.join(missing)} not there")
    return not missing


def real(names: Sequence[str] | Mapping[str, int], limit: int | None = 1) -> Iterator[sr.Scene]:
    """Those of the scenes that are at hand, with so many frames each, or as many as is said for each."""
    for name in names:
        if present(name):
            yield sr.io.load_scene(DATA / name, limit=names[name] if isinstance(names, Mapping) else limit)


def rig_of(scene: sr.Scene) -> sr.StereoRig:
    """The rig that must be there."""
    assert scene.rig is not None
    return scene.rig
