"""Followed while every angle walks: the protocol of TESO (CVPR 2026) on rendered drives.

    python tests/benchmarks/walk.py [--drives N] [--first SEED] [--frames N]

Every angle of the right camera moves by up to 0.01 degrees from one pair to the next, evenly drawn; images of 1024x512
with 70 degrees of view, a baseline of one metre; intrinsics are exact, and a trigger opens both shutters. Mean |error|
of the angles: of the calibration that was given at the start, of the rig in use, and of the filter's estimate, over all
pairs; processor time a step. A pair takes a second or two to render, and is kept in the user's cache.
"""

import time

import numpy as np
from stereorecal_field.judges import walked
from tables import command_line, show, table_of

from stereorecal.online import Config, run
from stereorecal.synthetic import Drive, photographs

STEP = 0.01  # degrees a pair
TOURS = ("street", "harbour")
WALKS = Config(prior="exact", synchronous=True, wander=(STEP / np.sqrt(3.0),) * 3, heating=(0.0, 0.0, 0.0), rest=0)


def followed(drive: Drive) -> tuple[np.ndarray, list[float]]:
    """|Errors| of the angles in degrees (n, 3, 3) of the rig that was given, the one in use, and the estimate, and the
    seconds of each step."""
    errors, seconds, steps = [], [], run(drive.rig, photographs(drive), WALKS)
    for frame in range(len(drive)):
        began = time.process_time()
        state = next(steps).state
        seconds.append(time.process_time() - began)
        truth = state.offset_of(drive.truth(frame))[:3]
        errors.append(np.abs([-truth, state.using[:3] - truth, state.offset[:3] - truth]))
    return np.array(errors), seconds


def main() -> None:
    """Render, follow, print."""
    parser = command_line(__doc__)
    parser.add_argument("--drives", type=int, default=2)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--frames", type=int, default=200)
    options = parser.parse_args()
    heads = "drive | pairs | not followed: pitch, yaw, roll | rig in use | estimate | ms a step, median"
    table = table_of(heads, title="mean |error|, degrees")
    for seed in range(options.first, options.first + options.drives):
        tour = TOURS[seed % len(TOURS)]
        errors, seconds = followed(walked(tour, seed, options.frames))
        said = [" ".join(f"{one:.4f}" for one in of_rig) for of_rig in errors.mean(axis=0)]
        table.add_row(f"{tour} {seed}", f"{len(errors)}", *said, f"{1000 * np.median(seconds):.0f}")
    show(table)


if __name__ == "__main__":
    main()
