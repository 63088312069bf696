"""`python -m stereorecal`."""

import sys

from stereorecal.cli import main

if __name__ == "__main__":
    sys.exit(main())
