"""What a shell asks of the way to fit from resistance alone."""

from __future__ import annotations

__all__ = ["IN_EVERY_SHELL", "QUESTIONS"]

QUESTIONS = [("fit --wire flexinol-0.10-l", "flexinol-0.10-lt")]
IN_EVERY_SHELL = [QUESTIONS[0]]
