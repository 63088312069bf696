"""A rig, and calibration files as other programs write them, with keys and comments of their own."""

import numpy as np

from stereorecal.geometry import Camera, StereoRig

SIZE = (64, 48)
MATRIX = np.array([[61.25, 0.0, 31.5], [0.0, 60.75, 23.25], [0.0, 0.0, 1.0]])
LENS = np.array([-0.3, 0.1, 0.001, -0.002])


def rig_of(extrinsics, lens=LENS, matrix=MATRIX) -> StereoRig:
    right = np.array(matrix) + np.array([[0.5, 0, 1.0], [0, 0.25, -0.5], [0, 0, 0]])
    return StereoRig(Camera(SIZE, matrix, lens), Camera(SIZE, right, np.array(lens) * 0.9), np.array(extrinsics, float))


RIG = rig_of([0.01, -0.02, 0.03, -0.12, 0.001, -0.002])

OPENCV = """%YAML:1.0
---
# calibrated on the quay
M1: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 61.25, 0., 31.5, 0., 60.75, 23.25, 0., 0., 1. ]
D1: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ -3.0000000000000000e-01, 1.0000000000000001e-01, 0.001,
       -0.002, 0. ]
M2: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 61.75, 0., 32.5, 0., 61., 22.75, 0., 0., 1. ]
D2: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ -0.27, 0.09, 0.0009, -0.0018, 0. ]
imageSize: [ 64, 48 ]
R: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 1., 0., 0., 0., 1., 0., 0., 0., 1. ]
T: !!opencv-matrix
   rows: 3
   cols: 1
   dt: d
   data: [ -120., 1., -2. ]   # mm
R1: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 1., 0., 0., 0., 1., 0., 0., 0., 1. ]
Q: !!opencv-matrix
   rows: 4
   cols: 4
   dt: f
   data: [ 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1. ]
boat: "Ladja"   # ours
reprojection: 0.25
"""

ROS = """image_width: 64
image_height: 48
camera_name: narrow_stereo/{side}
camera_matrix:
  rows: 3
  cols: 3
  data: [{focal}, 0.0, 31.5, 0.0, 60.75, 23.25, 0.0, 0.0, 1.0]
distortion_model: plumb_bob   # as ever
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.3, 0.1, 0.001, -0.002, 0.0]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
projection_matrix:
  rows: 3
  cols: 4
  data: [60.0, 0.0, 32.0, {shift}, 0.0, 60.0, 24.0, 0.0, 0.0, 0.0, 1.0, 0.0]
binning_x: 1
roi:
  x_offset: 0
  do_rectify: false
"""
ROS_PAIR = (ROS.format(side="left", focal=61.25, shift=0.0), ROS.format(side="right", focal=61.5, shift=-7.2))

ROS_1_MESSAGE = """header: 
  seq: 41
  stamp: 
    secs: 1403636579
    nsecs: 763555526
  frame_id: "{side}_camera"
height: 48
width: 64
distortion_model: "plumb_bob"
D: [-0.3, 0.1, 0.001, -0.002, 0.0]
K: [{focal}, 0.0, 31.5, 0.0, 60.75, 23.25, 0.0, 0.0, 1.0]
R: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
P: [60.0, 0.0, 32.0, {shift}, 0.0, 60.0, 24.0, 0.0, 0.0, 0.0, 1.0, 0.0]
binning_x: 0
roi: 
  x_offset: 0
  do_rectify: False
---
"""  # noqa: W291
ROS_1_MESSAGES = (
    ROS_1_MESSAGE.format(side="left", focal=61.25, shift=0.0),
    ROS_1_MESSAGE.format(side="right", focal=61.5, shift=-7.2),
)


def as_ros_2(text: str) -> str:
    """With small letters, and a line for each number."""
    rows = []
    for line in text.splitlines():
        key, opened, numbers = line.partition(": [")
        rows += [f"{key.lower()}:", *(f"- {one}" for one in numbers[:-1].split(", "))] if opened else [line]
    return "\n".join(rows) + "\n"


KALIBR = """cam0:
  T_cam_imu:
  - [0.0, -1.0, 0.0, 0.1]
  - [1.0, 0.0, 0.0, 0.2]
  - [0.0, 0.0, 1.0, 0.3]
  - [0.0, 0.0, 0.0, 1.0]
  cam_overlaps: [1]
  camera_model: pinhole
  distortion_coeffs: [-0.3, 0.1, 0.001, -0.002]
  distortion_model: radtan
  intrinsics: [61.25, 60.75, 31.5, 23.25]
  resolution: [64, 48]
  rostopic: /cam0/image_raw
  timeshift_cam_imu: 1.5e-05
cam1:
  T_cam_imu:
  - [0.0, -1.0, 0.0, -0.02]
  - [1.0, 0.0, 0.0, 0.2]
  - [0.0, 0.0, 1.0, 0.3]
  - [0.0, 0.0, 0.0, 1.0]
  T_cn_cnm1:
  - [1.0, 0.0, 0.0, -0.12]
  - [0.0, 1.0, 0.0, 0.001]
  - [0.0, 0.0, 1.0, -0.002]
  - [0.0, 0.0, 0.0, 1.0]
  cam_overlaps: [0]
  camera_model: pinhole
  distortion_coeffs: [-0.3, 0.1, 0.001, -0.002]
  distortion_model: radtan
  intrinsics: [61.75, 61.0, 32.5, 22.75]
  resolution: [64, 48]
  rostopic: /cam1/image_raw   # the right one
  timeshift_cam_imu: -2.0e-05
"""

EUROC = """#Default imu sensor yaml file
sensor_type: camera
comment: VI-Sensor {name} (MT9M034)

# Sensor extrinsics wrt. the body-frame.
T_BS:
  cols: 4
  rows: 4
  data: [0.0, -1.0, 0.0, {x},
         1.0, 0.0, 0.0, {y},
         0.0, 0.0, 1.0, 0.0098,
         0.0, 0.0, 0.0, 1.0]

rate_hz: 20
resolution: [64, 48]
camera_model: pinhole
intrinsics: [61.25, 60.75, 31.5, 23.25] #fu, fv, cu, cv
distortion_model: radial-tangential
distortion_coefficients: [-0.3, 0.1, 0.001, -0.002]
"""
EUROC_PAIR = (EUROC.format(name="cam0", x=-0.02, y=-0.06), EUROC.format(name="cam1", x=-0.021, y=0.06))

BOOFCV = """# Intrinsic and extrinsic parameters for a stereo camera pair
left:
  pinhole: {fx: 61.25, fy: 60.75, cx: 31.5, cy: 23.25, width: 64, height: 48, skew: 0.0}
  model: pinhole_radial_tangential
  radial_tangential:
    radial:
    - -0.3
    - 0.1
    t1: 0.001
    t2: -0.002
model: stereo_camera
rightToLeft:
  rotation:
  - 1.0
  - 0.0
  - 0.0
  - 0.0
  - 1.0
  - 0.0
  - 0.0
  - 0.0
  - 1.0
  x: 120.0
  y: 0.9
  z: -0.9
right:
  pinhole:
    fx: 61.75
    fy: 61.0
    cx: 32.5
    cy: 22.75
    width: 64
    height: 48
    skew: 0.0
  model: pinhole_radial_tangential
  radial_tangential:
    radial: [-0.3, 0.1]
    t1: 0.0
    t2: 0.0   # small
"""

KITTI_RAW = """calib_time: 09-Jan-2012 13:57:47
corner_dist: 9.950000e-02
S_00: 6.400000e+01 4.800000e+01
K_00: 6.125000e+01 0.0 3.150000e+01 0.0 6.075000e+01 2.325000e+01 0.0 0.0 1.0
D_00: -3.0e-01 1.0e-01 1.0e-03 -2.0e-03 0.0
R_00: 1.0 0.0 0.0 0.0 1.0 0.0 0.0 0.0 1.0
T_00: 2.573699e-16 -1.059758e-16 1.614870e-16
S_01: 6.400000e+01 4.800000e+01
K_01: 6.175000e+01 0.0 3.250000e+01 0.0 6.100000e+01 2.275000e+01 0.0 0.0 1.0
D_01: -3.0e-01 1.0e-01 1.0e-03 -2.0e-03 0.0
R_01: 1.0 0.0 0.0 0.0 1.0 0.0 0.0 0.0 1.0
T_01: -1.2e-01 1.0e-03 -2.0e-03
"""
MIDDLEBURY = """cam0=[61.25 0 31.5; 0 61.25 23.25; 0 0 1]
cam1=[61.25 0 34.5; 0 61.25 23.25; 0 0 1]
doffs=3
baseline=193.001
width=64
height=48
ndisp=70
isint=0
"""
KITTI_ODOMETRY = """P0: 6.1e+01 0.0 3.15e+01 0.0 0.0 6.1e+01 2.3e+01 0.0 0.0 0.0 1.0 0.0
P1: 6.1e+01 0.0 3.15e+01 -7.32e+00 0.0 6.1e+01 2.3e+01 0.0 0.0 0.0 1.0 0.0
Tr: 1.0 0.0 0.0 0.5 0.0 1.0 0.0 0.0 0.0 0.0 1.0 0.0
"""
BASALT = """{
    "value0": {
        "T_imu_cam": [
            {"px": -0.017, "py": -0.069, "pz": 0.005, "qx": -0.0072, "qy": 0.0075, "qz": 0.7012, "qw": 0.7129},
            {"px": -0.015, "py": 0.051, "pz": 0.003, "qx": -0.0072, "qy": 0.0075, "qz": 0.7012, "qw": 0.7129}
        ],
        "intrinsics": [
            {"camera_type": "pinhole-radtan8", "intrinsics": {"fx": 61.25, "fy": 60.75, "cx": 31.5, "cy": 23.25,
             "k1": -0.3, "k2": 0.1, "p1": 0.001, "p2": -0.002, "k3": 0.0, "k4": 0.0, "k5": 0.0, "k6": 0.0,
             "rpmax": 2.5}},
            {"camera_type": "pinhole-radtan8", "intrinsics": {"fx": 61.75, "fy": 61.0, "cx": 32.5, "cy": 22.75,
             "k1": -0.3, "k2": 0.1, "p1": 0.001, "p2": -0.002, "k3": 0.0, "k4": 0.0, "k5": 0.0, "k6": 0.0,
             "rpmax": 2.5}}
        ],
        "resolution": [[64, 48], [64, 48]],
        "calib_accel_bias": [0.1, 0.2],
        "imu_update_rate": 200.0,
        "cam_time_offset_ns": 12345678901234567,
        "vignette": [{"value0": 1, "value1": [0.5, 0.25]}]
    }
}
"""
