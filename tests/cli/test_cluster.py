"""`--executor dask:ADDRESS`: the same answers from a cluster, and one sentence where there is none."""

import contextlib
import json
import socket
import sys
import time
from concurrent.futures import Executor, Future, wait
from pathlib import Path
from threading import Thread

import pytest
from distributed import LocalCluster
from parts_of_repairs import _cluster

SMALL = ("--draws", 2, "--scale", 0.5, "--budget", 5)


@pytest.fixture(scope="module")
def scheduler():
    """The address of a scheduler, with a worker in this process."""
    with LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, protocol="tcp", dashboard_address=":0"
    ) as cluster:
        yield cluster.scheduler_address


@pytest.mark.parametrize("scheme", ["tcp://", pytest.param("", marks=pytest.mark.slow)])
def test_the_same_answers(command, scheduler: str, clean_scene: Path, drifted_scene: Path, scheme: str):
    """(Tutorial 6 compares in a cluster.)"""
    about = ("recalibrate", drifted_scene, clean_scene, "--schedule", "count", "--json", "-")
    address = f"dask:{scheme}{scheduler.removeprefix('tcp://')}"
    plain, spread = (command(*about, "--executor", kind) for kind in ("serial", address))
    assert (spread.code, spread.err) == (plain.code, "")
    here, there = (json.loads(answer.out)["repairs"] for answer in (plain, spread))
    assert [{**row, "seconds": None} for row in there] == [{**row, "seconds": None} for row in here]


@pytest.mark.parametrize("address", ["", "tcp://host", "carrier-pigeon://host:1", "host:door"])
def test_what_is_no_address(command, clean_scene: Path, address: str):
    answer = command("compare", "--scene", clean_scene, *SMALL, "--executor", f"dask:{address}")
    answer.refuses(f"no Dask scheduler answers at {address!r}")


def answer_in_another_language(server: socket.socket) -> None:
    with contextlib.suppress(OSError):
        connection, _ = server.accept()
        connection.sendall(b"HTTP/1.1 400 Bad Request\r\n\r\n")
        connection.close()


@pytest.mark.slow(after=1)  # the others are waited for
@pytest.mark.parametrize("who", ["another program", "nobody", "one that says nothing"])
def test_no_scheduler(command, clean_scene: Path, who: str):
    with socket.socket() as server:
        server.bind(("127.0.0.1", 0))
        if who != "nobody":
            server.listen()
        if who == "another program":
            Thread(target=answer_in_another_language, args=(server,), daemon=True).start()
        address = f"127.0.0.1:{server.getsockname()[1]}"
        began = time.monotonic()
        answer = command("compare", "--scene", clean_scene, *SMALL, "--executor", f"dask:{address}")
    assert time.monotonic() - began < 10  # one is waited for for five seconds
    answer.refuses(f"no Dask scheduler answers at '{address}'; start one with: dask scheduler")


@pytest.mark.parametrize(
    ("workers", "said"),
    [
        (1, "is a Dask worker; give the address of the scheduler"),
        (0, "has no workers; start some with: dask worker {}"),
    ],
)
def test_a_scheduler_that_cannot_serve(command, clean_scene: Path, workers: int, said: str):
    with LocalCluster(n_workers=workers, processes=False, protocol="tcp", dashboard_address=":0") as cluster:
        address = next(iter(cluster.scheduler.workers), cluster.scheduler_address)
        answer = command("compare", "--scene", clean_scene, *SMALL, "--executor", f"dask:{address}")
    answer.refuses(said.format(address))


def test_without_the_extra(command, clean_scene: Path, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    answer = command("compare", "--scene", clean_scene, *SMALL, "--executor", "dask:host:8786")
    install = "run: pip install 'stereorecal[dask]'"
    answer.refuses(f"--executor dask needs distributed, which is not installed; {install}\n")


class Stuck(Executor):
    """Finishes nothing, as Dask where a result was on its way when its worker died."""

    def submit(self, fn, /, *args, **kwargs):
        return Future()

    def shutdown(self, wait=True, *, cancel_futures=False):
        pass


def test_what_is_given_up_is_waited_for_no_longer():
    pool = _cluster._Pool(Stuck())
    future = pool.submit(print)
    pool.give_up()
    assert not wait([future], timeout=1).not_done
    assert future.cancelled()
