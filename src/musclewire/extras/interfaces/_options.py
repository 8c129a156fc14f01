"""Options of the commands for other programs."""

from __future__ import annotations

from musclewire.app import option, quantity

DISPLACEMENT = quantity(
    "--displacement", "m", "Displacement of the connector at which the wire rests, as '2 mm'.", 0.0, 1.0
)
SENSED_BY = option("--sensed-by", help="Model file by which the loop senses strain; by default the strain itself.")
SOURCES_ONLY = option("--sources-only", help="Write the FMU without a binary, for tools that compile its sources.")
