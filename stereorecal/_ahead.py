"""Work that is begun before it is asked for, one piece after the other, in a thread beside the program."""

import os
import threading
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress


class _Beside:
    def __init__(self) -> None:
        self._waiting: deque[tuple[Callable[[], object], Future[None]]] = deque()
        self._lock = threading.Lock()
        self._process: int | None = None  # whose thread works: a fork has none of its parent's

    def begin(self, work: Callable[[], object]) -> Future[None]:
        """Begin it, after what was begun before. What it returns or raises is dropped; the future says when it is over.

        At the end of the program what waits is dropped, and what is under way is waited for.
        """
        over: Future[None] = Future()
        with self._lock:
            self._waiting.append((work, over))
            if self._process != os.getpid():
                self._process = os.getpid()
                threading.Thread(target=self._work, name="ahead").start()
        return over

    def _work(self) -> None:
        while True:
            with self._lock:
                if not self._waiting:
                    self._process = None
                    return
                work, over = self._waiting.popleft()
            try:
                if threading.main_thread().is_alive():
                    with suppress(Exception):
                        work()
            finally:
                over.set_result(None)


begin = _Beside().begin
