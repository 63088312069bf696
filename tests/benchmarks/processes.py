"""Programs that benchmarks run as processes of their own, bound to some of the cores."""

import os
import subprocess
import sys
import time
from collections.abc import Callable, Sequence


def bound_to(cores: Sequence[int]) -> Callable[[], None]:
    """What a process does first to compute on these cores."""
    return lambda: os.sched_setaffinity(0, cores)


def first_cores(number: int) -> list[int]:
    """So many of those that are there."""
    return sorted(os.sched_getaffinity(0))[:number]


def last_line(*words: object, cores: Sequence[int], **environment: str) -> str:
    """The last line that a Python program prints on some cores."""
    run = subprocess.run(
        [sys.executable, *map(str, words)],
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=bound_to(cores),
        env={**os.environ, **environment},
    )
    if run.returncode:
        raise SystemExit(run.stderr)
    return run.stdout.splitlines()[-1]


def seconds(*words: object, cores: int = 2, **environment: str) -> float:
    """The seconds that a whole Python program takes, without this shell's settings of JAX, and with modules that are
    compiled once, as installed ones are; exit code 1 is an answer."""
    left_out = ("JAX_", "PYTHONDONTWRITEBYTECODE")
    kept = {name: value for name, value in os.environ.items() if not name.startswith(left_out)}
    began = time.perf_counter()
    done = subprocess.run(
        [sys.executable, *map(str, words)],
        capture_output=True,
        check=False,
        env={**kept, **environment},
        preexec_fn=bound_to(first_cores(cores)),
    )
    if done.returncode not in (0, 1):
        raise SystemExit(done.stderr.decode())
    return time.perf_counter() - began


def memory_mb(key: str = "VmRSS") -> int:
    """The memory of this process, as /proc has it: VmRSS now, VmHWM at its peak."""
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) for line in status if line.startswith(key)) // 1024
