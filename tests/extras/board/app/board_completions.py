"""What a shell asks of the rigs with a board."""

from __future__ import annotations

__all__ = ["IN_EVERY_SHELL", "QUESTIONS"]

QUESTIONS = [("control ser", "serial-board")]
IN_EVERY_SHELL = [QUESTIONS[0]]
