"""The state of a wire: all that it remembers from one step to the next.

The list of fields is the only definition. The layout in memory, attributes in Python and in compiled code and
the page on the row of a wire follow from it; a new field is one line here, and the line of the step that writes it.
"""

from __future__ import annotations

from musclewire.arrays import FloatArray
from musclewire.wire._row import CLASS_SLOPES, CLASSES, Row, field


class WireState(Row):
    """All that a wire remembers from one step to the next.

    Parameters
    ----------
    numbers
        The plain numbers of the row in the order of its fields, one-dimensional.
    layout
        Their layout in memory: ``WireState.layout(classes)``.
    """

    time_s: float = field("s", "time since the wire was first at rest")
    temperature_k: float = field("K", "temperature")
    stress_pa: float = field("Pa", "stress of one leg")
    contraction: float = field("1", "contraction relative to the cold length under pretension")
    connector_contraction: float = field(
        "1", "displacement of the connector over the leg's length; above the contraction while friction holds it"
    )
    friction_n: float = field("N", "friction of guide and load, positive against contraction")
    enthalpy_j: float = field("J", "enthalpy, 0 for austenite at 20 C")
    heat_in_j: float = field("J", "electrical heat since the start")
    heat_out_j: float = field("J", "heat lost to the air since the start")
    cycles: float = field("1", "full transformation cycles since the start")
    martensite_fraction: float = field("1", "volume fraction of martensite")
    r_phase_fraction: float = field("1", "volume fraction of R-phase")
    resistance_ohm: float = field("ohm", "resistance")
    front_austenite: FloatArray = field(
        "1", "front below which grains are austenite, in units of the spread, for each class of barrier", CLASSES
    )
    front_martensite: FloatArray = field(
        "1", "front above which grains are martensite; R-phase lies between both fronts", CLASSES
    )
    temperature_slope_k_per_j: float = field("K/J", "slope of temperature over heat in the last step")
    stress_slope_pa_per_j: float = field("Pa/J", "slope of stress over heat in the last step")
    contraction_slope_per_j: float = field("1/J", "slope of contraction over heat in the last step")
    resistance_slope_ohm_per_j: float = field("ohm/J", "slope of resistance over heat in the last step")
    last_heat_j: float = field("J", "heat of the last step")
    carried_heat_j: float = field("J", "heat that the last step owes by the trapezoidal rule; the next one takes it")
    step_s: float = field("s", "length of step that the tolerance asks for next; 0 before the first")
    step_error_k: float = field("K", "largest estimated error of a step in temperature since the start")
    evaluations: float = field("1", "evaluations of the balances since the start")
    unsolved_steps: float = field("1", "steps since the start whose balances were not met")
    front_trial: FloatArray = field(
        "1, 1/K, 1/Pa",
        "fronts of the solution in progress, with their slopes over temperature and stress",
        CLASS_SLOPES,
    )

    @property
    def slack(self) -> float:
        """Length by which friction holds the connector ahead of the slack wire, over the leg's length."""
        return self.connector_contraction - self.contraction
