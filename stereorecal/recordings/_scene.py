"""A scene: what a rig took at one place."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from stereorecal.geometry import StereoRig
from stereorecal.recordings._pair import Pair


@dataclass(frozen=True, eq=False)
class Scene:
    """A rig (None without calibration) and the pairs it took.

    Attributes:
        reference: what `rig` is worth as a reference: "truth" (synthetic) or "stored" (a calibration from a file).
        info: other facts about the scene, carried along untouched.
    """

    name: str
    rig: StereoRig | None
    pairs: tuple[Pair, ...]
    reference: str = "stored"
    info: Mapping[str, Any] = field(default_factory=dict, repr=False)
