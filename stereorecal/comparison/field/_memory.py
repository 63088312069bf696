"""How much memory something takes at most."""

import ctypes
import gc
from contextlib import suppress
from pathlib import Path

_STATUS, _RESET = Path("/proc/self/status"), Path("/proc/self/clear_refs")


class PeakMemory:
    """Around a piece of work: how much more memory was resident at most than before it, on Linux.

    What an earlier piece of work left to be used again counts for neither.
    """

    def __enter__(self) -> "PeakMemory":
        self.mebibytes: float | None = None
        gc.collect()
        with suppress(OSError, AttributeError):  # no glibc
            ctypes.CDLL("libc.so.6").malloc_trim(0)
        self._before = None
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
