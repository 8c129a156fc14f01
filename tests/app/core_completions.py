"""What a shell asks of the commands of the core."""

from __future__ import annotations

__all__ = ["IN_EVERY_SHELL", "QUESTIONS"]

QUESTIONS = [
    ("contr", "control"),
    ("control simulated model.json --estim", "--estimator"),
    ("control simulated model.json --rules zh", "zhao-1993"),
]
IN_EVERY_SHELL = [QUESTIONS[0]]
