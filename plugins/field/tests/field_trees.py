"""Small folders in the layouts of MODD2, MODS and Middlebury."""

from collections.abc import Callable
from pathlib import Path

from trees import write_image, write_text

OPENCV_STEREO = """%YAML:1.0
---
M1: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 21., 0., 11.5, 0., 21.5, 7.25, 0., 0., 1. ]
D1: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ -3.0e-01, 1.0e-01, 1.0e-03, -2.0e-03,
       1.5e-02 ]
M2: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 20., 0., 12.5, 0., 20.5, 8.25, 0., 0., 1. ]
D2: !!opencv-matrix
   rows: 1
   cols: 4
   dt: d
   data: [ -2.0e-01, 5.0e-02, 0., 1.0e-03 ]
R: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 0.99995, 0.0, -0.0099998, 0., 1., 0., 0.0099998, 0.,
       0.99995 ]
T: !!opencv-matrix
   rows: 3
   cols: 1
   dt: d
   data: [ -356., 2.5, -1.25 ]
imageSize: [ 24, 16 ]
"""


def marked(folder: Path, names: list[str], seed: int = 0) -> None:
    for index, name in enumerate(names):
        write_image(folder / f"{name}L.jpg", seed + 2 * index)
        write_image(folder / f"{name}R.jpg", seed + 2 * index + 1)


def modd2_sequence(folder: Path, frames: int = 2) -> Path:
    marked(folder / "frames", [f"{25 + index:08d}" for index in range(frames)])
    marked(folder / "framesRectified", [f"{25 + index:08d}" for index in range(frames)], seed=100)
    write_text(folder / "imu" / "00000025.txt", "0.01 0.02")
    write_text(folder / "calibration.yaml", OPENCV_STEREO)
    return folder


def modd2(root: Path) -> Path:
    for name in ("kope67-00-00000025-00000200", "kope71-01-00000040-00000340"):
        modd2_sequence(root / "video_data" / name)
    (root / "annotationsV2" / "kope67-00-00000025-00000200").mkdir(parents=True)
    return root


def mods(root: Path) -> Path:
    for name in ("kope100-00006790-00007090", "kope100-00011830-00012500"):
        marked(root / "sequences" / name / "frames", ["00006790", "00006800"])
    marked(root / "sequences" / "stru02-00118250-00118800", ["00118250"])  # without a folder frames
    write_text(root / "calibration" / "calibration-kope100.yaml", OPENCV_STEREO)
    write_text(root / "calibration" / "calibration-stru02.yaml", OPENCV_STEREO.replace("-356.", "-300."))
    return root


MIDDLEBURY = """cam0=[21.5 0 10.25; 0 21.5 7.5; 0 0 1]
cam1=[21.5 0 12.75; 0 21.5 7.5; 0 0 1]
doffs=2.5
baseline=193.001
width=24
height=16
ndisp=12
isint=0
vmin=1
vmax=10
dyavg=0
dymax=0
"""


def middlebury_scene(folder: Path, seed: int = 0) -> Path:
    write_image(folder / "im0.png", seed, colour=True)
    write_image(folder / "im1.png", seed + 1, colour=True)
    write_image(folder / "im1E.png", seed + 2, colour=True)
    write_text(folder / "calib.txt", MIDDLEBURY)
    return folder


def middlebury(root: Path) -> Path:
    for seed, name in enumerate(("Adirondack", "Motorcycle")):
        middlebury_scene(root / "trainingQ" / name, 10 * seed)
    return root / "trainingQ"


FIELD_TREES: dict[str, Callable[[Path], Path]] = {
    "modd2": modd2,
    "modd2 sequence": lambda root: modd2_sequence(root / "kope67-00-00000025-00000200"),
    "mods": mods,
    "middlebury": middlebury,
    "middlebury scene": lambda root: middlebury(root) / "Motorcycle",
}
