"""What a shell asks of the rigs with a board, and of what has a form in C."""

from __future__ import annotations

__all__ = ["IN_EVERY_SHELL", "QUESTIONS"]

QUESTIONS = [
    ("control ser", "serial-board"),
    ("export c model.json --controller f", "fuzzy-pid"),
    ("export c model.json --estimator p", "polynomial"),
]
IN_EVERY_SHELL = [QUESTIONS[0]]
