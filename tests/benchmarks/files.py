"""From a calibration file and back: does `recalibrate` give every format the rig that a scene folder gets?

Each raw scene's calibration is written in each format that can hold it and disturbed there by a degree; `recalibrate`
starts from that file, beside the scene's images, and from a scene folder with the same calibration. Printed: by how
much the rigs in the files that come back differ (radians, and parts of the baseline).

    STEREORECAL_DATA=folder python tests/benchmarks/files.py [--scenes A,B] [--formats A,B] [--schedule default|count]
"""

import argparse
import contextlib
import io
import os
import shutil
import tempfile
from importlib.util import find_spec
from pathlib import Path

import numpy as np

import stereorecal as sr
from stereorecal.cli import main

SCENES = (
    "boofcv_bumblebee2/garden01",
    "boofcv_bumblebee2/stones01",
    "boofcv_bumblebee2/sundial01",
    "boofcv_bumblebee2/chair01",
    "simplestereo/guitar_room",
    "simplestereo/ukulele_wall",
    "euroc/vicon_room_seq",
    "drobotics_wide/office_050",
)
FILES = {
    "opencv": ("a.yaml",),
    "opencv-xml": ("a.xml",),
    "opencv-json": ("a.json",),
    "ros": ("left.yaml", "right.yaml"),
    "kalibr": ("camchain.yaml",),
    "kitti-raw": ("calib_cam_to_cam.txt",),
    "euroc": ("cam0.yaml", "cam1.yaml"),
    "basalt": ("calibration.json",),
    "depthai": ("oak.json",),
    "boofcv": ("stereo.yaml",),
    "stereorecal": ("calib.json",),
}
DRIFT = np.radians([0.6, -0.5, 0.6, 0.0, 0.0, 0.0])  # one degree in all


def images(folder: Path, side: str) -> Path:
    return folder / side if (folder / side).is_dir() else next(folder.glob(f"{side}.*"))


def run(*words: object) -> int:
    with contextlib.redirect_stdout(io.StringIO()):
        return main([str(word) for word in words])


def difference(one: sr.StereoRig, other: sr.StereoRig) -> float:
    apart = one.extrinsics - other.extrinsics
    return float(np.abs(np.concatenate([apart[:3], apart[3:] / float(other.baseline)])).max())


def unit_of(format: str) -> str | None:
    """New files that say none are in metres."""
    return "m" if format in ("opencv", "boofcv") else None


def start_of(name: str, rig: sr.StereoRig, files: list[Path]) -> str:
    """Write the disturbed rig through the format; says why not, or nothing."""
    place = files[0] if len(files) == 1 else tuple(files)
    try:
        sr.io.save_rig(rig, place, format=name)
        kept = sr.io.load_rig(*files, unit=unit_of(name))
        sr.io.save_rig(kept.with_extrinsics(rig.extrinsics + DRIFT), place, overwrite=True)
    except sr.InputError as error:
        return str(error).rpartition(": ")[2]
    return ""


def read_by_depthai(path: Path, rig: sr.StereoRig) -> str:
    """What DepthAI's own reader finds, where it is installed."""
    if find_spec("depthai") is None:
        return ""
    import json

    import depthai  # pyright: ignore[reportMissingImports]

    handler = depthai.CalibrationHandler.fromJson(json.loads(path.read_text()))
    sockets = depthai.CameraBoardSocket.CAM_B, depthai.CameraBoardSocket.CAM_C
    motion = np.array(handler.getCameraExtrinsics(*sockets))
    apart = np.abs(motion[:3, 3] / 100 - rig.translation).max()
    return f", depthai's reader: {apart:.1e} m apart"


def one_format(name: str, scene: Path, rig: sr.StereoRig, expected: sr.StereoRig, code: int, words: list) -> str:
    with tempfile.TemporaryDirectory() as temporary:
        format, files = name.partition("-xml")[0].partition("-json")[0], [Path(temporary) / f for f in FILES[name]]
        refused = start_of(format, rig, files)
        if refused:
            return f"cannot hold it ({refused})"
        sides = ("--left", images(scene, "left"), "--right", images(scene, "right"))
        new = [path.with_name(f"new-{path.name}") for path in files]
        place = ("--output", ",".join(map(str, new)))
        unit = ("--unit", unit_of(format)) if unit_of(format) else ()
        found = run("recalibrate", *sides, "--calibration", *files, *unit, *place, *words)
        if found != code or not new[0].exists():
            return f"exit code {found}, from the scene folder {code}"
        again = sr.io.load_rig(*new, unit=unit_of(format))
        apart = difference(again, expected)
        extra = read_by_depthai(new[0], again) if format == "depthai" else ""
        return f"{apart:.1e} {'ok' if apart < 1e-6 else 'DIFFERS'}{extra}"


def one_scene(name: str, formats: list[str], words: list[str]) -> None:
    scene = Path(os.environ["STEREORECAL_DATA"]) / name
    rig = sr.io.load_scene(scene, limit=1).rig
    assert rig is not None
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary) / "scene"
        shutil.copytree(scene, folder)
        sr.io.save_rig(rig.with_extrinsics(rig.extrinsics + DRIFT), folder / "calib.json", overwrite=True)
        output = Path(temporary) / "repaired.json"
        code = run("recalibrate", folder, "--output", output, *words)
        if not output.exists():
            print(f"{name}: exit code {code} on the scene folder, nothing to compare with")
            return
        expected = sr.io.load_rig(output)
    for format in formats:
        print(f"{name:32} {format:12} {one_format(format, scene, rig, expected, code, words)}", flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", default=",".join(SCENES))
    parser.add_argument("--formats", default=",".join(FILES))
    parser.add_argument("--schedule", default="default")
    parser.add_argument("--frames", default="1")
    options = parser.parse_args()
    common = ["--schedule", options.schedule, "--frames", options.frames, "--quiet"]
    for scene in options.scenes.split(","):
        one_scene(scene, options.formats.split(","), common)
