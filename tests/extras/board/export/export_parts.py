"""A wire, its controller and its limits to export, and random ones."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from emulation.exported_library.on_this_machine import HostLibrary, built
from hypothesis import assume
from hypothesis import strategies as st
from tests.tools import require_tool

from musclewire.controllers import DriveLimits, FeedforwardSettings, FuzzyPidSettings, Gains, ProtectionLimits
from musclewire.errors import CallerError
from musclewire.extras.board import CLibrary, ReferenceTick, write_library
from musclewire.sensing import SensingModel

SHUNT_OHM = 1.0
RULE_BASES = ("zhao-1993", "liu-7x7", "liu-7x7-mirrored", "fixed")
# Polynomials like those of a loop of the simulated wire: order 6, in strain.
HEATING = (0.0415, -0.0135, 0.0021, -0.0352, 0.0297, -0.0318, 0.0112)
COOLING = (0.0409, -0.0268, -0.0142, 0.0103, -0.0211, 0.0219, -0.0088)
# Through B at 0.1 W, and cold again at 0.02 W.
SLOW_LOOP = (
    *((0.0, 0.01, 17.2), (10.0, 0.05, 17.3), (20.0, 0.1, 17.5), (30.0, 0.4, 15.2)),
    *((40.0, 0.05, 16.5), (50.0, 0.02, 17.2)),
)


class Exported(NamedTuple):
    """A written library and what it was written from."""

    library: CLibrary
    model: SensingModel
    settings: FuzzyPidSettings | FeedforwardSettings
    limits: ProtectionLimits

    def reference(self) -> ReferenceTick:
        """Return Python's tick of the same wire."""
        return ReferenceTick(self.model, self.settings, drive_limits(self.limits), self.limits)


def usual_model(**changes: Any) -> SensingModel:
    values: dict[str, Any] = {
        "resistance_min_ohm": 15.13,
        "resistance_max_ohm": 17.51,
        "heating_coefficients": HEATING,
        "cooling_coefficients": COOLING,
        "normalised_min": 0.0,
        "normalised_max": 0.93,
    }
    return SensingModel(**{**values, **changes})


def usual_gains() -> FeedforwardSettings:
    """What the inverse of the model knows of that wire: both branches of its slow loop, in five levels."""
    return FeedforwardSettings(
        lowest=0.002,
        highest=0.038,
        heating_power_w=(0.12, 0.18, 0.23, 0.29, 0.4),
        cooling_power_w=(0.06, 0.11, 0.15, 0.22, 0.33),
        resistance_ohm=(17.3, 16.8, 16.3, 15.8, 15.3),
        shunt_resistance_ohm=SHUNT_OHM,
        thermal_time_constant_s=0.8,
        heat_per_unit=2.5,
        closed_loop_time_s=0.1,
        dead_time_s=0.1,
        integral_time_s=0.8,
        maximum_steady_power_w=0.6,
    )


def whole_model(**changes: Any) -> SensingModel:
    """The usual model with slow loop and gains, as `fit` keeps them: what the defaults in C need."""
    return usual_model(slow_loop=SLOW_LOOP, gains=Gains("inverse-model", usual_gains()).table(), **changes)


def limits_for(model: SensingModel, shunt_ohm: float = SHUNT_OHM, **changes: float) -> ProtectionLimits:
    """Limits in which the exercise's wire runs: its own window, and room for its currents."""
    most_ohm = model.resistance_max_ohm
    volts = 0.2 * (most_ohm + shunt_ohm)
    current = volts / (model.resistance_min_ohm + shunt_ohm)
    values = ProtectionLimits(
        sense_voltage_v=volts / 12.0,
        maximum_voltage_v=volts,
        shunt_resistance_ohm=shunt_ohm,
        minimum_current_a=0.1 * current / 12.0,
        maximum_current_a=1.5 * current,
        maximum_power_w=2.0 * current * volts,
        resistance_low_ohm=0.7 * model.resistance_min_ohm,
        resistance_high_ohm=1.5 * most_ohm,
        jump_share=0.2,
        wire_range_v=2.0 * volts,
        shunt_range_v=2.0 * volts,
        readings_noisy=1.0,
        heat_capacity_j_per_k=4e-3 * most_ohm,
        heat_loss_w_per_k=3e-4 * most_ohm,
        ambient_temperature_k=295.15,
        maximum_temperature_k=345.0,
    )
    return values._replace(**changes).checked()


def drive_limits(limits: ProtectionLimits) -> DriveLimits:
    return DriveLimits(limits.sense_voltage_v, limits.maximum_voltage_v)


def export(
    folder: Path,
    *,
    model: SensingModel | None = None,
    settings: FuzzyPidSettings | FeedforwardSettings | None = None,
    limits: ProtectionLimits | None = None,
    rule_base: str = "zhao-1993",
    double: bool = False,
    estimator: str = "polynomial",
) -> Exported:
    chosen = model or usual_model()
    control = settings or FuzzyPidSettings(rule_base=rule_base)
    allowed = limits or limits_for(chosen)
    numbers = (chosen, control, drive_limits(allowed), allowed)
    library = write_library(*numbers, folder, "wire", double=double, estimator=estimator)
    return Exported(library, chosen, control, allowed)


def compiled(library: CLibrary, folder: Path, *, double: bool) -> HostLibrary:
    """Return the library compiled for this machine; without gcc the test is not run."""
    require_tool("gcc", "gcc libc6-dev")
    return HostLibrary(built(library.folder, folder, double=double), double=double)


def rounded(low: float, high: float) -> st.SearchStrategy[float]:
    """Numbers of four digits: what single precision cannot hold has tests of its own."""
    return st.floats(low, high).map(lambda value: float(f"{value:.3e}") if abs(value) > 1e-6 * high else 0.0)


@st.composite
def models(draw: st.DrawFn) -> SensingModel:
    """Models of any quantity, size and order up to 9 whose average can be inverted."""
    quantity, size = draw(st.sampled_from([("strain", 0.04), ("displacement", 3e-3), ("force", 2.5)]))
    order = draw(st.integers(1, 9))
    full = size * draw(rounded(0.2, 2.0))
    bends = st.lists(rounded(-0.1, 0.1), min_size=order - 1, max_size=order - 1)
    slope = -full * draw(rounded(0.6, 0.95))

    def branch() -> tuple[float, ...]:
        return (full, slope, *(full * bend for bend in draw(bends)))

    low = draw(rounded(0.5, 200.0))
    try:
        return SensingModel(
            low,
            low * draw(rounded(1.05, 1.4)),
            branch(),
            branch(),
            draw(rounded(-0.05, 0.1)),
            draw(rounded(0.7, 1.05)),
            quantity=quantity,
        )
    except CallerError:
        assume(False)
        raise


@st.composite
def settings_of(draw: st.DrawFn, model: SensingModel) -> FuzzyPidSettings:
    """Settings whose gains do not make the drive jump from end to end at every tick."""

    def ends(most: float) -> tuple[float, float]:
        first, second = draw(rounded(0.0, most)), draw(rounded(1e-4 * most, most))
        first = first if first > 1e-6 * most else 0.0
        return (min(first, second), max(first, second))

    return FuzzyPidSettings(
        kp_range=ends(0.2),
        ki_range=ends(0.1),
        kd_range=ends(0.002),
        input_scale=draw(rounded(1.0, 40.0)),
        error_unit=(model.quantity_max - model.quantity_min) / 3.0,
        error_range=draw(rounded(0.2, 3.0)),
        change_range=draw(rounded(1.0, 20.0)),
        derivative_filter_s=draw(st.sampled_from([0.0, 0.05, 0.2, 1.0])),
        rule_base=draw(st.sampled_from(["zhao-1993", "liu-7x7", "fixed"])),
    )
