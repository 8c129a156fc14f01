"""Sizing of what a wire needs and pulls: supply, pretensioner and finger."""

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
            "simulate",
            "musclewire.extras.design._supply.command:simulate",
            "Simulate a drive through a wire: which supply, shunt and current it needs.",
            panel="Choose, simulate and design",
            answer="musclewire.extras.design._supply.answers:SimulateAnswers",
        ),
        Command(
            "catalogue",
            "musclewire.extras.design._supply.command:catalogue",
            "Compare the Flexinol catalogue with the simulation: contraction after one second, and cooling times.",
            panel="Choose, simulate and design",
            answer="musclewire.extras.design._supply.answers:CatalogueAnswer",
        ),
        Command(
            "pretensioner",
            "musclewire.extras.design._commands.pretensioner_command:pretensioner",
            "Size a serpentine pretensioner, or compute what one of given dimensions does.",
            group="design",
            answer="musclewire.extras.design._answers:PretensionerAnswers",
        ),
        Command(
            "finger",
            "musclewire.extras.design._commands.finger_command:finger",
            "Size a tendon-driven flexible finger, or compute what one of given dimensions does.",
            group="design",
            answer="musclewire.extras.design._answers:FingerAnswer",
        ),
    ),
)
