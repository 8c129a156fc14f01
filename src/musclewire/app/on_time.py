"""Options that let a loop keep its time on Linux."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from musclewire.app.output import warn
from musclewire.errors import CallerError

if TYPE_CHECKING:
    from musclewire.rigs.guarded import GuardedRig

__all__ = ["Cpu", "RealTimePriority", "keep_time"]

RealTimePriority = Annotated[
    bool, typer.Option("--real-time-priority", help="On Linux: run before all ordinary programs, memory locked.")
]
Cpu = Annotated[int | None, typer.Option("--cpu", min=0, help="On Linux: keep the loop on this processor core.")]


def keep_time(rig: GuardedRig, priority: bool, cpu: int | None) -> list[str]:
    """Pin this process and take real-time priority as asked; return what the system refused, also said on stderr.

    Raises CallerError for a core that is not there, and for priority where no clock paces the rig.
    """
    from musclewire.rigs.real_time import pin_to_cpu, take_priority

    if priority and not rig.paced:
        raise CallerError(
            "no clock paces this rig, so at real-time priority it would take a whole core from everything else: add "
            "--real-time, or leave --real-time-priority away"
        )
    if cpu is not None:
        pin_to_cpu(cpu)
    return warn(take_priority()) if priority else []
