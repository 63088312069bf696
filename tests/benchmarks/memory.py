"""Does a long recording need more memory than a short one, and fifty recordings more than five? Peak memory.

Makes a scene folder (hard links to the images of one pair) and a video of both sides, and runs `recalibrate` on each,
in processes of their own; then `recalibrate_many` of recordings of one rig, with its intrinsics free, of one pair and
of eight.

    python tests/benchmarks/memory.py
"""

import os
import tempfile
import time
from pathlib import Path

import cv2
import numpy as np
from processes import first_cores, last_line

from stereorecal.io import save_scene
from stereorecal.synthetic import default_rig, render

SIZE, FRAMES, RECORDINGS = (320, 240), 10_000, 50
_PEAK = "print(int(next(x for x in open('/proc/self/status') if x.startswith('VmHWM')).split()[1]) // 1024)"
COMMAND = f"import sys; from stereorecal.cli import main; main(sys.argv[1:]); {_PEAK}"
MANY = f"""
import sys, jax
import stereorecal as sr
from stereorecal.synthetic import decalibrate, default_rig, render
count, frames = map(int, sys.argv[1:])
rig = default_rig().resized({SIZE})
scenes = [render("harbour", seed, rig=rig, frames=frames) for seed in range(5)]
bad = [decalibrate(rig, jax.random.key(n), 0.3, 0.003) for n in range(count)]
several = [sr.Scene(str(n), bad[n], scenes[n % 5].pairs) for n in range(count)]
sr.recalibrate_many(several, free=("extrinsics", "intrinsics"))
{_PEAK}
"""


def made_folder(folder: Path, frames: int) -> Path:
    save_scene(render("harbour", 0, rig=default_rig().resized(SIZE)), folder)
    for side in ("left", "right"):
        first = folder / side / "000000.png"
        first.parent.mkdir()
        (folder / f"{side}.png").rename(first)
        for number in range(1, frames):
            os.link(first, folder / side / f"{number:06d}.png")
    return folder


def made_video(path: Path, folder: Path, frames: int) -> Path:
    sides = [cv2.imread(str(folder / side / "000000.png")) for side in ("left", "right")]
    both = np.concatenate(sides, axis=1)
    video = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 30.0, both.shape[1::-1])
    for _ in range(frames):
        video.write(both)
    video.release()
    return path


def peak(code: str, *words: object) -> tuple[int, float]:
    """Megabytes and seconds."""
    began = time.monotonic()
    megabytes = int(last_line("-c", code, *words, cores=first_cores(64)))
    return megabytes, time.monotonic() - began


def told(what: str, few: str, many: str, peaks: tuple[tuple[int, float], tuple[int, float]]) -> None:
    (first, _), (second, seconds) = peaks
    print(f"{what}: {first} MB {few}, {second} MB {many} ({second - first:+d}), in {seconds:.0f} s", flush=True)


def main() -> None:
    found: dict[str, list[tuple[int, float]]] = {}
    with tempfile.TemporaryDirectory() as place:
        for frames in (10, FRAMES):
            folder = made_folder(Path(place) / f"{frames}", frames)
            video = made_video(Path(place) / f"{frames}.avi", folder, frames)
            loose = ["--side-by-side", video, "--calibration", folder / "calib.json"]
            for name, given in (("a folder", [folder]), ("a video", loose)):
                found.setdefault(name, []).append(peak(COMMAND, "recalibrate", *given, "--quiet"))
    for name, (few, many) in found.items():
        told(f"recalibrate, {name}", "at 10 frames", f"at {FRAMES}", (few, many))
    for frames in (1, 8):
        few, many = (peak(MANY, count, frames) for count in (5, RECORDINGS))
        told(f"recalibrate_many, {frames} pairs each", "of 5 recordings", f"of {RECORDINGS}", (few, many))


if __name__ == "__main__":
    main()
