"""`strategies` lists what is installed, and checks one."""

from importlib.metadata import version


def test_list(command):
    answer = command("strategies")
    assert answer.code == 0
    assert answer.err == ""
    (line,) = [line for line in answer.out.splitlines() if line.split()[:1] == ["compass"]]
    assert "stereorecal-compass" in line
    assert version("stereorecal-compass") in line
    assert "host" in line
    assert "Compass (pattern) search" in line


def test_check(command):
    answer = command("strategies", "check", "compass")
    assert answer.code == 0
    lines = answer.out.splitlines()
    assert len(lines) >= 8
    assert all(line.startswith("pass  ") for line in lines)


def test_a_broken_one_is_listed_with_the_reason(command, install):
    install("stereorecal.strategies", {"shaky": "no_such_module:Thing"})
    answer = command("strategies")
    assert answer.code == 3
    assert "Compass (pattern) search" in answer.out
    assert "cannot be loaded" in answer.out
    answer = command("strategies", "check", "shaky")
    assert (answer.code, answer.out) == (3, "")
    assert answer.err.count("\n") == 1
    assert "cannot be loaded" in answer.err


def test_a_failing_check_is_1(command, moody):
    answer = command("strategies", "check", "moody")
    assert answer.code == 1
    assert "FAIL  climbs a smooth bowl: " in answer.out
    assert "pass  travels" in answer.out
