"""What ``grip`` prints with --json."""

from __future__ import annotations

from musclewire.app import AnswerModel


class GripAnswer(AnswerModel):
    """Of ``grip``; what only the simulation knows of the object is called true."""

    contact: bool
    contact_s: float | None
    contact_score: float
    true_force_at_contact_n: float | None
    opening_m: float | None
    true_clearance_m: float | None
    known_stiffness_n_per_m: float | None
    used_stiffness_n_per_m: float | None
    true_stiffness_n_per_m: float | None
    target_n: float
    held: bool
    estimated_force_n: float | None
    true_force_n: float | None
    error_n: float | None
    most_force_n: float | None
    samples: int
    ended: str
    warnings: tuple[str, ...]
