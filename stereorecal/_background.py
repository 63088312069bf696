"""Work that runs in a background thread, one piece after the other."""

import os
import threading
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress


class _Queue:
    def __init__(self) -> None:
        self._waiting: deque[tuple[Callable[[], object], Future[None]]] = deque()
        self._lock = threading.Lock()
        self._process: int | None = None  # whose thread works: a fork has none of its parent's

    def submit(self, work: Callable[[], object]) -> Future[None]:
        """Run `work` in the background, after what was submitted before it.

        What it returns or raises is dropped; the future is done when it has ended. When the program ends, work that
        has not begun is dropped, and work under way is waited for.
        """
        done: Future[None] = Future()
        with self._lock:
            self._waiting.append((work, done))
            if self._process != os.getpid():
                self._process = os.getpid()
                threading.Thread(target=self._work, name="background").start()
        return done

    def _work(self) -> None:
        while True:
            with self._lock:
                if not self._waiting:
                    self._process = None
                    return
                work, done = self._waiting.popleft()
            try:
                if threading.main_thread().is_alive():
                    with suppress(Exception):
                        work()
            finally:
                done.set_result(None)


in_background = _Queue().submit
