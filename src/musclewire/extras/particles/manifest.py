"""The particle filter on the user's own wire file."""

from __future__ import annotations

from musclewire.manifest import Manifest

__all__ = ["MANIFEST"]

MANIFEST = Manifest(
    name="particles",
    estimators={"particle-filter": "musclewire.extras.particles._estimator:particle_filter"},
    kernels=("musclewire.extras.particles._cloud", "musclewire.extras.particles._kernel"),
)
