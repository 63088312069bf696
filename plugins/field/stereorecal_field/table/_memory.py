"""How much memory something takes at most."""

import ctypes
import gc
import threading
from contextlib import suppress
from pathlib import Path

_STATUS, _RESET = Path("/proc/self/status"), Path("/proc/self/clear_refs")


class PeakMemory:
    """Around a piece of work: how much more memory was resident at most than before it, on Linux.

    What an earlier piece of work left to be used again counts for neither. Threads share the memory of their process:
    outside the main thread, where others may work beside it, nothing is measured. Executors of threads and Dask work
    there; serial runs and pools of processes do not.
    """

    def __enter__(self) -> "PeakMemory":
        self.mebibytes: float | None = None
        self._before = None
        if threading.current_thread() is not threading.main_thread():
            return self
        gc.collect()
        with suppress(OSError, AttributeError):  # no glibc
            ctypes.CDLL("libc.so.6").malloc_trim(0)
        with suppress(OSError, ValueError):  # no Linux, or not allowed
            _RESET.write_text("5")
            self._before = _kibibytes("VmRSS")
        return self

    def __exit__(self, *_: object) -> None:
        if self._before is not None:
            with suppress(OSError, ValueError):
                self.mebibytes = max(0.0, (_kibibytes("VmHWM") - self._before) / 1024.0)


def _kibibytes(name: str) -> int:
    for line in _STATUS.read_text().splitlines():
        if line.startswith(f"{name}:"):
            return int(line.split()[1])
    raise ValueError(name)
