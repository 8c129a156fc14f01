"""The file mw_finger_numbers.h: the curve of a finger at the connector, as the endpoint's C reads it."""

from __future__ import annotations

from collections.abc import Sequence

from musclewire.extras.board import literal, rows
from musclewire.rigs import FingerTendon

NO_FINGER = "/* Written by musclewire (musclewire export fmu): no finger at the connector. */\n#define MW_FINGER 0\n"
START = "/* Written by musclewire (musclewire export fmu): the finger at the connector. */"


def finger_header(tendon: FingerTendon | None) -> str:
    """Return the text of ``mw_finger_numbers.h``."""
    if tendon is None:
        return NO_FINGER
    curve, obstacle = tendon.curve, tendon.obstacle
    numbers = {
        "SLACK_M": tendon.slack_m,
        "START_M": tendon.start_m,
        "OBJECT_N_PER_M": obstacle.stiffness_n_per_m if obstacle else 0.0,
        "CLEARANCE_M": obstacle.clearance_m if obstacle else 0.0,
    }
    lines = [
        START,
        "#define MW_FINGER 1",
        f"#define MW_FINGER_POINTS {len(curve.tendon_travel_m)}",
        *(f"#define MW_FINGER_{name} {literal(value)}" for name, value in numbers.items()),
        *column("travel_m", curve.tendon_travel_m),
        *column("endpoint_m", curve.endpoint_displacement_m),
        *column("compliance_m_per_n", curve.endpoint_compliance_m_per_n),
    ]
    return "\n".join([*lines, ""])


def column(name: str, values: Sequence[float]) -> list[str]:
    """Return the definition of a column of the curve."""
    body = "\n".join(f"    {line}" for line in rows(literal(value) for value in values))
    return [f"static const double mw_finger_{name}[MW_FINGER_POINTS] = {{", body, "};"]
