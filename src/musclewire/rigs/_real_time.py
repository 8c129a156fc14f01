"""Real-time scheduling of a process on Linux: priority, a core of its own, locked memory, precise timers."""

from __future__ import annotations

import ctypes
import os
import sys

from musclewire.errors import CallerError, argument

# Above ordinary real-time work such as sound, below the kernel's own threads for interrupts, which have 50.
PRIORITY = 40
# prctl(2), mlockall(2): numbers of the kernel's interface.
PR_SET_TIMERSLACK = 29
# Flags of mlockall: memory in use now, each page from its first use. Not future memory, for which allocating would fail
# beyond the limit.
MCL_CURRENT = 1
MCL_ONFAULT = 4
MIN_SLACK_NS = 1


def wake_on_time() -> None:
    """Make this thread's timers fire on time and not up to 50 us later, on Linux (prctl(2), PR_SET_TIMERSLACK)."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_TIMERSLACK, MIN_SLACK_NS, 0, 0, 0)


def pin_to_cpu(cpu: int) -> None:
    """Keep this process, and its caches, on one core. Raises CallerError if core or system does not allow it."""
    if sys.platform != "linux":
        raise CallerError(f"a core cannot be chosen on {sys.platform}: leave out " + argument("cpu"))
    allowed = sorted(os.sched_getaffinity(0))
    if cpu not in allowed:
        cores = ", ".join(str(core) for core in allowed)
        raise CallerError(
            f"core {cpu} is not one that this process may use ({cores}): choose one of these for " + argument("cpu")
        )
    os.sched_setaffinity(0, {cpu})


def take_priority() -> list[str]:
    """Run this process before all ordinary ones (SCHED_FIFO) and lock its memory (mlockall).

    Returns a line for each of the two that the system does not permit, with what to do about it. Raises CallerError on
    systems other than Linux.
    """
    if sys.platform != "linux":
        raise CallerError(f"real-time priority is taken on Linux only, not on {sys.platform}: go without it")
    refused = []
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    except PermissionError:
        refused.append(
            "real-time priority is not permitted: add the lines '@realtime - rtprio 50' and '@realtime - memlock "
            "unlimited' to /etc/security/limits.d/realtime.conf, join the group (sudo groupadd -f realtime; sudo "
            "usermod -aG realtime $USER) and log in again"
        )
    if ctypes.CDLL(None, use_errno=True).mlockall(MCL_CURRENT | MCL_ONFAULT) != 0:
        refused.append(
            f"memory cannot be locked ({os.strerror(ctypes.get_errno())}): raise 'memlock' to unlimited in "
            "/etc/security/limits.d/realtime.conf and log in again ('ulimit -l' shows it)"
        )
    return refused


def scheduling() -> str:
    """Describe how the system schedules this process, for a recording's metadata."""
    if sys.platform != "linux":
        return "ordinary"
    real_time = os.sched_getscheduler(0) in (os.SCHED_FIFO, os.SCHED_RR)
    words = f"real-time priority {os.sched_getparam(0).sched_priority}" if real_time else "ordinary"
    cores = sorted(os.sched_getaffinity(0))
    return f"{words}, core {cores[0]}" if len(cores) == 1 else words
