"""What Linux permits is used, what it does not is said with the way out; the system's answers are stood in for."""

from __future__ import annotations

import os
import sys

import pytest

from musclewire.errors import CallerError
from musclewire.rigs import _real_time as real_time

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="priority and pinning are Linux's")


class System:
    """Stands in for the C library and notes what is asked of it."""

    def __init__(self, may_lock: bool) -> None:
        self.may_lock = may_lock
        self.locked: list[int] = []

    def __call__(self, *_: object, **__: object) -> System:
        return self

    def mlockall(self, flags: int) -> int:
        self.locked.append(flags)
        return 0 if self.may_lock else -1


def refuse(*_: object) -> None:
    raise PermissionError


def test_a_core_that_is_not_there_is_refused_with_those_that_are() -> None:
    allowed = sorted(os.sched_getaffinity(0))
    with pytest.raises(CallerError, match=rf"core 4096 is not one .*\({allowed[0]}.*cpu"):
        real_time.pin_to_cpu(4096)
    assert sorted(os.sched_getaffinity(0)) == allowed


def test_where_nothing_is_permitted_each_refusal_says_what_to_change(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    monkeypatch.setattr(real_time.ctypes, "CDLL", System(may_lock=False))
    priority, memory = real_time.take_priority()
    for words in ("@realtime - rtprio", "/etc/security/limits.d/realtime.conf", "usermod -aG realtime", "log in again"):
        assert words in priority
    assert "memlock" in memory
    assert "\n" not in priority + memory


def test_where_all_is_permitted_nothing_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[int, int]] = []
    monkeypatch.setattr(os, "sched_setscheduler", lambda _, policy, how: asked.append((policy, how.sched_priority)))
    system = System(may_lock=True)
    monkeypatch.setattr(real_time.ctypes, "CDLL", system)
    assert real_time.take_priority() == []
    assert asked == [(os.SCHED_FIFO, real_time.PRIORITY)]
    assert len(system.locked) == 1


def test_scheduling_is_told_in_words(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_getscheduler", lambda _: os.SCHED_FIFO)
    monkeypatch.setattr(os, "sched_getparam", lambda _: os.sched_param(40))
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {1})
    assert real_time.scheduling() == "real-time priority 40, core 1"


@pytest.mark.parametrize("function", [lambda: real_time.pin_to_cpu(0), real_time.take_priority])
def test_other_systems_say_that_they_have_neither(monkeypatch: pytest.MonkeyPatch, function: object) -> None:
    monkeypatch.setattr(real_time.sys, "platform", "darwin")
    with pytest.raises(CallerError, match="darwin"):
        function()  # type: ignore[operator]
