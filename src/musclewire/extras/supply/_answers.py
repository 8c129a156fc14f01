"""What the commands about a wire's supply print with --json."""

from __future__ import annotations

from typing import Annotated, Any

from musclewire.app import ABSENT, AnswerModel, AnswerRecord
from musclewire.extras.supply._wire_table import WireRow
from musclewire.parameters import CatalogueCell


class SuggestedParts(AnswerModel):
    """What the wire needs to contract by 90 % in a second."""

    one_second_current_a: float
    holding_current_a: float
    supply_v: float
    shunt_resistance_ohm: float
    shunt_power_w: float
    shunt_rating_w: float


class CatalogueSide(AnswerModel):
    """What the catalogue prints for a wire, in SI, and our cooling time [s] in the vendor's own test."""

    resistance_ohm_per_m: CatalogueCell
    one_second_current_a: CatalogueCell
    pull_force_n: CatalogueCell
    cooling_s: CatalogueCell
    test_cooling_s: float | None


class SimulateAnswer(AnswerModel):
    """Of ``simulate``; what the drive did to the wire is null if it melted."""

    wire: str
    simulated: bool
    length_m: float
    load_n: float
    spring_stiffness_n_per_m: float
    ambient_temperature_degc: float
    supply_v: float | None
    current_a: float | None
    shunt_resistance_ohm: float
    on_s: float
    duty: float
    duty_period_s: float | None
    contraction_pct: float | None
    largest_contraction_pct: float | None
    final_contraction_pct: float | None
    last_period_pct: tuple[float, float] | None
    contraction_m: float | None
    stroke_pct: float
    contraction_share_pct: float | None
    contracted_s: float | None
    cooling_s: float | None
    true_peak_temperature_degc: float | None
    settled_temperature_degc: float | None
    current_mean_a: float | None
    drive_voltage_peak_v: float | None
    power_peak_w: float | None
    energy_j: float | None
    suggested: SuggestedParts
    catalogue: CatalogueSide | None
    warnings: tuple[str, ...]
    samples: int
    seed: int
    recording: str | None


class WireOfLibrary(AnswerModel):
    """A wire that comes with musclewire."""

    name: str
    description: str
    alloy: str
    diameter_m: float
    resistance_per_metre_ohm_per_m: float


class CoveredByData(AnswerModel):
    """What the data of an alloy cover, and what its vendor allows; nothing of what its file does not state."""

    covered_stress_low_pa: float | None = ABSENT
    covered_stress_high_pa: float | None = ABSENT
    covered_temperature_high_k: float | None = ABSENT
    working_stress_pa: float | None = ABSENT
    annealing_temperature_k: float | None = ABSENT


class WiresAnswer(AnswerModel):
    """Of ``simulate --list``: the wires, and what the data of their alloys cover."""

    wires: tuple[WireOfLibrary, ...]
    alloys: dict[str, CoveredByData]


SHUNT: dict[str, Any] = dict.fromkeys(("shunt_resistance_ohm", "shunt_power_w", "shunt_rating_w"), float)
NEEDS = AnswerRecord(
    without=("catalogue_current", "shunt"), catalogue_current_a=float, catalogue_current_status=str, **SHUNT
)


class WireTableAnswer(AnswerModel):
    """Of ``simulate --table``."""

    length_m: float
    stress_pa: float
    ambient_temperature_degc: float
    simulated: bool
    rows: tuple[Annotated[WireRow, NEEDS], ...]


SimulateAnswers = SimulateAnswer | WiresAnswer | WireTableAnswer


class ComparedWire(AnswerModel):
    """One wire of the catalogue and its simulated test; without a limit a verdict is null."""

    wire: str
    diameter_m: float
    current_a: float
    current_status: str
    stroke_pct: float
    contraction_share_pct: float
    contraction_ok: bool | None
    true_temperature_degc: float
    cooling_s: float | None
    catalogue_cooling_s: float
    cooling_status: str
    cooling_ok: bool | None
    ok: bool


class CatalogueAnswer(AnswerModel):
    """Of ``catalogue``."""

    bars: str
    rows: tuple[ComparedWire, ...]
    judged: int
    failed: int
    ok: bool
