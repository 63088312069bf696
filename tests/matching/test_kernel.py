"""Where the compiled search comes from; what it finds is tested where it is, in plugins/native."""

import sys
from types import ModuleType

import pytest
from parts_of_estimates import _kernel

GROUP = "stereorecal.kernels"


@pytest.fixture
def has_kernel(nothing_installed):
    """Asked anew, as in another process."""
    return _kernel.has_kernel.__wrapped__


def test_none_is_installed(has_kernel, caplog):
    assert not has_kernel()
    assert not caplog.records


def test_one_is_registered(has_kernel, install, monkeypatch):
    calls, module = [], ModuleType("some_kernel")
    module.register = lambda: calls.append("registered")
    monkeypatch.setitem(sys.modules, "some_kernel", module)
    install(GROUP, {_kernel.CALL: "some_kernel:register"})
    assert has_kernel()
    assert calls == ["registered"]


def test_one_of_another_contract_is_none(has_kernel, install, caplog):
    install(GROUP, {"stereorecal_sad_of_another_year": "some_kernel:register"})
    assert not has_kernel()
    assert not caplog.records


def test_one_that_cannot_be_loaded_is_reported(has_kernel, install, caplog):
    install(GROUP, {_kernel.CALL: "kernel_that_is_not_there:register"})
    assert not has_kernel()
    assert "kernel_that_is_not_there:register is not used (ModuleNotFoundError" in caplog.text
