"""A simulated rig of which some numbers and keys vary: from values to a wire's constants, or to an open rig."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np
from pydantic.fields import FieldInfo

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, nearest_hint
from musclewire.parameters import Alloy, Bench, Parameter, ParameterGroup, Wire, checked, unit_of, validated
from musclewire.rigs import (
    SETTINGS,
    FingerTendon,
    GuardedRig,
    LoadPart,
    Metadata,
    OwnVoltages,
    Parts,
    RigConfiguration,
    SimulatedLoad,
    SimulatedSpool,
    Surroundings,
    device_of,
    driven_wire,
    highest_temperature_k,
    mechanism_on,
    own_voltages,
    parameters_of,
    stepping_of,
)
from musclewire.wire import SHAPE, DrivenPath, WireConstants, drive_path

Value = float | str | bool
GROUPS: Mapping[str, type[ParameterGroup]] = {"wire": Wire, "alloy": Alloy, "bench": Bench}
# Keys of a rig file that have no unit: names, and whether the wire is new.
PLAIN_KEYS = ("wire", "bench", "new_wire")
# As many different rig files are remembered: a study goes through the names of its wires again and again.
REMEMBERED = 32


class VariedKey(NamedTuple):
    """What may vary: a number of wire, alloy or bench, or a key of the rig file."""

    unit: str  # "1" for a fraction; "" for a key without a unit
    group: str  # "wire", "alloy" or "bench"; "" for a key of the rig file
    # Name of the number, or tables and key in the rig file; a part of the load by its position.
    place: tuple[str | int, ...]


class VariedWire(NamedTuple):
    """A wire of a varied rig without its instruments: what studies of thousands of wires evaluate."""

    spool: SimulatedSpool
    constants: WireConstants  # load included
    tendon: FingerTendon | None  # the finger at the connector

    def facts(self) -> Metadata:
        """Return the metadata of a recording that describe wire and circuit, as its rig states them."""
        return {"rig": "simulated", **self.spool.facts(), "pretension_n": self.constants.pretension_n}

    def driven(self, drive_v: FloatArray) -> tuple[FloatArray, DrivenPath]:
        """Return voltages in the amplifier's steps, and the response, from cold, of a wire, for each sample.

        Raises CallerError for a drive above the wire's maximum, NumericsError if the simulation does not resolve the
        wire.
        """
        allowed_v, bench = self.spool.wire["maximum_voltage_v"], self.spool.bench
        if drive_v.max() > allowed_v:
            raise CallerError(
                f"the drive of {drive_v.max():g} V is {drive_v.max() - allowed_v:.3g} V above the wire's maximum of "
                f"{allowed_v:g} V: drive less or, if the wire bears it, raise maximum_voltage_v"
            )
        stepping, step_v = stepping_of(bench), bench["amplifier_resolution_v"]
        held_v = np.asarray(step_v * np.round(drive_v / step_v))
        path, _ = drive_path(self.constants, held_v, sample_s=bench["sample_period_s"], stepping=stepping)
        return held_v, path


class BaseRig(NamedTuple):
    """A rig file with its own alloy, wire and bench, before any of their numbers varies; whose voltages they are."""

    configuration: RigConfiguration
    groups: Mapping[str, ParameterGroup]
    own: OwnVoltages


def keys_of(configuration: RigConfiguration) -> dict[str, VariedKey]:
    """Return all numbers of wire, alloy and bench, by name and key, then other keys, as ``load.contact.stiffness``."""
    found: dict[str, VariedKey] = {}
    for group, schema in GROUPS.items():
        for name, field in schema.model_fields.items():
            if isinstance(field.json_schema_extra, dict):
                found[name] = VariedKey(str(field.json_schema_extra["unit"]), group, (name,))
    found |= {key: found[number] for key, number in SETTINGS.items()}
    found |= {name: VariedKey("", "", (name,)) for name in PLAIN_KEYS}
    found |= {
        f"surroundings.{key}": VariedKey(key_unit(field), "", ("surroundings", key))
        for key, field in Surroundings.model_fields.items()
    }
    for position, prefix in enumerate(part_names(configuration.load)):
        for key, field in type(configuration.load[position]).model_fields.items():
            if key != "part":
                found[f"{prefix}.{key}"] = VariedKey(key_unit(field), "", ("load", position, key))
    return found


def key_unit(field: FieldInfo) -> str:
    """Return the SI unit of a key, "1" for a plain number; "" for a key that is a name, a count or a yes or no."""
    kinds = [field.annotation, *getattr(field.annotation, "__args__", ())]
    inner = (getattr(item, "func", None) for kind in kinds for item in getattr(kind, "__metadata__", ()))
    unit = unit_of(field) or next((str(said) for item in inner if (said := getattr(item, "unit", ""))), "")
    is_number = any(kind is float or getattr(kind, "__origin__", None) is float for kind in kinds)
    return unit or ("1" if is_number else "")


def part_names(parts: Iterable[LoadPart]) -> list[str]:
    """Return the name of each part of a load, as ``load.spring``; the second of a kind is ``load.spring 2``."""
    names: list[str] = []
    for part in parts:
        number = sum(name.startswith(f"load.{part.part}") for name in names) + 1
        names.append(f"load.{part.part}" if number == 1 else f"load.{part.part} {number}")
    return names


class VariedRig:
    """A simulated rig of which some names of ``keys_of`` vary; CallerError for one that has no effect on it."""

    def __init__(self, configuration: RigConfiguration, where: str, names: Iterable[str]) -> None:
        """Look every name up."""
        known = keys_of(configuration)
        self.configuration, self.where = configuration, where
        self.keys: dict[str, VariedKey] = {}
        for name in names:
            if name not in known:
                raise CallerError(f"{where}: there is no parameter '{name}'{nearest_hint(name, known)}")
            self.keys[name] = known[name]
        if configuration.load and any(key.place == ("spring_stiffness_n_per_m",) for key in self.keys.values()):
            raise CallerError(
                f"{where}: 'spring_stiffness_n_per_m' belongs to the bench's spring, and [[load]] replaces it: vary "
                "load.spring.stiffness"
            )
        self._bases: dict[tuple[Value, ...], BaseRig] = {}
        self._mechanisms: dict[tuple[object, ...], SimulatedLoad] = {}

    def _base(self, values: Mapping[str, Value]) -> BaseRig:
        """Return the rig file with the keys of a set of values, and its own numbers."""
        chosen = tuple(values[name] for name, key in self.keys.items() if not key.group)
        if chosen not in self._bases:
            if len(self._bases) >= REMEMBERED:
                self._bases.clear()
            self._bases[chosen] = self._read({key.place: values[name] for name, key in self.keys.items()
                                              if not key.group})  # fmt: skip
        return self._bases[chosen]

    def _read(self, changed: Mapping[tuple[str | int, ...], Value]) -> BaseRig:
        """Return a rig file with some keys changed."""
        configuration = changed_file(self.configuration, changed, self.where)
        alloy, wire, bench = parameters_of(configuration, self.where)
        shape = [name for name, key in self.keys.items() if key.place[0] in SHAPE]
        if alloy.grain_quantiles is not None and shape:
            raise CallerError(
                f"{self.where}: '{shape[0]}' has no effect: the alloy's [grain_quantiles] replaces it, leave it out"
            )
        return BaseRig(configuration, {"wire": wire, "alloy": alloy, "bench": bench}, own_voltages(configuration.wire))

    def _spool(self, base: BaseRig, values: Mapping[str, Value]) -> SimulatedSpool:
        """Return the wire, its alloy and bench for a set of values. Raises CallerError for one out of range."""
        changed: dict[str, dict[str, Parameter]] = {group: {} for group in GROUPS}
        for name, key in self.keys.items():
            if key.group:
                number, own = str(key.place[0]), base.groups[key.group]
                changed_to = {"value": float(values[name]), "kind": "assumed", "source": self.where, "note": "varied"}
                item = getattr(own, number).model_copy(update=changed_to)
                try:
                    checked(name, item, type(own).model_fields[number])
                except ValueError as problem:
                    raise CallerError(f"{self.where}: {problem}") from None
                changed[key.group][number] = item
        wire, alloy, bench = (base.groups[group].model_copy(update=changed[group]) for group in GROUPS)
        assert isinstance(wire, Wire)
        assert isinstance(alloy, Alloy)
        assert isinstance(bench, Bench)
        given = {*base.configuration.numbers_set(), *(str(key.place[0]) for key in self.keys.values() if key.group)}
        driven = driven_wire(base.configuration, (alloy, wire, bench), base.own, given, self.where)
        return SimulatedSpool(driven, alloy, bench, base.configuration.new_wire)

    def wire(self, values: Mapping[str, Value]) -> VariedWire:
        """Return the wire on its load, as in ``open``, without noise, steps of a converter and protection.

        Raises CallerError for values that cannot describe a wire, for two wires, moving air, pulses and faults.
        """
        base = self._base(values)
        refuse_what_only_a_rig_has(base.configuration, self.where)
        spool = self._spool(base, values)
        pretension_n = spool.bench["pretension_n"]
        mechanism = self._mechanism(base.configuration, spool)
        constants = spool.pulling(mechanism.load, (pretension_n if mechanism.stage else 0.0) + mechanism.added_n)
        return VariedWire(spool, constants, mechanism.tendon)

    def maximum_temperature_k(self, wire: VariedWire) -> float:
        """Return the highest temperature that the protection allows: by the rig file's limits, else the alloy."""
        own_k = highest_temperature_k(wire.spool.alloy)
        return self.configuration.limits.changed().get("maximum_temperature_k", own_k)

    def _mechanism(self, configuration: RigConfiguration, spool: SimulatedSpool) -> SimulatedLoad:
        """Return what the wire pulls; a load of parts is tabulated once for the same parts, pretension and leg."""
        pretension_n = spool.bench["pretension_n"]
        if not configuration.load:
            return mechanism_on(spool, (), pretension_n)
        of = (*configuration.load, pretension_n, spool.leg_length_m)
        if of not in self._mechanisms:
            if len(self._mechanisms) >= REMEMBERED:
                self._mechanisms.clear()
            self._mechanisms[of] = mechanism_on(spool, configuration.load, pretension_n)
        return self._mechanisms[of]

    def open(self, values: Mapping[str, Value], seed: int) -> GuardedRig:
        """Return the open rig, with 0 V out, instruments and protection; noise and moving air have the seed."""
        base = self._base(values)
        numbers = {str(key.place[0]): float(values[name]) for name, key in self.keys.items() if key.group == "bench"}
        spool = self._spool(base, values)
        return GuardedRig(
            device_of(base.configuration, self.where, spool, seed=seed, real_time=False, settings=numbers)
        )


def changed_file(
    configuration: RigConfiguration, changed: Mapping[tuple[str | int, ...], Value], where: str
) -> RigConfiguration:
    """Return a rig file with some keys changed, checked like a file."""
    plain = {str(place[0]): value for place, value in changed.items() if len(place) == 1}
    air = {str(place[1]): value for place, value in changed.items() if place[0] == "surroundings"}
    update: dict[str, object] = dict(plain)
    if air:
        given = {**configuration.surroundings.model_dump(), **air}
        update["surroundings"] = validated(Surroundings, given, f"{where}: surroundings")
    parts = list(configuration.load)
    for place, value in changed.items():
        if place[0] == "load":
            part = parts[int(place[1])]
            parts[int(place[1])] = validated(type(part), {**dict(part), str(place[2]): value}, f"{where}: {part.part}")
    if parts:
        update["load"] = validated(Parts, {"load": parts}, where).load
    return configuration.model_copy(update=update)


def refuse_what_only_a_rig_has(configuration: RigConfiguration, where: str) -> None:
    """Raise CallerError for a rig whose wire cannot be simulated by itself."""
    reasons = {
        "a second wire": any(part.second_wire is not None for part in configuration.load),
        "moving air": not configuration.surroundings.still,
        **{key.what: True for key in configuration.offered_keys().values()},
    }
    for reason, present in reasons.items():
        if present:
            raise CallerError(f'{where} has {reason}, which ideal readings leave out: say readings = "rig"')
