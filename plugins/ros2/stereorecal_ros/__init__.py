"""A ROS 2 node that watches the calibration of a stereo rig, repairs it on request, and can take it back.

`_node` and `_messages` know ROS; all else is plain Python, and tested without it:

- `_pairing`: which two images belong together, by their stamps;
- `_camera_info`: a rig from two `CameraInfo`, and back; `_camera_info_files`: what files of ROS hold;
- `_applied`: which calibration is published, and what was before it;
- `_kept`: what is kept over restarts;
- `_images`: grey images from messages;
- `_given`, `_heard`: which calibration the drivers say, and which input is silent;
- `_worker`: the life of the worker process, and `_requests`, what it is asked;
- `_status`: how the rig stands, for `/diagnostics`; `_log`: lines for the log;
- `_watch`: all of it together, around it.
"""

from stereorecal_ros._applied import Applied as Applied
from stereorecal_ros._camera_info import (
    CameraInfo as CameraInfo,
    corrected as corrected,
    rig_of as rig_of,
    view_of as view_of,
)
from stereorecal_ros._kept import Kept as Kept
from stereorecal_ros._log import Level as Level
from stereorecal_ros._pairing import LEFT as LEFT, MOST as MOST, RIGHT as RIGHT, Pairing as Pairing
from stereorecal_ros._settings import Settings as Settings
from stereorecal_ros._status import Status as Status
from stereorecal_ros._watch import Watch as Watch
