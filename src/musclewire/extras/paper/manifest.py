"""The printed numbers and figures of the paper next to ours."""

from __future__ import annotations

from musclewire.manifest import Command, Manifest

MANIFEST = Manifest(
    name="paper",
    commands=(
        Command(
            "reproduce",
            "musclewire.extras.paper._reproduce_command:reproduce",
            "Compare every printed number and figure of the paper with ours, in a folder; exit code 1 if a row fails.",
            panel="Studies and the paper",
            before="rules",
            answer="musclewire.extras.paper._answers:ReproduceAnswer",
        ),
    ),
    names={"reproduce": "musclewire.extras.paper._reproduce.reproduction:reproduce"},
)
