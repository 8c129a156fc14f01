"""One wire through time: our compiled step compared with SciPy on a comparable wire, in one process.

Ours is the whole wire: 160 grains in three phases with minor loops, heat in enthalpy form with Churchill and Chu's
convection, spring with guide friction, voltage divider, resistance. Theirs is what one writes with SciPy today, after
published single-crystal models (Seelecke and Mueller's kinetics): two phases, one pair of rate constants, bias spring
in closed form, constant convection, resistance; scalars and ``math`` only, no NumPy in the right-hand side. It leaves
out the R-phase, the spread of transformation temperatures (so minor loops), friction and the stress dependence of
martensite's strain: an easier wire.

Both go through one 90 s cycle of the slow sine; each row compares the same stretch of wire time. Open loop, SciPy
chooses its own steps; in closed loop the drive is new every 10 ms, so either is called 9,000 times.
Prints a table, or one JSON document with --json; --quick takes fewer runs.
"""

from __future__ import annotations

import argparse
import json
import math
import statistics
import time
from collections.abc import Callable

from scipy.integrate import solve_ivp

from musclewire.parameters import load_alloy, load_bench, load_wire
from musclewire.simulate.wires import advance
from musclewire.wire.building import constants_from, resting_state
from musclewire.wire.constants import WireConstants
from musclewire.wire.state import WireState

PERIOD_S = 90.0
CONTROL_PERIOD_S = 0.01
BAR_US_PER_STEP = 0.5
SENSE_V, AMPLITUDE_V = 0.3, 3.2


def drive_v(time_s: float) -> float:
    """Return the slow sine."""
    return SENSE_V + (AMPLITUDE_V - SENSE_V) * 0.5 * (1.0 - math.cos(2.0 * math.pi * time_s / PERIOD_S))


# The wire of the comparison: 0.1 mm, 14 cm in a V, 588.6 N/m, round numbers for NiTi.
AREA = math.pi / 4 * 100e-6**2
LENGTH, LEG = 0.14, 0.07
CAPACITY = 6450.0 * 500.0 * AREA * LENGTH  # J/K
LATENT = 6450.0 * 20e3 * AREA * LENGTH  # J
LOSS = 135.0 * math.pi * 100e-6 * LENGTH  # W/K
AMBIENT, PRETENSION, STIFFNESS, SERIES = 295.15, 1.9, 588.6, 1.0
T_M, C_M, BARRIER, SHARPNESS, RATE = 342.0, 8e6, 10.0, 1.5, 20.0
E_A, E_M, STROKE = 60e9, 30e9, 0.04
RHO_A, RHO_M, PER_K_A, PER_K_M = 0.86e-6, 0.95e-6, 2e-4, 6e-4
COLD_STRAIN = PRETENSION / (2 * AREA) / E_M + STROKE


def stress_and_resistance(temperature: float, martensite: float) -> tuple[float, float]:
    """Return the leg stress from the force balance, linear and so in closed form, and the resistance."""
    compliance = martensite / E_M + (1.0 - martensite) / E_A
    stress = (PRETENSION + STIFFNESS * LEG * (COLD_STRAIN - STROKE * martensite)) / (
        2.0 * AREA + STIFFNESS * LEG * compliance
    )
    warm = temperature - 293.15
    rho = martensite * RHO_M * (1.0 + PER_K_M * warm) + (1.0 - martensite) * RHO_A * (1.0 + PER_K_A * warm)
    stretch = 1.0 + STROKE * martensite
    return stress, rho * LENGTH / AREA * stretch * stretch / (1.0 + STROKE) ** 2


def rates(temperature: float, martensite: float, voltage: float) -> tuple[float, float]:
    """Return dT/dt and dx/dt: Joule heat, convection, latent heat, thermally activated jumps over a barrier."""
    stress, resistance = stress_and_resistance(temperature, martensite)
    advantage = T_M + stress / C_M - temperature
    to_martensite = RATE / (1.0 + math.exp(min(-(advantage - BARRIER) / SHARPNESS, 50.0)))
    to_austenite = RATE / (1.0 + math.exp(min((advantage + BARRIER) / SHARPNESS, 50.0)))
    change = (1.0 - martensite) * to_martensite - martensite * to_austenite
    current = voltage / (resistance + SERIES)
    heating = current * current * resistance - LOSS * (temperature - AMBIENT) + LATENT * change
    return heating / CAPACITY, change


def scipy_open_loop() -> None:
    """Solve the cycle in one call, with the state wanted every 10 ms."""
    wanted = [i * CONTROL_PERIOD_S for i in range(round(PERIOD_S / CONTROL_PERIOD_S) + 1)]
    solved = solve_ivp(
        lambda t, y: rates(y[0], y[1], drive_v(t)),
        (0.0, PERIOD_S),
        [AMBIENT, 1.0],
        method="LSODA",
        t_eval=wanted,
        rtol=1e-5,
        atol=1e-7,
    )
    assert solved.success
    assert solved.y[1].min() < 0.2, "the wire of the comparison must transform"


def scipy_closed_loop(periods: int) -> None:
    """Solve period by period around the hottest moment, with the drive held over each."""
    state = [AMBIENT, 1.0]
    for i in range(periods):
        voltage = drive_v(i * CONTROL_PERIOD_S)
        solved = solve_ivp(
            lambda _, y, v: rates(y[0], y[1], v),
            (0.0, CONTROL_PERIOD_S),
            state,
            method="LSODA",
            rtol=1e-5,
            atol=1e-7,
            args=(voltage,),
        )
        state = [float(solved.y[0, -1]), float(solved.y[1, -1])]


def our_wire() -> WireConstants:
    return constants_from(load_alloy("flexinol"), load_wire("paper-100um"), load_bench("paper"))


def our_cycle(wire: WireConstants, start: WireState, dt_s: float, hold_s: float) -> None:
    """Advance through the cycle, holding the drive for ``hold_s``."""
    state, steps = start, round(hold_s / dt_s)
    for i in range(round(PERIOD_S / hold_s)):
        state, _ = advance(state, wire, drive_v((i + 0.5) * hold_s), dt_s, steps)
    assert math.isfinite(state.temperature_k)


def median_seconds(run: Callable[[], None], runs: int) -> float:
    """Return the median of several runs after one that is not counted."""
    times = []
    for _ in range(runs + 1):
        begin = time.perf_counter()
        run()
        times.append(time.perf_counter() - begin)
    return statistics.median(times[1:])


def measured(runs: int, closed_loop_periods: int) -> list[dict[str, object]]:
    """Return the rows of the table."""
    wire = our_wire()
    start = resting_state(wire)
    periods = round(PERIOD_S / CONTROL_PERIOD_S)
    per_step = 1e6 * median_seconds(lambda: our_cycle(wire, start, 1e-3, 0.2), runs) / 90_000
    per_long_step = 1e6 * median_seconds(lambda: our_cycle(wire, start, 1e-2, 0.2), runs) / periods
    per_call = 1e6 * median_seconds(lambda: our_cycle(wire, start, 1e-3, CONTROL_PERIOD_S), runs) / periods
    their_open = 1e6 * median_seconds(scipy_open_loop, max(runs // 3, 2)) / periods
    their_closed = 1e6 * median_seconds(lambda: scipy_closed_loop(closed_loop_periods), 2) / closed_loop_periods

    def row(name: str, ours: float, theirs: float, what: str, **more: float) -> dict[str, object]:
        return {"name": name, "ours_us": ours, "theirs_us": theirs, "theirs": what, "ratio": theirs / ours, **more}

    lsoda = "SciPy LSODA, adaptive, per 10 ms of wire time"
    return [
        row("one step of 10 ms, open loop", per_long_step, their_open, lsoda, bar_us=BAR_US_PER_STEP),
        row(
            "one step of 1 ms, open loop",
            per_step,
            their_open / 10,
            "SciPy LSODA, adaptive, per 1 ms of wire time",
            bar_us=BAR_US_PER_STEP,
        ),
        row("10 ms in steps of 1 ms, called from Python", per_call, their_closed, "SciPy LSODA, a call every 10 ms"),
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="fewer runs")
    parser.add_argument("--json", action="store_true", help="one JSON document instead of a table")
    arguments = parser.parse_args()
    rows = measured(3, 300) if arguments.quick else measured(15, 9000)
    if arguments.json:
        print(json.dumps({"rows": rows}, indent=2))
        return
    print(f"{'one wire, 160 grains':44}{'ours us':>9}{'theirs us':>11}{'ratio':>8}  theirs")
    for row in rows:
        bar = f" (bar for a step: {row['bar_us']} us)" if "bar_us" in row else ""
        print(f"{row['name']:44}{row['ours_us']:9.3f}{row['theirs_us']:11.3f}{row['ratio']:8.1f}  {row['theirs']}{bar}")


if __name__ == "__main__":
    main()
