"""What is shown of a bench: one snapshot, sent whole whenever something in it has changed."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from datetime import UTC, datetime
from typing import Any, Literal

Phase = Literal["starting", "off", "ready", "busy", "stopped", "failed"]
MAX_MESSAGES = 20
STEPS = ("switched_on", "doctor", "pulse", "loop", "model", "moved")


@dataclass
class BenchState:
    """The state of a bench under the keys of the interface; parts that are not known yet are None."""

    bench: str
    revision: int = 0
    phase: Phase = "starting"
    why: str = ""
    wiring: list[str] = field(default_factory=list)
    simulated: bool = False
    rig: dict[str, Any] | None = None
    doing: dict[str, Any] | None = None
    messages: list[dict[str, str]] = field(default_factory=list)
    protection: dict[str, Any] | None = None
    health: str = ""
    doctor: dict[str, Any] | None = None
    loop: dict[str, Any] | None = None
    model: dict[str, Any] | None = None
    pretensions: dict[str, Any] | None = None
    metrics: dict[str, Any] | None = None
    gains: dict[str, Any] | None = None
    controllers: list[str] = field(default_factory=list)
    estimators: list[str] = field(default_factory=list)
    steps: dict[str, bool] = field(default_factory=lambda: dict.fromkeys(STEPS, False))
    recordings: list[dict[str, Any]] = field(default_factory=list)
    clock_speed: float = 1.0
    layout: int | None = None
    layouts: dict[str, list[str]] = field(default_factory=dict)


class PublishedState:
    """The state, changed from any thread; each change is sent with the lock held, so that snapshots leave in order."""

    def __init__(self, bench: str, send: Callable[[dict[str, Any]], None]) -> None:
        """Begin with nothing known."""
        self._state, self._send, self._lock = BenchState(bench), send, threading.RLock()

    @property
    def state(self) -> BenchState:
        """The present state; for reading."""
        return self._state

    def change(self, **changed: Any) -> None:
        """Change parts of the state by name, and send it."""
        with self._lock:
            for name, value in changed.items():
                setattr(self._state, name, value)
            self._state.revision += 1
            # Not dataclasses.asdict: it copies every branch of every model.
            self._send({one.name: getattr(self._state, one.name) for one in fields(self._state)})

    def done(self, step: str, **changed: Any) -> None:
        """Note that a step of the first use is done, with what else has changed."""
        self.change(steps={**self._state.steps, step: True}, **changed)

    def say(self, level: Literal["info", "warning", "error"], *texts: str) -> None:
        """Add messages; the last twenty are kept."""
        if texts:
            at = datetime.now(UTC).isoformat(timespec="seconds")
            added = [{"level": level, "text": text, "at": at} for text in texts]
            with self._lock:
                self.change(messages=[*self._state.messages, *added][-MAX_MESSAGES:])
