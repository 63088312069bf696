"""Reading and writing files: image pairs, calibrations, scenes, logs of missions, JSON.

- `formats/`: calibration files, one module per format.
- `layouts/`: data sets, one module per arrangement of folders and files.
- `images/`: image files, and which of them are the left and right image of a pair.

A module of a layout finds the files; formats and images read them. Whatever is wrong with input is an `InputError` of
one sentence that names the file and says what to do; what users call lists them under Raises.
"""

import stereorecal.recordings  # noqa: F401 - says in one sentence what is wrong with OpenCV
from stereorecal._arrays import json_data as json_data
from stereorecal.io._atomic import (
    back_up as back_up,
    make_folder as make_folder,
    next_copy as next_copy,
    write_bytes as write_bytes,
    write_files as write_files,
    write_text as write_text,
)
from stereorecal.io._read_files import about as about, files_read as files_read
from stereorecal.io._scenes import bag_scene as bag_scene, calibrated_scene as calibrated_scene
from stereorecal.io._strict_json import (
    json_line as json_line,
    json_text as json_text,
    parse_json as parse_json,
    read_json as read_json,
    write_json as write_json,
)
from stereorecal.io._tables import load_odometer as load_odometer, load_ranges as load_ranges
from stereorecal.io.formats._load_rig import has_own_unit as has_own_unit, load_rig as load_rig
from stereorecal.io.formats._matrix_search import save_template as save_template
from stereorecal.io.formats._save_rig import (
    calibration_files as calibration_files,
    calibration_json as calibration_json,
    check_savable as check_savable,
    prior_beside as prior_beside,
    save_maps as save_maps,
    save_rig as save_rig,
    unit_read as unit_read,
    unsaid_unit as unsaid_unit,
)
from stereorecal.io.images._bags import image_of_message as image_of_message
from stereorecal.io.images._image_files import IMAGE_SUFFIXES as IMAGE_SUFFIXES, write_png as write_png
from stereorecal.io.images._load_pairs import load_pair as load_pair
from stereorecal.io.images._open_pairs import Recorded as Recorded, load_pairs as load_pairs, open_pairs as open_pairs
from stereorecal.io.images._videos import camera_pairs as camera_pairs
from stereorecal.io.layouts._load_data_set import (
    is_data_set as is_data_set,
    load_log as load_log,
    load_scene as load_scene,
)
from stereorecal.io.layouts._own_folders import save_scene as save_scene
