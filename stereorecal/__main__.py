"""`python -m stereorecal`, and the command `stereorecal`."""

import gc
import os
import sys


def run() -> None:
    """Run the command line; the process ends with its exit code."""
    from stereorecal.cli._signals import end_at_once

    end_at_once()  # before anything that takes time
    # Imports and tracing allocate much and leave little garbage: looking for it took a seventh of a repair.
    gc.set_threshold(100_000, 10, 10)
    from stereorecal.cli._streams import secure

    secure()
    from stereorecal.cli import main

    code = main()
    sys.stderr.flush()
    os._exit(code)  # everything is said and saved: threads that still work are not waited for


if __name__ == "__main__":
    run()
