"""A simulated rig of which some numbers and keys vary: from values to a wire's constants, or to an open rig."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from pydantic.fields import FieldInfo

from musclewire.errors import CallerError, nearest_hint
from musclewire.parameters import (
    Alloy,
    Bench,
    ParameterGroup,
    ValidityLimits,
    Wire,
    checked,
    unit_of,
    validated,
    validity_of,
)
from musclewire.rigs._air import Surroundings
from musclewire.rigs._device import Metadata
from musclewire.rigs._guarded import GuardedRig
from musclewire.rigs._load_kinds import Parts
from musclewire.rigs._load_part import LoadPart
from musclewire.rigs._mechanism import FingerTendon, SimulatedLoad, mechanism_of
from musclewire.rigs._mounted_wire import SETTINGS
from musclewire.rigs._simulated import require_allowed_pull
from musclewire.rigs._simulated_configuration import RigConfiguration, changed_group, device_of, parameters_of
from musclewire.wire import SHAPE, OffsetDistribution, WireConstants, constants_of, measured_grains, spring_load

Value = float | str | bool
GROUPS: Mapping[str, type[ParameterGroup]] = {"wire": Wire, "alloy": Alloy, "bench": Bench}
# Keys of a rig file that have no unit: names, and whether the wire is new.
PLAIN_KEYS = ("wire", "bench", "new_wire")
# As many different rig files are remembered: a study goes through the names of its wires again and again.
REMEMBERED = 32


class VariedKey(NamedTuple):
    """What may vary: a number of wire, alloy or bench, or a key of the rig file.

    Parameters
    ----------
    unit
        SI unit, "1" for a fraction; "" for a key without a unit.
    group
        "wire", "alloy" or "bench"; "" for a key of the rig file.
    place
        Name of the number, or the tables and the key in the rig file; a part of the load by its position.
    """

    unit: str
    group: str
    place: tuple[str | int, ...]


class VariedWire(NamedTuple):
    """A wire of a varied rig without its instruments.

    Parameters
    ----------
    name
        Name of the wire.
    constants
        Its constants, load included.
    spool
        The wire's numbers by name.
    bench
        The bench's numbers by name.
    tendon
        The finger at the connector; None without one.
    validity
        What its alloy's data cover, and its vendor's limits.
    """

    name: str
    constants: WireConstants
    spool: Mapping[str, float]
    bench: Mapping[str, float]
    tendon: FingerTendon | None
    validity: ValidityLimits

    def facts(self) -> Metadata:
        """Return the metadata of a recording that describe wire and circuit, as its rig states them."""
        bench = self.bench
        return {
            "rig": "simulated",
            "wire": self.name,
            "wire_diameter_m": self.spool["diameter_m"],
            "wire_length_m": bench["wire_length_m"],
            "leg_length_m": bench["wire_length_m"] / bench["legs"],
            "shunt_resistance_ohm": bench["shunt_resistance_ohm"],
            "maximum_force_n": self.spool["maximum_force_n"],
            **self.validity.facts(),
            "pretension_n": self.constants.pretension_n,
            "sample_period_s": bench["sample_period_s"],
        }


class BaseRig(NamedTuple):
    """A rig file with its own numbers, before any of them varies."""

    configuration: RigConfiguration
    groups: Mapping[str, ParameterGroup]
    numbers: Mapping[str, dict[str, float]]
    grains: OffsetDistribution | None


def keys_of(configuration: RigConfiguration) -> dict[str, VariedKey]:
    """Return everything that may vary on a simulated rig, by name.

    Parameters
    ----------
    configuration
        The rig file; its parts of a load have their keys here, as ``load.contact.stiffness``.

    Returns
    -------
    Numbers of wire, alloy and bench by their names and by their keys in a rig file, then the file's other keys.
    """
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
    """A simulated rig of which some numbers and keys vary.

    Parameters
    ----------
    configuration
        The rig file.
    where
        Its name in messages.
    names
        What varies, each one of ``keys_of``.

    Raises
    ------
    CallerError
        For a name that nothing on this rig has, suggesting the nearest, and for a number that has no effect on it.
    """

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
        alloy, wire, bench = parameters_of(configuration, self.where, None, None, {})
        groups: dict[str, ParameterGroup] = {"wire": wire, "alloy": alloy, "bench": bench}
        grains = measured_grains(alloy)
        shape = [name for name, key in self.keys.items() if key.place[0] in SHAPE]
        if grains is not None and shape:
            raise CallerError(
                f"{self.where}: '{shape[0]}' has no effect: the alloy's [grain_quantiles] replaces it, leave it out"
            )
        return BaseRig(configuration, groups, {group: item.values() for group, item in groups.items()}, grains)

    def _numbers(self, values: Mapping[str, Value], base: BaseRig) -> dict[str, dict[str, float]]:
        """Return the numbers of wire, alloy and bench for a set of values. Raises CallerError for one out of range."""
        found = {group: dict(numbers) for group, numbers in base.numbers.items()}
        for name, key in self.keys.items():
            if key.group:
                number, schema = str(key.place[0]), type(base.groups[key.group])
                item = getattr(base.groups[key.group], number).model_copy(update={"value": float(values[name])})
                try:
                    checked(name, item, schema.model_fields[number])
                except ValueError as problem:
                    raise CallerError(f"{self.where}: {problem}") from None
                found[key.group][number] = item.value
        return found

    def wire(self, values: Mapping[str, Value]) -> VariedWire:
        """Return the wire on its load, without noise, steps of a converter and protection.

        Parameters
        ----------
        values
            A value for every name, numbers in SI.

        Returns
        -------
        The wire's constants with the numbers they were made of; the same as in the rig that ``open`` returns.

        Raises
        ------
        CallerError
            For values that cannot describe a wire, for two wires, moving air, pulses and faults.
        """
        base = self._base(values)
        refuse_what_only_a_rig_has(base.configuration, self.where)
        numbers = self._numbers(values, base)
        spool, bench = numbers["wire"], numbers["bench"]
        name, allowed_n = str(base.groups["wire"].name), spool["maximum_force_n"]
        require_allowed_pull(bench["pretension_n"], allowed_n, name)
        mechanism = self._mechanism(base.configuration, bench)
        cold_n = (bench["pretension_n"] if mechanism.stage else 0.0) + mechanism.added_n
        require_allowed_pull(cold_n, allowed_n, name)
        constants = constants_of(
            numbers["alloy"],
            spool,
            {**bench, "pretension_n": cold_n},
            load=mechanism.load,
            new_wire=base.configuration.new_wire,
            distribution=base.grains,
        )
        validity = validity_of(base.groups["alloy"])  # type: ignore[arg-type]  # by its key
        return VariedWire(name, constants, spool, bench, mechanism.tendon, validity)

    def _mechanism(self, configuration: RigConfiguration, bench: Mapping[str, float]) -> SimulatedLoad:
        """Return what the wire pulls; a load of parts is tabulated once for the same parts, pretension and leg."""
        if not configuration.load:
            return SimulatedLoad(spring_load(bench["spring_stiffness_n_per_m"]), 0.0, True, None)
        leg_length_m = bench["wire_length_m"] / bench["legs"]
        of = (*configuration.load, bench["pretension_n"], leg_length_m)
        if of not in self._mechanisms:
            if len(self._mechanisms) >= REMEMBERED:
                self._mechanisms.clear()
            self._mechanisms[of] = mechanism_of(
                configuration.load, pretension_n=bench["pretension_n"], leg_length_m=leg_length_m
            )
        return self._mechanisms[of]

    def open(self, values: Mapping[str, Value], seed: int) -> GuardedRig:
        """Return the open rig, with its instruments and its protection.

        Parameters
        ----------
        values
            A value for every name, numbers in SI.
        seed
            Seed of the instruments' noise and of the air's movement.

        Returns
        -------
        The rig with 0 V at its output.

        Raises
        ------
        CallerError
            For values that cannot belong to a rig.
        """
        base = self._base(values)
        alloy, wire, bench = (self._group(base, group, values) for group in ("alloy", "wire", "bench"))
        assert isinstance(alloy, Alloy)
        assert isinstance(wire, Wire)
        assert isinstance(bench, Bench)
        numbers = {str(key.place[0]): float(values[name]) for name, key in self.keys.items() if key.group == "bench"}
        device = device_of(
            base.configuration, self.where, (alloy, wire, bench), seed=seed, real_time=False, settings=numbers
        )
        return GuardedRig(device)

    def _group(self, base: BaseRig, group: str, values: Mapping[str, Value]) -> ParameterGroup:
        """Return wire, alloy or bench with the values that belong to it."""
        own = base.groups[group]
        changed = {
            str(key.place[0]): getattr(own, str(key.place[0])).model_copy(
                update={"value": float(values[name]), "kind": "assumed", "source": self.where, "note": "varied"}
            )
            for name, key in self.keys.items()
            if key.group == group
        }
        return changed_group(own, changed, self.where)


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
        "faults": bool(configuration.fault),
        "heating by pulse width": configuration.pwm is not None,
    }
    for reason, present in reasons.items():
        if present:
            raise CallerError(f'{where} has {reason}, which ideal readings leave out: say readings = "rig"')
