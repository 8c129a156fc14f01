"""A rig operated live from a page in a browser or from a program."""

from __future__ import annotations

from musclewire.manifest import Command, Manifest

MANIFEST = Manifest(
    name="live",
    commands=(
        Command(
            "serve",
            "musclewire.extras.live._serve_command:serve",
            "Show a wire live on a page: measure, control, record and stop it there.",
            panel="Begin here, on the simulated wire",
        ),
    ),
    names={"LiveClient": "musclewire.extras.live._client:LiveClient"},
)
