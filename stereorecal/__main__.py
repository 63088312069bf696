"""`python -m stereorecal`, and the command `stereorecal`."""

import os
import sys


def run() -> None:
    """Run the command line; the process ends with its exit code."""
    from stereorecal._signals import end_at_once, ignore
    from stereorecal._standard_streams import secure

    end_at_once()  # before anything that takes time
    secure()
    from stereorecal.cli import INTERRUPTED, main

    code = main()
    ignore()
    if code == INTERRUPTED:  # everything is said and saved: threads that still work are not waited for
        os._exit(code)
    sys.exit(code)


if __name__ == "__main__":
    run()
