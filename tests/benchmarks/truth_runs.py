"""What the judges of truth.py share: what methods are given, verdicts on what they return, tables."""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import jax
import numpy as np
from recorded import NEED, Case, Errors
from rich.console import Console
from rich.table import Table
from truth_methods import METHODS, Answer

import stereorecal as sr


@dataclass(frozen=True, eq=False)
class Task:
    """What methods are given: recordings of one rig, and where to start."""

    name: str
    stored: sr.StereoRig
    start: sr.StereoRig
    scenes: Sequence[sr.Scene]


@dataclass(frozen=True)
class Options:
    """Of the command line."""

    methods: tuple[str, ...]
    degrees: float
    draws: int
    only: tuple[str, ...]
    record: Path | None = None

    def wants(self, name: str) -> bool:
        return not self.only or any(part in name for part in self.only)

    def tasks(self, name: str, stored: sr.StereoRig, scenes: Sequence[sr.Scene]) -> Iterator[Task]:
        """From the stored rig, or from some that have drifted."""
        if not self.degrees:
            yield Task(name, stored, stored, scenes)
            return
        for draw in range(self.draws):
            drifted = sr.synthetic.decalibrate(stored, jax.random.key(draw), self.degrees, 0.009 * self.degrees)
            yield Task(f"{name} #{draw}", stored, drifted, scenes)

    def answers(self, task: Task, bench: str, judge: Callable[[sr.StereoRig], Errors]) -> Iterator[tuple[str, Answer]]:
        """Of each method; those of the library can be recorded, with a judge."""
        for method in self.methods:
            began = time.perf_counter()
            answer = METHODS[method](task.start, task.scenes)
            print(f"{task.name} | {method} | {answer.verdict} | {time.perf_counter() - began:.1f} s", flush=True)
            if answer.solution is not None and method == "library":
                kind = f"truth-{bench}" + (f"-from-{self.degrees}" if self.degrees else "")
                Case.of(kind, task.name, answer.solution, judge).record(self.record)
            yield method, answer


class Tally:
    """How many rigs are accepted, harmful, worse than the stored one, and missed, for each method."""

    def __init__(self) -> None:
        self.seen: dict[str, list[tuple[bool, bool, bool, bool]]] = {}

    def add(self, method: str, answer: Answer, label: str, worse: bool, below: bool, need: float) -> str:
        """Count what is accepted, or nothing being so once; the word for the table.

        Args:
            worse, below: than the start, and than the stored rig.
            need: row error of the start, pixels.
        """
        accepted, missed = label == "accepted", answer.accepted is None and need > NEED
        if accepted or answer.accepted is None:
            self.seen.setdefault(method, []).append((accepted, accepted and worse, accepted and below, missed))
        if not accepted:
            return "MISSED" if missed else "-"
        return "HARMFUL" if worse else "below stored" if below else "good"

    def show(self, judge: str) -> None:
        for method, answers in self.seen.items():
            accepted, harmful, below, missed = np.sum(answers, axis=0)
            words = (
                f"{accepted} of {len(answers)} accepted, {harmful} of them harmful, {below} worse than the stored rig; "
                f"{missed} missed"
            )
            print(f"{judge}, {method}: {words}")


def stated(answer: Answer, stored: sr.StereoRig) -> tuple[str, str]:
    """The candidate's yaw against the stored rig's, and the interval of depth at 30 baselines, for the table."""
    yaw, depth = "-", "-"
    if answer.yaw is not None:
        yaw = f"{answer.yaw[0] - float(np.degrees(stored.extrinsics[1])):+.3f} ± {answer.yaw[1]:.3f}"
    if answer.depth is not None:
        depth = f"{answer.depth[0]:+.0f} to {answer.depth[1]:+.0f}"
    return yaw, depth


def rig_of(scene: sr.Scene) -> sr.StereoRig:
    """The rig that must be there."""
    assert scene.rig is not None
    return scene.rig


def table_of(title: str, left: Sequence[str], right: Sequence[str]) -> Table:
    """With columns of words, and of numbers."""
    table = Table(title=title, title_justify="left", box=None)
    for head in left:
        table.add_column(head, no_wrap=True)
    for head in right:
        table.add_column(head, justify="right")
    return table


def finish(table: Table, tally: Tally, judge: str) -> None:
    """Print what a judge found."""
    Console(width=230).print(table)
    tally.show(judge)
