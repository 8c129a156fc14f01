"""A wire's supply: a drive through the wire, the catalogue's numbers, and the table of all wires."""

from __future__ import annotations

from musclewire.manifest import Command, Manifest

MANIFEST = Manifest(
    name="supply",
    commands=(
        Command(
            "simulate",
            "musclewire.extras.supply._command:simulate",
            "Simulate a drive through a wire: which supply, shunt and current it needs.",
            panel="Choose, simulate and design",
            before="linearise",
            answer="musclewire.extras.supply._answers:SimulateAnswers",
        ),
        Command(
            "catalogue",
            "musclewire.extras.supply._command:catalogue",
            "Compare the Flexinol catalogue with the simulation: contraction after one second, and cooling times.",
            panel="Choose, simulate and design",
            before="linearise",
            answer="musclewire.extras.supply._answers:CatalogueAnswer",
        ),
    ),
)
