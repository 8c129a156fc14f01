"""Sizing of what a wire pulls: pretensioner and finger."""

from __future__ import annotations

from musclewire.manifest import Command, CommandGroup, Manifest

__all__ = ["MANIFEST"]

MANIFEST = Manifest(
    name="design",
    groups=(
        CommandGroup(
            "design", "Size the parts that a wire pulls: pretensioner, finger.", panel="Choose, simulate and design"
        ),
    ),
    commands=(
        Command(
            "pretensioner",
            "musclewire_design._commands.pretensioner_command:pretensioner",
            "Size a serpentine pretensioner, or compute what one of given dimensions does.",
            group="design",
            answer="musclewire_design._answers:PretensionerAnswers",
        ),
        Command(
            "finger",
            "musclewire_design._commands.finger_command:finger",
            "Size a tendon-driven flexible finger, or compute what one of given dimensions does.",
            group="design",
            answer="musclewire_design._answers:FingerAnswer",
        ),
    ),
)
