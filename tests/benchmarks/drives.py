"""How does a rig do on the vehicle? Prints the figures of simulated drives beside their targets.

    python tests/benchmarks/drives.py [--seeds N] [--frames N] [--only calm,heat,…]

Drives of 320x240 pairs whose truth is known in each frame, harbours and streets in turn, with rain, night, open sea
and things that move: calm ones (nothing but a random walk of 1e-4 degrees a frame), warm ones (ramps of heat), ones
with knocks of 0.2 to 2.5 degrees, and ones with a shutter that is late for a while. Rendered once, a quarter of a
second a pair, and kept in the user's cache. Errors are those of the rig in use.
"""

import time
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field

import cv2
import numpy as np
from tables import command_line, show, table_of, words

from stereorecal.decision import ENOUGH
from stereorecal.estimation import points_of_view, readings
from stereorecal.geometry import StereoRig, with_unit_baseline
from stereorecal.online import Config, Event, Kind, State, run
from stereorecal.recordings import Pair
from stereorecal.scoring import host, pyramid
from stereorecal.synthetic import Drive, Knock, photographs, plan_drive

CASES = ("calm", "heat", "knocks", "late")
KNOCKS = (0.2, 0.5, 1.0, 2.5)  # degrees, in turn; of yaw at least half a degree
EVERY = 60  # frames between knocks
SETTLED = 50  # frames
GOOD = np.array([0.02, 0.1, 0.02])  # degrees: repaired
HARM_ROWS = 0.02  # pixels
HARM_DEPTH = 1.0  # percentage points
ALARMS = (Kind.DRIFTING, Kind.KNOCK)


@dataclass
class Seen:
    """What a drive showed."""

    errors: list = field(default_factory=list)  # of the rig in use, each frame: pitch, yaw, roll [deg], y, z [%]
    half: list = field(default_factory=list)  # of the 95 % intervals of the estimate
    estimates: list = field(default_factory=list)  # their errors
    events: list[Event] = field(default_factory=list)
    noticed: list[int | None] = field(default_factory=list)  # informative frames that each knock took; None: never
    repaired: list[int | None] = field(default_factory=list)
    shown: list[int] = field(default_factory=list)  # informative frames from each knock to the next one, or the end
    harmful: int = 0  # switches
    switches: int = 0
    seconds: list[float] = field(default_factory=list)  # of processor time, each step


def planned(case: str, seed: int, frames: int) -> Drive:
    tour = ("harbour", "street")[seed % 2]
    if case == "knocks":
        draw = np.random.default_rng([seed, 41])
        knocks = []
        for number, frame in enumerate(range(30, frames, EVERY)):
            size, axis = KNOCKS[(number + seed) % len(KNOCKS)], int(draw.integers(3))
            turn = np.zeros(3)
            turn[axis] = float(draw.choice([-1.0, 1.0])) * (max(size, 0.5) if axis == 1 else size)
            knocks.append(Knock(frame, tuple(turn.tolist())))
        return plan_drive(tour, seed, frames, knocks=tuple(knocks))
    late = tuple((first, first + 60, 0.2) for first in range(40, frames, 160)) if case == "late" else ()
    return plan_drive(tour, seed, frames, heat=case == "heat", late=late)


def driven(drive: Drive, config: Config) -> Seen:
    seen, before, waiting = Seen(), np.zeros(5), None
    knocks = {knock.frame for knock in drive.knocks}
    steps = run(drive.rig, photographs(drive), config)
    while True:
        began = time.process_time()
        stepped = next(steps, None)
        if stepped is None:
            return seen
        seen.seconds.append(time.process_time() - began)
        state, frame = stepped.state, len(seen.errors)
        truth = state.offset_of(drive.truth(frame))
        seen.errors.append(state.using - truth)
        seen.estimates.append(state.offset - truth)
        seen.half.append(1.96 * np.sqrt(np.diag(state.of_offset)))
        seen.events.extend(stepped.events)
        if np.any(state.using != before):
            seen.switches += 1
            seen.harmful += harmful(state, state.rig_at(before), drive.truth(frame))
        before = state.using
        if frame in knocks:
            waiting = 0
            seen.noticed.append(None)
            seen.repaired.append(None)
            seen.shown.append(0)
        if waiting is not None:
            assert isinstance(stepped.pair, Pair)
            waiting += informative(drive, frame, stepped.pair, state)
            seen.shown[-1] = waiting
            if seen.noticed[-1] is None and any(event.kind in ALARMS for event in stepped.events):
                seen.noticed[-1] = waiting
            if np.all(np.abs(seen.errors[-1][:3]) <= GOOD):
                seen.repaired[-1], waiting = waiting, None


def mean_errors(errors: list) -> str:
    """Over the pairs of some drives: of each axis."""
    mean = np.abs(np.concatenate(errors)).mean(axis=0)
    return f"{mean[0]:.4f} {mean[1]:.3f} {mean[2]:.4f}°, y {mean[3]:.2f} %, z {mean[4]:.2f} %"


def harmful(state: State, before: StereoRig, true: StereoRig) -> bool:
    """Whether a switch made it worse: rows over the view by more than 0.02 pixels, or depth at 30 baselines by a point.

    Args:
        before: the calibration that was in use.
    """
    rows, depth = zip(*(effects(rig, true, state) for rig in (before, state.rig)), strict=True)
    return rows[1] > rows[0] + HARM_ROWS or depth[1] > depth[0] + HARM_DEPTH


def effects(used: StereoRig, true: StereoRig, state: State) -> tuple[float, float]:
    """The epipolar error of a calibration over the view [px], root mean square, and |error of depth| [%] at 30
    baselines."""
    rows, nearness = readings(used, true, points_of_view(true, 30.0, state.view), state.view)
    return float(np.sqrt(np.mean(rows**2))), float(abs(100.0 * (1.0 / (1.0 + np.mean(nearness)) - 1.0)))


def informative(drive: Drive, frame: int, pair: Pair, state: State) -> bool:
    """Whether correspondences at the true calibration cover a tenth of the view."""
    truth = drive.truth(frame)
    if state.matcher is None:
        return False
    data = pyramid(truth, [pair], state.view).at(1.0)
    return host.correspondences(data, with_unit_baseline(truth.extrinsics), state.matcher).covered >= ENOUGH.covered


def quantile(found: list[int | None], share: float) -> str:
    if not found:
        return "-"
    value = np.quantile([np.inf if n is None else n for n in found], share, method="higher")
    return f"{value:.0f}"


def told(found: list[tuple[int | None, int]], within: int) -> tuple[list[int | None], str]:
    """What is known of knocks, of each the frames that it took and those that there were: one that was not seen before
    images ended, or went dark, too early is left out."""
    kept = [took for took, shown in found if took is not None or shown >= within]
    dark = len(found) - len(kept)
    return kept, f"{len(kept)} knocks" + (f", {dark} more in the dark" if dark else "")


def rows(all_seen: dict[str, list[tuple[Drive, Seen]]]) -> Iterator[tuple[str, str, str]]:
    knocked = all_seen["knocks"]
    for title, wanted, target in (
        ("0.2° pitch, roll", lambda k: max(map(abs, k.degrees)) == 0.2, 3),
        ("0.5° yaw", lambda k: abs(k.degrees[1]) == 0.5, 20),
        ("others", lambda k: max(map(abs, k.degrees)) != 0.2 and abs(k.degrees[1]) != 0.5, 3),
    ):
        chosen = [(n, m) for d, s in knocked for k, n, m in zip(d.knocks, s.noticed, s.shown, strict=True) if wanted(k)]
        found, number = told(chosen, target)
        late = f"median {quantile(found, 0.5)}, most {quantile(found, 1.0)} ({number})"
        yield f"knock noticed within informative frames: {title}", str(target), late
    repaired, number = told([took for _, s in knocked for took in zip(s.repaired, s.shown, strict=True)], 50)
    often = f"{quantile(repaired, 0.5)} / {quantile(repaired, 0.95)} ({number})"
    yield "repaired within informative frames, median / 95th percentile", "10 / 50", often
    calm = [seen for case in ("calm", "late") for _, seen in all_seen[case]]
    alarms = [event for seen in calm for event in seen.events if event.kind in ALARMS]
    yield "false alarms without ramp or knock", "0", f"{len(alarms)} in {sum(len(s.errors) for s in calm)} frames"
    shifted = [sum(event.kind is Kind.SHIFTED for event in seen.events) for seen in calm]
    yield "  said to be shifted (or a late shutter)", "-", f"{sum(shifted)} times in {np.count_nonzero(shifted)} drives"
    for case in ("heat", "calm"):
        settled = [seen for _, seen in all_seen[case] if len(seen.errors) > SETTLED]
        in_use, estimated = ([getattr(seen, name)[SETTLED:] for seen in settled] for name in ("errors", "estimates"))
        if settled:
            yield f"mean error after {SETTLED} frames, {case}", "0.008 0.04 0.008°", mean_errors(in_use)
            yield "  of the estimate", "-", mean_errors(estimated)
    every = [seen for one in all_seen.values() for _, seen in one]
    yield "harmful switches", "0", f"{sum(s.harmful for s in every)} of {sum(s.switches for s in every)}"
    inside = [
        np.abs(s.estimates[SETTLED:]) <= s.half[SETTLED:] for c in ("calm", "heat") for _, s in all_seen[c] if s.errors
    ]
    if inside:
        share = np.concatenate(inside).mean(axis=0)
        yield "truth within the 95 % interval, pitch yaw roll y z", "-", " ".join(f"{v:.2f}" for v in share)
    late = [any(event.kind is Kind.LATE for event in seen.events) for _, seen in all_seen["late"]]
    yield "late shutters named", "all", f"{sum(late)} of {len(late)} drives"
    steps = np.concatenate([seen.seconds[5:] for seen in every])
    yield (
        "processor time of a step, median / 99th percentile",
        "-",
        " / ".join(f"{1e3 * np.quantile(steps, q):.0f} ms" for q in (0.5, 0.99)),
    )


def main() -> None:
    parser = command_line(__doc__)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--frames", type=int, default=200)
    parser.add_argument("--only", default=",".join(CASES))
    options = parser.parse_args()
    cv2.setNumThreads(1)
    all_seen = defaultdict(list)
    for case in words(options.only):
        for seed in range(options.seeds):
            drive = planned(case, seed, options.frames)
            seen = driven(drive, Config())
            all_seen[case].append((drive, seen))
            events = ", ".join(f"{event.frame} {event.kind.name.lower()}" for event in seen.events)
            print(f"{case} {drive.tour} {seed}: {events}", flush=True)
    table = table_of("figure | target | seen", left=3)
    for row in rows(all_seen):
        table.add_row(*row)
    show(table)


if __name__ == "__main__":
    main()
