"""What the judges of truth.py share: what methods are given, and verdicts on what they return."""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jax
import numpy as np
from real_scenes import rig_of
from recorded import NEED, Case, Errors
from rich.table import Table
from tables import show
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
    """The options of the command line."""

    methods: Sequence[str]
    degrees: float
    draws: int
    record: Path | None = None

    def tasks(self, name: str, scenes: Sequence[sr.Scene]) -> Iterator[Task]:
        """From the stored rig, or from some that have drifted."""
        stored = rig_of(scenes[0])
        if not self.degrees:
            yield Task(name, stored, stored, scenes)
            return
        for draw in range(self.draws):
            drifted = sr.synthetic.decalibrate(stored, jax.random.key(draw), self.degrees, 0.009 * self.degrees)
            yield Task(f"{name} #{draw}", stored, drifted, scenes)

    def answers(self, task: Task, bench: str, judge: Callable[[sr.StereoRig], Errors]) -> Iterator[tuple[str, Answer]]:
        """The answers of the methods; those of the library can be recorded, with a judge."""
        for method in self.methods:
            began = time.perf_counter()
            answer = METHODS[method](task.start, task.scenes)
            print(f"{task.name} | {method} | {answer.verdict} | {time.perf_counter() - began:.1f} s", flush=True)
            if answer.solution is not None and method == "library":
                kind = f"truth-{bench}" + (f"-from-{self.degrees}" if self.degrees else "")
                Case.of(kind, task.name, answer.solution, judge).record(self.record)
            yield method, answer


@dataclass(frozen=True, eq=False)
class Judge:
    """What is measured of a rig, and what is made of that.

    Attributes:
        bench, recorded: as what cases are recorded, and who judges them there.
        measured: of a rig.
        cells: of the table, of what was measured of the start and of a rig.
        worse: whether a rig is, than the start.
        need: epipolar error of the start, pixels.
        stored: what was measured of the stored rig, if "below stored" is said.
    """

    bench: str
    recorded: Callable[[sr.StereoRig], Errors]
    measured: Callable[[sr.StereoRig], Any]
    cells: Callable[[Any, Any], Sequence[str]]
    worse: Callable[[Any, Any], bool]
    need: Callable[[Any], float]
    stored: Any = None


class Verdicts:
    """A table with a line for each rig, and how many are accepted, harmful, worse than the stored one, and missed, for
    each method."""

    def __init__(self, table: Table) -> None:
        self.table = table
        self.seen: dict[str, list[tuple[bool, bool, bool, bool]]] = {}

    def judge(self, options: Options, task: Task, judge: Judge) -> list[Any]:
        """Meet the answers of all methods; what was measured of the accepted ones."""
        before, accepted = judge.measured(task.start), []
        if task.start is not task.stored and judge.stored is not None:
            self.table.add_row(task.name, "start", "", *judge.cells(before, before))
        for method, answer in options.answers(task, judge.bench, judge.recorded):
            for label, rig in answer.judged.items():
                after = judge.measured(rig)
                below = judge.stored is not None and judge.worse(judge.stored, after)
                said = self.add(method, answer, label, judge.worse(before, after), below, judge.need(before))
                cells = (*judge.cells(before, after), *stated(answer, task.stored), said)
                self.table.add_row(task.name, f"{method} {label}", answer.verdict, *cells)
                accepted += [after] if label == "accepted" else []
        return accepted

    def add(self, method: str, answer: Answer, label: str, worse: bool, below: bool, need: float) -> str:
        """Count what is accepted, or nothing being so once; the word for the table."""
        accepted, missed = label == "accepted", answer.accepted is None and need > NEED
        if accepted or answer.accepted is None:
            self.seen.setdefault(method, []).append((accepted, accepted and worse, accepted and below, missed))
        if not accepted:
            return "MISSED" if missed else "-"
        return "HARMFUL" if worse else "below stored" if below else "good"

    def finish(self, judge: str) -> None:
        """Print what a judge found."""
        show(self.table)
        for method, answers in self.seen.items():
            accepted, harmful, below, missed = np.sum(answers, axis=0)
            print(
                f"{judge}, {method}: {accepted} of {len(answers)} accepted, {harmful} of them harmful, {below} worse "
                f"than the stored rig; {missed} missed"
            )


def stated(answer: Answer, stored: sr.StereoRig) -> tuple[str, str]:
    """The candidate's yaw against the stored rig's, and the interval of depth at 30 baselines, for the table."""
    yaw, depth = "-", "-"
    if answer.yaw is not None:
        yaw = f"{answer.yaw[0] - float(np.degrees(stored.extrinsics[1])):+.3f} ± {answer.yaw[1]:.3f}"
    if answer.depth is not None:
        depth = f"{answer.depth[0]:+.0f} to {answer.depth[1]:+.0f}"
    return yaw, depth
