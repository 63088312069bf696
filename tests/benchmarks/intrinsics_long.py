"""A long recording for `intrinsics.py`: time and memory of a whole process, images read from files."""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import cv2
import numpy as np
from intrinsics_rendered import KINDS, wrong

import stereorecal as sr

FRAMES = 200
_RENDERED = 8  # the others are these with other noise and exposure


def run() -> None:
    """Write the frames, repair them on the command line, print."""
    with tempfile.TemporaryDirectory() as folder:
        _written(Path(folder))
        options = ["--free", "extrinsics,intrinsics", "--frames", "all", "--quiet"]
        command = [sys.executable, "-m", "stereorecal", "recalibrate", folder, *options]
        began = time.perf_counter()
        process = subprocess.Popen(command)
        _, status, used = os.wait4(process.pid, 0)
        seconds = time.perf_counter() - began
    print(
        f"{FRAMES} frames of 640x480, extrinsics and intrinsics: {seconds:.0f} s, {used.ru_maxrss / 1024:.0f} MB, "
        f"exit code {os.waitstatus_to_exitcode(status)}"
    )


def _written(folder: Path) -> None:
    pairs = [sr.synthetic.render(KINDS[i % 3], 10 + i).pairs[0] for i in range(_RENDERED)]
    for side in ("left", "right"):
        (folder / side).mkdir()
        for frame in range(FRAMES):
            draw = np.random.default_rng([frame, side == "right"])
            image = np.asarray(getattr(pairs[frame * _RENDERED // FRAMES], side), float)
            image = (1.0 + 0.1 * np.sin(frame)) * image + draw.normal(0.0, 2.0, image.shape)
            cv2.imwrite(str(folder / side / f"{frame:04}.png"), np.clip(image, 0, 255).round().astype(np.uint8))
    sr.io.save_rig(wrong(0), folder / "calib.json")
