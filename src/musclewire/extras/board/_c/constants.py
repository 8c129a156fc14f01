"""Every number of an exported library, by its C name: model, controller, limits, protection table.

They are collected once, from the objects that Python computes with. The header is written from this list; the export's
checks and the tests read the same list.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from musclewire.controllers import (
    CONDITION_EVENTS,
    DRIVEN_FRACTION,
    FALLING,
    FROZEN_READINGS,
    FROZEN_S,
    MADE_UP_FRACTION,
    MAX_OFTEN_MISSING,
    MAXIMUM_ROUNDING,
    MOVED_FRACTION,
    RISING,
    SATURATED_FRACTION,
    SHORT_FRACTION,
    STUCK_FRACTION,
    SUPPLY_FRACTION,
    TRIANGLE,
    UNIVERSE_POINTS,
    AllowedDrive,
    DriveLimits,
    Event,
    FeedforwardSettings,
    FuzzyPidSettings,
    ProtectionLimits,
    RuleBase,
    inverse_model_numbers,
    largest_power_w_per_v2,
    load_rule_base,
    packed_rules,
    protection_table,
)
from musclewire.errors import CallerError, nearest_hint
from musclewire.extras.board._c.loops import ESTIMATORS_IN_C, FILTER, ControllerSettings
from musclewire.physics import MINIMUM_CURRENT_A
from musclewire.sensing import PAPER_ESTIMATOR, SensingModel, filter_numbers

Kind = Literal["real", "integer"]
ACTIONS = {"": 0, "trip": 1, "degrade": 2}
EFFECT_WEIGHT = 16
INFERENCES = {"constant": 0, "product-weighted-sum": 1, "min-max-centroid": 2}
MICROSECONDS_PER_S = 1e6
RANGE_ENDS = {f"k{k}_{end}": f"k{k}_range[{i}]" for k in "pid" for i, end in enumerate(("minimum", "maximum"))}
# The groups that define the closed loop, independently of the board. Their text is part of the model's checksum.
MODEL_HEADING = "the self-sensing model (Lan and Fan 2010, Eqs. 3 to 5)"
CONTROLLER_HEADING = "the fuzzy-tuned PID (Eq. 6)"
RULES_HEADING = "its rule base"
FILTER_HEADING = "the filter on the wire's heat balance"
INVERSE_HEADING = "the inverse of the wire's model"
CONTROL_HEADINGS = (MODEL_HEADING, CONTROLLER_HEADING, RULES_HEADING, FILTER_HEADING, INVERSE_HEADING)
# The one number of the filter that depends on the shunt, so that it is the circuit's and not in the checksum.
SHUNT_NOISE = "least_noise_v2"


@dataclass(frozen=True)
class CConstant:
    """One number or one table, under its C name without ``MW_``; a table's ``columns`` make one initialiser a row."""

    name: str
    values: tuple[float, ...]
    kind: Kind = "real"
    table: bool = False
    columns: int = 0
    meaning: str = ""


@dataclass(frozen=True)
class CConstants:
    """All numbers of a library, grouped under headings."""

    groups: dict[str, list[CConstant]] = field(default_factory=dict)

    def all(self) -> list[CConstant]:
        """Return every constant, in order."""
        return [constant for group in self.groups.values() for constant in group]

    def value(self, name: str) -> float:
        """Return a single number by its C name."""
        return next(constant.values[0] for constant in self.all() if constant.name == name)


def collect(
    model: SensingModel,
    settings: ControllerSettings,
    rule_base: RuleBase | None,
    limits: DriveLimits,
    protection: ProtectionLimits,
    estimator: str = PAPER_ESTIMATOR,
) -> CConstants:
    """Return a library's numbers. Raises CallerError if drive limits and protection disagree."""
    checked = protection.checked()
    for name in ("sense_voltage_v", "maximum_voltage_v"):
        asked, allowed = getattr(limits, name), getattr(checked, name)
        if asked != allowed:
            raise CallerError(
                f"{name} is {asked:g} V in the drive limits and {allowed:g} V in the protection: give both one value"
            )
    return CConstants(
        {
            "circuit and limits of the drive": _circuit(checked) + _noise(model, checked, estimator),
            **control_numbers(model, settings, rule_base, estimator).groups,
            "limits of the protection": _protection(checked),
            "the protection table": _table(),
        }
    )


def control_numbers(
    model: SensingModel,
    settings: ControllerSettings,
    rule_base: RuleBase | None = None,
    estimator: str = PAPER_ESTIMATOR,
) -> CConstants:
    """Return the numbers of a model, its estimator and its controller: those that the checksum covers."""
    groups = {MODEL_HEADING: _model(model)}
    if isinstance(settings, FeedforwardSettings):
        groups[INVERSE_HEADING] = _inverse(model, settings, estimator)
    else:
        groups[CONTROLLER_HEADING] = _controller(settings)
        groups[RULES_HEADING] = _rules(rule_base or load_rule_base(settings.rule_base))
    if estimator == FILTER:
        groups[FILTER_HEADING] = _filter(model)
    elif estimator != PAPER_ESTIMATOR:
        hint = nearest_hint(estimator, ESTIMATORS_IN_C)
        raise CallerError(f"estimator {estimator!r} has no C form{hint}: export {FILTER} or {PAPER_ESTIMATOR}")
    return CConstants(groups)


def _filter(model: SensingModel) -> list[CConstant]:
    """Return the numbers of the filter; their names are those of ``sensing._filter_estimator``."""
    numbers, tables = filter_numbers(model, 1.0)
    low_ohm, high_ohm = model.own_resistance_ohm
    of_curve = {name: model.numbers[name] for name in ("residual_variance", "scale_variance", "quantity_span")}
    return [
        _integer("FILTER", 1, "the estimate is mw_follow's"),
        _real("OWN_LOW_OHM", low_ohm, "a resistance beyond is another wire's"),
        _real("OWN_HIGH_OHM", high_ohm),
        *(_real(name.upper(), value) for name, value in (of_curve | numbers).items() if name != SHUNT_NOISE),
        _integer("PLACES", len(tables)),
        CConstant(
            *("PLACE_TABLE", tuple(tables.ravel().tolist())),
            table=True,
            columns=tables.shape[1],
            meaning="steady power on the heating and the cooling branch, and resistance",
        ),
    ]


def _inverse(model: SensingModel, settings: FeedforwardSettings, estimator: str) -> list[CConstant]:
    """Return the numbers of the inverse of the wire's model; their names are ``controllers._inverse_model``'s."""
    if settings.quantity != model.quantity:
        raise CallerError(
            f"the gains are of {settings.quantity}, the model of {model.quantity}: find this model's with "
            "'musclewire tune MODEL RECORDING -o MODEL'"
        )
    numbers, tables = inverse_model_numbers(settings)
    return [
        _integer("INVERSE_MODEL", 1, "the controller is mw_inverse_model_step"),
        *(_real(name.upper(), value) for name, value in numbers.items()),
        *(_real(name.upper(), value) for name, value in _deviation_numbers(model, estimator).items()),
        _integer("LEVELS", len(tables)),
        CConstant(
            *("LEVEL_TABLE", tuple(tables.ravel().tolist())),
            table=True,
            columns=tables.shape[1],
            meaning="steady power on the heating and the cooling branch, resistance, and the slopes of both powers",
        ),
    ]


def _deviation_numbers(model: SensingModel, estimator: str) -> dict[str, float]:
    """Return what an estimate's deviation takes, by name, where the estimator's own numbers do not have it."""
    if estimator == FILTER:
        return {}
    curve = {name: model.numbers[name] for name in ("residual_variance", "scale_variance", "quantity_span")}
    return curve | {"noise_ohm": model.resistance_noise_ohm}


def _noise(model: SensingModel, limits: ProtectionLimits, estimator: str) -> list[CConstant]:
    """Return the least variance of a reading at this shunt, for the filter alone."""
    if estimator != FILTER:
        return []
    numbers, _ = filter_numbers(model, limits.shunt_resistance_ohm)
    return [_real(SHUNT_NOISE.upper(), numbers[SHUNT_NOISE], "of a reading, referred to the shunt's voltage")]


def _circuit(limits: ProtectionLimits) -> list[CConstant]:
    shunt_ohm = limits.shunt_resistance_ohm
    return [
        _real("SHUNT_RESISTANCE_OHM", shunt_ohm, "R of Eq. 1"),
        _real("LEAST_SHUNT_VOLTAGE_V", MINIMUM_CURRENT_A * shunt_ohm, "below it there is no resistance"),
        _real("SENSE_VOLTAGE_V", limits.sense_voltage_v, "the drive never falls below it while sensing"),
        _real("MAXIMUM_VOLTAGE_V", limits.maximum_voltage_v),
    ]


def _model(model: SensingModel) -> list[CConstant]:
    heating, cooling = (tuple(reversed(powers)) for powers in (model.heating_coefficients, model.cooling_coefficients))
    numbers = model.numbers
    return [
        _real("RESISTANCE_MIN_OHM", model.resistance_min_ohm, "normalised resistance 0"),
        _real("RESISTANCE_MAX_OHM", model.resistance_max_ohm, "normalised resistance 1"),
        _real("SHARE_PER_OHM", numbers["per_ohm"]),
        _real("NORMALISED_MIN", model.normalised_min, "the valid range of normalised resistance"),
        _real("NORMALISED_MAX", model.normalised_max),
        _real("VALID_FROM", numbers["valid_from"], "estimates are valid a little beyond it"),
        _real("VALID_TO", numbers["valid_to"]),
        _real("QUANTITY_MIN", model.quantity_min, f"{model.quantity} [{model.unit}] at the ends of the range"),
        _real("QUANTITY_MAX", model.quantity_max),
        _integer("COEFFICIENTS", len(heating)),
        CConstant("HEATING_FALLING", heating, table=True, meaning="g_h of Eq. 4, highest power first"),
        CConstant("COOLING_FALLING", cooling, table=True, meaning="g_c; the estimate is the mean of both (Eq. 5)"),
    ]


def _controller(settings: FuzzyPidSettings) -> list[CConstant]:
    return [
        *(
            _real(f"K{letter.upper()}_{end}", getattr(settings, f"k{letter}_range")[index])
            for letter in "pid"
            for index, end in enumerate(("MINIMUM", "MAXIMUM"))
        ),
        _real("INPUT_SCALE", settings.input_scale, "V per error unit at a gain of one"),
        _real("ERROR_UNIT", settings.error_unit, "what the quantity calls one percent strain"),
        _real("ERROR_RANGE", settings.error_range, "error units that are +-1 for the tables"),
        _real("CHANGE_RANGE", settings.change_range, "error units per second that are +-1"),
        _real("DERIVATIVE_FILTER_S", settings.derivative_filter_s),
    ]


def _rules(rule_base: RuleBase) -> list[CConstant]:
    inference = rule_base.rules.inference
    row = packed_rules(rule_base)[0]
    tables = {name: tuple(row[f"{name.lower()}_table"].ravel().tolist()) for name in ("KP", "KI", "KD")}
    kinds = [_integer(name.upper().replace("-", "_"), number) for name, number in INFERENCES.items()]
    found = [*kinds, _integer("INFERENCE", INFERENCES[inference], inference)]
    if inference == "constant":
        return [*found, *(_real(f"{name}_RATIO", table[0]) for name, table in tables.items())]
    sets = np.column_stack([row["set_shapes"], row["set_points"]])
    smooth = bool((row["set_shapes"] != TRIANGLE).any())
    found += [
        _integer("TRIANGLE", TRIANGLE),
        _integer("FALLING", FALLING),
        _integer("RISING", RISING),
        _integer("HAS_SMOOTH_SETS", int(smooth)),
        _integer("MIRRORED", int(row["mirrored"]), "which half of the tables serves both directions"),
        CConstant("INPUT_SETS", tuple(sets.ravel().tolist()), table=True, columns=4, meaning="shape and three points"),
    ]
    for name, table in tables.items():
        real = name == "KI" and inference == "product-weighted-sum"
        found.append(CConstant(f"{name}_TABLE", table, "real" if real else "integer", table=True))
    if inference == "min-max-centroid":
        points = tuple(row["output_sets"].ravel().tolist())
        found.append(CConstant("OUTPUT_SETS", points, table=True, columns=UNIVERSE_POINTS))
    return found


def _protection(limits: ProtectionLimits) -> list[CConstant]:
    saturated = SATURATED_FRACTION
    above_k = limits.maximum_temperature_k - limits.ambient_temperature_k
    return [
        _real(
            "OPEN_SHUNT_VOLTAGE_V", limits.minimum_current_a * limits.shunt_resistance_ohm, "below it a wire is open"
        ),
        _real("MAXIMUM_CURRENT_A", limits.maximum_current_a),
        _real("MAXIMUM_POWER_W", limits.maximum_power_w),
        _real("RESISTANCE_LOW_OHM", limits.resistance_low_ohm),
        _real("RESISTANCE_HIGH_OHM", limits.resistance_high_ohm),
        _real("JUMP_SHARE", limits.jump_share),
        _real("SATURATED_WIRE_V", saturated * limits.wire_range_v),
        _real("SATURATED_SHUNT_V", saturated * limits.shunt_range_v),
        _real("LARGEST_W_PER_V2", largest_power_w_per_v2(limits), "of the ordered drive, in the smallest resistance"),
        _integer("READINGS_NOISY", int(limits.readings_noisy > 0.0)),
        _real("HEAT_CAPACITY_J_PER_K", limits.heat_capacity_j_per_k),
        _real("HEAT_LOSS_W_PER_K", limits.heat_loss_w_per_k),
        _real("MAXIMUM_ABOVE_AMBIENT_K", above_k, f"{limits.maximum_temperature_k:g} K"),
    ]


def _table() -> list[CConstant]:
    return [*_machine(), *_events(), *_conditions(), *_times(), *_reserved()]


def _machine() -> list[CConstant]:
    """Return states, signals and effects, and the table of transitions, each with effect and next state in one byte."""
    table = protection_table()
    transitions = tuple(float(EFFECT_WEIGHT * effect + state) for row in table.transitions for state, effect in row)
    return [
        *(_integer(f"STATE_{row.name.upper()}", row.number, row.output) for row in table.state),
        _integer("STATES", len(table.state)),
        *(_integer(f"SIGNAL_{row.name.upper()}", row.number, row.when) for row in table.signal),
        _integer("SIGNALS", len(table.signal)),
        *(_integer(f"EFFECT_{row.name.upper()}", row.number, row.meaning) for row in table.effect),
        _integer("EFFECT_WEIGHT", EFFECT_WEIGHT, "a transition is its effect times this, plus the state that follows"),
        CConstant("TRANSITIONS", transitions, "integer", table=True, meaning="by state, then by signal"),
        *(_integer(f"OUT_{drive.name}", drive.value) for drive in AllowedDrive),
        CConstant(
            "OUT", tuple(float(drive) for drive in table.output_drives), "integer", table=True, meaning="by state"
        ),
    ]


def _events() -> list[CConstant]:
    rows = {row.number: row for row in protection_table().event}
    count = max(Event) + 1
    actions = tuple(float(ACTIONS[rows[number].action if number in rows else ""]) for number in range(count))
    return [
        _integer("EVENTS", count),
        *(_integer(f"EVENT_{event.name}", event.value, rows[event].cause if event in rows else "") for event in Event),
        *(_integer(f"ACTION_{name.upper()}", number) for name, number in ACTIONS.items() if name),
        CConstant("ACTIONS", actions, "integer", table=True, meaning="by event"),
    ]


def _conditions() -> list[CConstant]:
    """Return the events that must last, in the order in which they are judged."""
    lasts_s = protection_table().lasts_s
    events = CONDITION_EVENTS
    return [
        _integer("LASTING", len(events), "events that must last, in the order in which they are judged"),
        *(_integer(f"LASTING_{event.name}", index) for index, event in enumerate(events)),
        CConstant("LASTING_EVENTS", tuple(float(event) for event in events), "integer", table=True),
        CConstant("LASTING_US", tuple(_microseconds(lasts_s[event]) for event in events), "integer", table=True),
    ]


def _times() -> list[CConstant]:
    table = protection_table()
    fractions = {
        "DRIVEN": DRIVEN_FRACTION,
        "STUCK": STUCK_FRACTION,
        "SUPPLY": SUPPLY_FRACTION,
        "SHORT": SHORT_FRACTION,
        "MOVED": MOVED_FRACTION,
    }
    return [
        _integer("READING_PERIOD_US", _microseconds(table.reading_period_s), "samples are averaged over this time"),
        _integer("DELAY_US", _microseconds(table.delay_s), "a reading may show a drive ordered so long before it"),
        _integer("SENSE_AFTER_US", _microseconds(table.sense_after_s)),
        _integer("TRIP_AFTER_US", _microseconds(table.trip_after_s)),
        _integer("MADE_UP_PART", round(1.0 / MADE_UP_FRACTION), "a sound reading makes up for this part of its time"),
        _integer("MAX_OFTEN_MISSING_US", _microseconds(MAX_OFTEN_MISSING * table.sense_after_s)),
        _integer("FROZEN_US", _microseconds(FROZEN_S)),
        _integer("FROZEN_READINGS", int(FROZEN_READINGS)),
        # The C names are those of the first version of the library.
        *(_real(f"{name}_SHARE", fraction) for name, fraction in fractions.items()),
        _real("MAXIMUM_ROUNDING", MAXIMUM_ROUNDING),
    ]


def _reserved() -> list[CConstant]:
    """Return the names that programs written for an older library may use."""
    rows = protection_table().reserved
    return [_integer(f"{row.kind.upper()}_{row.name.upper()}", row.number, f"reserved: {row.why}") for row in rows]


def _microseconds(time_s: float) -> int:
    """Return a time of the table in whole microseconds; the library counts in them."""
    whole = round(time_s * MICROSECONDS_PER_S)
    if abs(whole - time_s * MICROSECONDS_PER_S) > 1e-6:
        raise CallerError(
            f"the protection table has a time of {time_s!r} s: the C library counts whole microseconds, give a multiple"
        )
    return whole


def _real(name: str, value: float, meaning: str = "") -> CConstant:
    return CConstant(name, (float(value),), meaning=meaning)


def _integer(name: str, value: int, meaning: str = "") -> CConstant:
    return CConstant(name, (float(value),), "integer", meaning=meaning)


def numbers_of(constants: Sequence[CConstant]) -> list[tuple[str, float]]:
    """Return every real number with its name in Python: ``heating_coefficients[2]``, ``kp_range[0]``."""
    return [
        (_known_as(constant, index), value)
        for constant in constants
        if constant.kind == "real"
        for index, value in enumerate(constant.values)
    ]


def _known_as(constant: CConstant, index: int) -> str:
    name = constant.name.lower()
    if name.endswith("_falling"):
        return f"{name.removesuffix('_falling')}_coefficients[{len(constant.values) - 1 - index}]"
    if name in RANGE_ENDS:
        return RANGE_ENDS[name]
    return f"{name}[{index}]" if constant.table else name
