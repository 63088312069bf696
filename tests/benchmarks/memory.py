"""Does a long recording need more memory than a short one, and fifty recordings more than five? Peak memory.

Makes a scene folder (hard links to the images of one pair) and a video of both sides, and runs `score`, `recalibrate`
and `load_log` (opened, and gone through) on each, in processes of their own; then `recalibrate_many` of recordings of
one rig, with its intrinsics free, of one pair and of eight.

    python tests/benchmarks/memory.py [--frames 10000] [--size 320x240] [--recordings 50]
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import cv2
import numpy as np

from stereorecal.io import save_scene
from stereorecal.synthetic import default_rig, render

_PEAK = "print(int(next(x for x in open('/proc/self/status') if x.startswith('VmHWM')).split()[1]) // 1024)"
COMMAND = f"import sys; from stereorecal.cli import main; main(sys.argv[1:]); {_PEAK}"
LOG = f"""
import sys
from stereorecal.io import load_log
for mission in load_log(sys.argv[1]).missions:
    for pair in mission.pairs:
        pass
{_PEAK}
"""

MANY = f"""
import sys, jax
import stereorecal as sr
from stereorecal.synthetic import decalibrate, default_rig, render
count, frames, size = int(sys.argv[1]), int(sys.argv[2]), tuple(map(int, sys.argv[3].split("x")))
rig = default_rig().resized(size)
scenes = [render("harbour", seed, rig=rig, frames=frames) for seed in range(5)]
bad = [decalibrate(rig, jax.random.key(n), 0.3, 0.003) for n in range(count)]
several = [sr.Scene(str(n), bad[n], scenes[n % 5].pairs) for n in range(count)]
sr.recalibrate_many(several, free=("extrinsics", "intrinsics"))
{_PEAK}
"""


def made_folder(folder: Path, size: tuple[int, int], frames: int) -> Path:
    save_scene(render("harbour", 0, rig=default_rig().resized(size)), folder)
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
    run = [sys.executable, "-c", code, *map(str, words)]
    ended = subprocess.run(run, capture_output=True, text=True, check=False)
    if ended.returncode:
        raise SystemExit(ended.stderr)
    return int(ended.stdout.split()[-1]), time.monotonic() - began


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--frames", type=int, default=10_000)
    parser.add_argument("--size", default="320x240")
    parser.add_argument("--recordings", type=int, default=50)
    options = parser.parse_args()
    width, height = map(int, options.size.split("x"))
    place = Path(tempfile.mkdtemp())
    try:
        found: dict[str, list[tuple[int, float]]] = {}
        for frames in (10, options.frames):
            folder = made_folder(place / f"{frames}", (width, height), frames)
            video = made_video(place / f"{frames}.avi", folder, frames)
            loose = ["--side-by-side", video, "--calibration", folder / "calib.json"]
            for verb in ("score", "recalibrate"):
                found.setdefault(f"{verb}, folder", []).append(peak(COMMAND, verb, folder, "--quiet"))
                found.setdefault(f"{verb}, video", []).append(peak(COMMAND, verb, *loose, "--quiet"))
            found.setdefault("load_log, folder", []).append(peak(LOG, folder))
    finally:
        shutil.rmtree(place)
    for name, (few, many) in found.items():
        peaks = f"{few[0]} MB at 10 frames, {many[0]} MB at {options.frames}"
        print(f"{name}: {peaks} ({many[0] - few[0]:+d}), in {many[1]:.0f} s")
    for frames in (1, 8):
        few, many = (peak(MANY, count, frames, options.size) for count in (5, options.recordings))
        peaks = f"{few[0]} MB of 5 recordings, {many[0]} MB of {options.recordings}"
        print(f"recalibrate_many, {frames} pairs each: {peaks} ({many[0] - few[0]:+d}), in {many[1]:.0f} s")


if __name__ == "__main__":
    main()
