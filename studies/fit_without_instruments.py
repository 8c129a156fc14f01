"""How far off is a model fitted to resistance alone, and does it say so?

Wires are drawn from the spreads around paper-100um (named-wire.toml of the extra calibration): temperatures by 5 K,
resistivity by 3 %, convection by 10 %, strains by 7 %, the alloy's other numbers by half of their prior, length by
0.7 %, load by 3 %, air by 1 K. Each runs the slow sine on the simulated rig with all its noise. The user states the
name, the nominal length and load, and:

- the name alone;
- two marks, cold and hot, each with an error of 0.7 % of the stroke, so that the stroke's is 1 %;
- a ruler: both marks with an error of 1 mm, on a leg of 70 mm;
- an end stop at 85 % of the stroke, whose place is known to 0.05 mm;
- beside it the named wire's own curve between the measured R_min and R_max, without any fit to the resistance;
- and the same loop with a displacement sensor, as `fit` takes it.

Each model is judged on another recording of the same wire, two slow sines with other noise, against the true strain,
in percent of the wire's stroke, over the samples between B and C that lie in the model's range: root mean square of the
branch on which the wire is, of the average of both branches as the paper's estimator takes it, and the share of samples
in which the average is within 1.96 of its standard deviations. Bars, over all wires: 6 % from the name, 2.5 % with the
marks, a ruler not worse than the name alone, 90 to 99 % inside for each of them. Exit 1 where one fails. Seeds 1 to 12
were used while it was built; 1001 to 1030 are reported.

With `--population` the wires are the first six that `musclewire robustness` is tuned on: half of them in segments,
with other grains and several barriers, which the fit knows nothing of. They are judged on the recording that is
fitted; no bars. That needs `pip install ./studies/robustness`.

    python studies/fit_without_instruments.py --population
    python studies/fit_without_instruments.py [--quick]     30 wires, or 4 without a
                                                               verdict on fractions
"""

from __future__ import annotations

import sys
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np

import musclewire as mw
from musclewire.errors import MusclewireError
from musclewire.extras.calibration import CandidateParameters, WireValues, priors_around
from musclewire.judge import resistance_reading
from musclewire.parameters import Alloy, Bench, Wire, load_alloy, load_bench, load_wire
from musclewire.rigs import Contact, GuardedRig, SimulatedDevice, SimulatedSpool, Spring
from musclewire.sensing import find_loops
from musclewire.signals import Recording

WIRE, FIRST_SEED, WIRES, QUICK_WIRES = "paper-100um", 1001, 30, 4
BARS_PCT = {"name alone": 6.0, "marks of 1 %": 2.5}
COVERAGE_BARS = (0.90, 0.99)
# Relative error of one mark, so that their difference has 1 % of the stroke.
MARK_STD = 0.01 / 2.0**0.5
LENGTH_M, RULER_M = 0.5e-3, 1e-3
STOP_FRACTION, STOP_STD_M, STOP_STIFFNESS = 0.85, 0.05e-3, 1e6
POPULATION_WIRES, POPULATION_DRIVE = 6, 1.08
STATED = ("wire_length_m", "pretension_n", "spring_stiffness_n_per_m")


class Judged(NamedTuple):
    """Errors of one model on one wire [% of stroke], and what it said of itself.

    ``rms_pct`` is that of the branch on which the wire is, ``average_pct`` that of the mean of both, as the paper's
    estimator has it; ``inside`` is the share of the latter within 1.96 of its standard deviations.
    """

    rms_pct: float
    average_pct: float
    inside: float
    stated_pct: float


def drawn_wire(seed: int) -> WireValues:
    """Return a wire of this seed on its bench; draws whose phases have no order are drawn again."""
    wire = load_wire(WIRE)
    alloy, bench = load_alloy(wire.alloy), load_bench("paper")
    candidates = CandidateParameters(priors_around(alloy, wire, bench), alloy, wire, bench)
    random = np.random.default_rng(seed)
    while True:
        values = candidates.wire_values(candidates.draw(random))
        try:
            device_of(values, seed)
        except MusclewireError:
            continue
        return values


def with_values(group: Alloy | Wire | Bench, values: dict[str, float]) -> Alloy | Wire | Bench:
    """Return an alloy, wire or bench with these numbers."""
    return group.model_copy(
        update={name: item.model_copy(update={"value": values[name]}) for name, item in group.items()}
    )


def device_of(values: WireValues, seed: int, end_stop_m: float | None = None) -> SimulatedDevice:
    """Return a simulated rig with this wire, all of its noise, this seed, and a stop in the way of its connector."""
    wire = load_wire(WIRE)
    groups = (wire, values.wire), (load_alloy(wire.alloy), values.alloy), (load_bench("paper"), values.bench)
    spool = SimulatedSpool(*(with_values(group, numbers) for group, numbers in groups))
    if end_stop_m is None:
        return SimulatedDevice(spool, seed=seed)
    spring = Spring(part="spring", stiffness=values.bench["spring_stiffness_n_per_m"])
    stop = Contact(part="contact", stiffness=STOP_STIFFNESS, clearance=end_stop_m)
    return SimulatedDevice(spool, parts=[spring, stop], seed=seed)


def slow_loop(values: WireValues, seed: int, end_stop_m: float | None = None) -> Recording:
    """Return two slow sines of a wire, with instruments."""
    with GuardedRig(device_of(values, seed, end_stop_m)) as rig:
        return mw.characterize(rig)


@cache
def named_curve() -> mw.SensingModel:
    """Return the model of the wire of this name as it ships, with a displacement sensor."""
    with mw.open_rig("simulated") as rig:
        return mw.fit(mw.characterize(rig))


def as_stated(loop: Recording) -> Recording:
    """Return the electrical columns of a recording, with what its user believes of the bench."""
    bench = load_bench("paper").values()
    kept = {name: loop[name] for name in ("time_s", "drive_voltage_v", "wire_voltage_v", "shunt_voltage_v")}
    stated = {name: bench[name] for name in STATED if name in bench}
    stated["leg_length_m"] = bench["wire_length_m"] / bench["legs"]
    return Recording(kept, {**loop.metadata, **stated})


def judged(model: mw.SensingModel, loop: Recording, stated_pct: float) -> Judged:
    """Return the errors of a model in its range, between B and C of a recording with its true length and motion."""
    true = loop["displacement_m"] / loop.facts.leg_length_or_none_m
    reading = resistance_reading(loop)
    off, off_average, inside = [], [], []
    for segments in find_loops(reading.resistance_ohm, true, reading.valid):
        for rows, branch in (
            (slice(segments.heating_b, segments.heating_c + 1), model.strain_heating),
            (slice(segments.cooling_c, segments.cooling_b + 1), model.strain_cooling),
        ):
            resistance, strain = reading.resistance_ohm[rows], true[rows]
            usable = (resistance >= model.valid_resistance_ohm[0]) & (resistance <= model.valid_resistance_ohm[1])
            average = model.estimate(resistance[usable])
            off.append(branch(resistance[usable]) - strain[usable])
            off_average.append(average.value - strain[usable])
            inside.append(np.abs(off_average[-1]) <= 1.96 * average.std)
    stroke = true.max()
    return Judged(
        percent_rms(off, stroke), percent_rms(off_average, stroke), float(np.concatenate(inside).mean()), stated_pct
    )


def percent_rms(off: list[np.ndarray], stroke: float) -> float:
    """Return the root mean square of errors in percent of the stroke."""
    return 100.0 * float(np.sqrt(np.mean(np.concatenate(off) ** 2)) / stroke)


def one_wire(seed: int) -> dict[str, Judged]:
    """Return the errors of every way to fit one wire."""
    values = drawn_wire(seed)
    loop, other = slow_loop(values, seed), slow_loop(values, seed + 100_000)
    random = np.random.default_rng([seed, 1])
    stroke_m = float(loop["displacement_m"].max())

    def marks(reading_std_m: float, length_std_m: float) -> mw.Marks:
        cold_m, hot_m = random.normal([0.0, stroke_m], reading_std_m)
        return mw.Marks(cold_m=cold_m, hot_m=hot_m, reading_std_m=reading_std_m, leg_length_std_m=length_std_m)

    def stretched(model: mw.SensingModel) -> Judged:
        ends = {name: getattr(model, name) for name in ("resistance_min_ohm", "resistance_max_ohm")}
        return judged(replace(named_curve(), **ends), other, 0.0)

    def fitted(known: mw.Marks | None = None, recorded: Recording = loop) -> Judged:
        found = mw.fit_resistance(as_stated(recorded), WIRE, marks=known)
        return judged(found.model, other, 100.0 * found.stroke_std / found.stroke)

    stop_m = STOP_FRACTION * stroke_m
    stopped = slow_loop(values, seed, stop_m)
    believed = mw.Marks(end_stop_m=stop_m + random.normal(0.0, STOP_STD_M), reading_std_m=STOP_STD_M)

    return {
        "name alone": fitted(),
        "marks of 1 %": fitted(marks(MARK_STD * stroke_m, LENGTH_M)),
        "ruler of 1 mm": fitted(marks(RULER_M, LENGTH_M)),
        "end stop": fitted(believed, stopped),
        "name's curve": stretched(mw.fit(loop)),
        "with a sensor": judged(mw.fit(loop), other, 0.0),
    }


def pooled_rms(numbers: list[float]) -> float:
    """Return the root mean square over all wires."""
    return float(np.sqrt(np.mean(np.square(numbers))))


def of_population(seed: int) -> dict[str, Judged]:
    """Return the errors on a wire whose structure no model here has."""
    from musclewire_robustness.plant import open_plant
    from musclewire_robustness.population import drawn_wire as population_wire

    wire = population_wire(seed)
    with open_plant(wire).rig as rig:
        loop = mw.characterize(rig, amplitude_v=POPULATION_DRIVE * load_wire(wire.base).drive_amplitude_v.value)
    stroke_m = float(loop["displacement_m"].max())
    marks = mw.Marks(cold_m=0.0, hot_m=stroke_m, reading_std_m=MARK_STD * stroke_m)
    found = {"name alone": mw.fit_resistance(loop, wire.base), "marks": mw.fit_resistance(loop, wire.base, marks=marks)}
    return {name: judged(item.model, loop, 100.0 * item.stroke_std / item.stroke) for name, item in found.items()} | {
        "with a sensor": judged(mw.fit(loop), loop, 0.0)
    }


def population() -> int:
    """Print the errors on wires of another structure; return 0."""
    found = [of_population(seed) for seed in mw.tuning_seeds()[:POPULATION_WIRES]]
    print("% of stroke, wires of another structure\n\n               rms  worst  inside 95 %  stated std")
    for name in found[0]:
        rows = [one[name] for one in found]
        print(
            f"{name:13s}{pooled_rms([row.rms_pct for row in rows]):6.2f}{max(row.rms_pct for row in rows):7.2f}"
            f"{100.0 * np.mean([row.inside for row in rows]):13.1f}{pooled_rms([row.stated_pct for row in rows]):12.2f}"
        )
    return 0


def main() -> int:
    if "--population" in sys.argv:
        return population()
    wires = QUICK_WIRES if "--quick" in sys.argv else WIRES
    first = int(sys.argv[sys.argv.index("--first") + 1]) if "--first" in sys.argv else FIRST_SEED
    rows: dict[str, list[Judged]] = {}
    print("% of stroke, rms of the branches, on another recording")
    for seed in range(first, first + wires):
        found = one_wire(seed)
        for name, row in found.items():
            rows.setdefault(name, []).append(row)
        print(f"wire {seed}: " + ", ".join(f"{name} {row.rms_pct:.2f}" for name, row in found.items()), flush=True)
    return verdict(rows, fractions="--quick" not in sys.argv)


def verdict(rows: dict[str, list[Judged]], fractions: bool) -> int:
    """Print medians, worst and pooled errors and what the models say of themselves; return the exit code.

    Without ``fractions`` the shares inside are not judged: a few wires are too few for them.
    """
    print(f"\n{'':16s}{'rms':>7s}{'median':>8s}{'worst':>7s}{'average':>9s}{'inside 95 %':>13s}{'stated std':>12s}")
    pooled = {name: pooled_rms([row.rms_pct for row in found]) for name, found in rows.items()}
    inside = {name: float(np.mean([row.inside for row in found])) for name, found in rows.items()}
    for name, found in rows.items():
        errors = [row.rms_pct for row in found]
        stated, average = (pooled_rms([getattr(row, key) for row in found]) for key in ("stated_pct", "average_pct"))
        print(
            f"{name:16s}{pooled[name]:7.2f}{np.median(errors):8.2f}{max(errors):7.2f}{average:9.2f}"
            f"{100.0 * inside[name]:13.1f}{stated:12.2f}"
        )
    low, high = COVERAGE_BARS
    checks = {f"{name}: at most {bar:g} %": pooled[name] <= bar for name, bar in BARS_PCT.items()}
    checks["ruler not worse than the name alone"] = pooled["ruler of 1 mm"] <= pooled["name alone"]
    for name in ("name alone", "marks of 1 %", "ruler of 1 mm", "end stop") if fractions else ():
        checks[f"{name}: 90 to 99 % inside"] = low <= inside[name] <= high
    worse = sum(
        ruler.rms_pct > alone.rms_pct + 0.1
        for ruler, alone in zip(rows["ruler of 1 mm"], rows["name alone"], strict=True)
    )
    print(f"\nthe ruler's marks made {worse} of {len(rows['name alone'])} wires worse by more than 0.1 % of stroke")
    for text, holds in checks.items():
        print(f"{'holds' if holds else 'FAILS'}: {text}")
    return 0 if all(checks.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
