"""What a shell asks of the commands of design."""

from __future__ import annotations

__all__ = ["IN_EVERY_SHELL", "QUESTIONS"]

QUESTIONS = [("design fin", "finger")]
IN_EVERY_SHELL = [QUESTIONS[0]]
