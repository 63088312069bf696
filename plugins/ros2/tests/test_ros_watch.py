"""What the node publishes, and what it never does; without ROS, around a worker that is a stand-in."""

from concurrent.futures import Future
from pathlib import Path

import numpy as np
import pytest
from robots import BEST, BETTER, AtOnce
from stereorecal_ros import LEFT, RIGHT, Level, corrected

from stereorecal.online import Event, Kind


def test_a_calibration_waits_until_it_is_applied_and_can_be_taken_back(blank):
    one = blank()
    assert one.watch.corrected is None
    assert not one.watch.apply()[0]
    one.calibrate()
    one.see()
    given = one.watch.corrected
    assert [a.is_like(b) for a, b in zip(given, corrected(one.rig), strict=True)] == [True, True]
    one.accept(BETTER)
    assert one.watch.corrected == given
    status = one.watch.status()
    assert "waits for ~/apply" in status.message
    done, said = one.watch.apply()
    assert done
    assert one.turned() == pytest.approx(0.1, abs=0.01)
    assert one.watch.corrected != given
    assert "->" in said
    assert one.said("applied", said)
    assert not one.watch.apply()[0]
    done, _ = one.watch.roll_back()
    assert done
    one.see()
    assert one.turned() == pytest.approx(0.0, abs=1e-9)
    assert not one.watch.settings.repair
    assert not one.work.state.config.repair
    np.testing.assert_array_equal(one.work.state.using, np.zeros(5))
    assert "waits" not in one.watch.status().message
    assert not one.watch.roll_back()[0]


def test_auto_apply_applies_what_is_accepted_and_nothing_after_a_roll_back(robot):
    one = robot(auto_apply=True)
    one.accept(BETTER)
    assert one.turned() == pytest.approx(0.1, abs=0.01)
    one.watch.roll_back()
    one.see()
    one.accept(BEST)  # as a recalibration on request would
    assert one.turned() == pytest.approx(0.0, abs=1e-9)
    one.watch.set(repair=True)
    one.see()
    assert one.turned() == pytest.approx(0.2, abs=0.01)
    assert one.said("repair: False -> True")


def test_what_is_taken_back_does_not_come_back_while_the_worker_is_busy(robot):
    one = robot(auto_apply=True)
    one.accept(BETTER)
    one.work.slow = True
    one.watch.roll_back()
    one.see()
    one.watch.set(repair=True)
    one.see()
    assert not one.watch.apply()[0]
    assert one.turned() == pytest.approx(0.0, abs=1e-9)
    assert "waits" not in one.watch.status().message
    one.work.slow = False
    one.see()
    assert one.turned() == pytest.approx(0.0, abs=1e-9)


def test_a_roll_back_beyond_what_the_state_keeps(robot):
    """The worker takes back all its switches, of which most were never published."""
    one = robot()
    one.accept(BETTER)
    one.watch.apply()
    for _ in range(9):
        one.accept(BEST)
    one.work.state = one.work.state.replace(previous=one.work.state.previous[-8:])
    assert one.watch.roll_back()[0]
    one.see()
    np.testing.assert_array_equal(one.work.state.using, np.zeros(5))
    assert not one.work.state.config.repair
    assert "waits" not in one.watch.status().message
    one.watch.set(auto_apply=True, repair=True)
    one.see()
    assert one.turned() == pytest.approx(0.0, abs=1e-9)


def test_two_quick_roll_backs(robot):
    """The first answer of the worker is not the last."""
    one = robot(auto_apply=True)
    one.accept(BETTER)
    one.accept(BEST)
    one.work.slow = True
    assert one.watch.roll_back()[0]
    assert one.watch.roll_back()[0]
    one.watch.set(repair=True)
    one.work.state, events = one.work.waiting.pop(0)(one.work.state)  # back at the better one
    one.work.events += events
    one.see()
    assert one.turned() == pytest.approx(0.0, abs=1e-9)
    assert not one.watch.apply()[0]
    one.work.slow = False
    one.see(2)
    assert one.turned() == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_array_equal(one.work.state.using, np.zeros(5))
    one.accept(BETTER)  # what comes later is applied again
    assert one.turned() == pytest.approx(0.1, abs=0.01)


def test_auto_apply_switched_on_later(robot):
    one = robot()
    one.accept(BETTER)
    one.watch.set(auto_apply=True)
    assert one.turned() == pytest.approx(0.1, abs=0.01)


@pytest.mark.parametrize("kind", [kind for kind in Kind if kind is not Kind.REPAIRED], ids=lambda kind: kind.name)
def test_no_event_alone_changes_what_is_published(robot, kind: Kind):
    one = robot(auto_apply=True)
    one.work.events.append(Event(3, kind, "why"))
    one.see()
    assert one.turned() == pytest.approx(0.0, abs=1e-9)


def test_the_driver_gives_what_was_applied(robot):
    """As it does after `set_camera_info`, one camera after the other: nothing begins anew."""
    one = robot()
    one.accept(BETTER)
    one.watch.apply()
    applied = one.watch.rig
    one.infos[LEFT] = corrected(applied)[LEFT]
    one.see(40)  # a driver that takes its time, or refuses: half of it is no calibration
    assert len(one.works) == 1
    assert one.turned() == pytest.approx(0.1, abs=0.01)
    assert one.said("halves of two calibrations")
    one.infos[RIGHT] = corrected(applied)[RIGHT]
    one.see(30)
    assert len(one.works) == 1
    assert not one.said("another calibration")


def test_another_calibration_begins_anew_once_it_has_settled(robot, tmp_path: Path):
    one = robot()
    other = one.rig.with_extrinsics(one.rig.extrinsics + np.array([0.02, 0, 0, 0, 0, 0]))
    one.calibrate(other)
    one.see(5)
    assert len(one.works) == 1
    one.see(30)
    one.see()
    assert one.works[0].closed
    assert one.said("another calibration is given", "->")
    assert one.said("another calibration than the given one", "node.state.bak")
    np.testing.assert_allclose(one.watch.rig.extrinsics, other.extrinsics, atol=1e-9)
    assert (tmp_path / "node.state.bak").exists()


def test_a_driver_that_is_given_the_old_calibration_back(robot):
    """What was applied and saved was not wanted: the one that is given last wins."""
    one = robot()
    one.accept(BETTER)
    one.watch.apply()
    one.watch.asked_to_save()
    one.accept(BEST)
    one.watch.apply()  # before the drivers have told what they took
    one.calibrate(one.works[0].state.rig_at(BETTER))
    one.see(40)
    assert one.turned() == pytest.approx(0.2, abs=0.01)
    assert len(one.works) == 1
    one.calibrate(one.rig)
    one.see(40)
    assert len(one.works) == 2
    assert one.turned() == pytest.approx(0.0, abs=1e-9)
    assert one.said("another calibration is given", "->")
    assert not one.watch.roll_back()[0]


def test_what_was_applied_is_published_though_no_process_starts(robot, blank, monkeypatch: pytest.MonkeyPatch):
    one = robot()
    one.accept(BETTER)
    one.watch.apply()
    one.watch.close()
    two = blank()
    with monkeypatch.context() as patch:
        patch.setattr(two.watch._worker, "_work", lambda *_, **__: (_ for _ in ()).throw(OSError("no memory")))
        two.calibrate()
        two.see()
    assert two.turned() == pytest.approx(0.1, abs=0.01)
    assert two.watch.corrected == one.watch.corrected
    assert two.watch.status().level is Level.ERROR
    assert "no memory" in two.watch.status().message
    two.now += 5.0  # seconds, after which another process is begun
    two.see()
    assert two.works
    assert two.watch.corrected == one.watch.corrected


class Never(AtOnce):
    """An executor that does not come to it."""

    def submit(self, act, /, *given, **named) -> Future:
        return Future()


def test_nothing_waits_for_a_process_that_is_begun(robot):
    one = robot(background=Never())
    one.see(4)
    assert one.watch.corrected is None  # something else may have been applied
    assert one.works == []
    assert one.watch.status().message == "missing: the worker process, which is being started"
    assert one.watch.status().values["pairs dropped, which could not be followed"] == "5"
    assert one.watch.recalibrate() == (False, "there is no calibration yet; nothing to start from.")


def test_a_worker_that_exits_is_told_and_replaced(robot):
    one = robot()
    given = one.watch.corrected
    one.work.exited = True
    one.see()
    assert one.watch.status().level is Level.ERROR
    assert "worker process exited" in one.watch.status().message
    assert one.watch.corrected == given
    assert not one.watch.recalibrate()[0]
    one.now += 5.0  # seconds, after which another process is begun
    one.see()
    assert len(one.works) == 2
    assert "worker process exited" not in one.watch.status().message
