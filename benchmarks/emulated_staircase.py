"""The paper's staircase through the real firmware in its emulator, compared with the same run on the simulated rig.

Three closed loops on the same simulated wire with the same sensing model (firmware/models/paper-100um.json): the host's
loop on the simulated rig; the host's loop over the serial protocol, through the firmware, its converter and its output
stage; and the loop in C on the board, which gets targets only. The board has no instrument: its true strain comes from
the bench's own log, sample by sample, after the run. Steps are judged by Eq. 7 from the first target on, the wire cold
at first. Bar: every step within 0.3 % of the target of the simulated rig's. Exit 1 beyond. Without a host it is
`python -m emulation.staircase`.

    PYTHONPATH=. python benchmarks/emulated_staircase.py [--quick]     11 steps of 6 s, or 3
"""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from emulation.board import EmulatedBoard

from musclewire.controllers import Staircase, staircase
from musclewire.experiment import ControlRun, control, control_metrics, control_on_board, determined
from musclewire.extras.board import SerialConfiguration
from musclewire.rigs import open_rig, rig_configuration
from musclewire.sensing import SensingModel, load_model
from musclewire.signals import Recording

ROOT = Path(__file__).resolve().parent.parent
BAR_PCT = 0.3
PATIENCE_S = 20.0
COLD_K = 295.15

# What the firmware runs, on the host.
LOOP: dict[str, Any] = {"estimator": "filter", "controller": "inverse-model"}


def rig_file(port: str) -> SerialConfiguration:
    """Return the rig file that comes with musclewire, at a board's port."""
    shipped = rig_configuration("serial-board")[0]
    assert isinstance(shipped, SerialConfiguration)
    return shipped.model_copy(update={"port": port, "patience": PATIENCE_S, "lockstep": True})


def on_simulated(model: SensingModel, reference: Staircase) -> ControlRun:
    """Return the run on the simulated rig, its drive within the board's limits."""
    mounted = rig_file("none")
    with open_rig("simulated", sense_voltage_v=mounted.sense_voltage, maximum_voltage_v=mounted.maximum_voltage) as rig:
        return control(rig, model, reference, **LOOP)


def on_emulated(model: SensingModel, reference: Staircase, *, closed_by_board: bool) -> ControlRun:
    """Return the run through the firmware, with the true displacement from the bench's log as its instrument."""
    with EmulatedBoard(pace="lockstep") as board:
        with open_rig(rig_file(board.port_url), wire_temperature_k=COLD_K) as rig:
            run = control_on_board(rig, model, reference) if closed_by_board else control(rig, model, reference, **LOOP)
        truth = board.log()["displacement_m"]
    # No tick passes before the first command, so the samples are the bench's ticks from the first one on.
    ticks = round(float(run.metadata["sample_period_s"] or 0.0) / float(run.metadata["board_tick_s"] or 1.0))
    displacement_m = truth[: len(run) * ticks].reshape(len(run), ticks).mean(axis=1)
    columns = {**run.columns, "displacement_m": displacement_m}
    judged = Recording(columns, run.metadata)
    return ControlRun(judged.columns, judged.metadata, control_metrics(judged, model.quantity, reference))


def main() -> int:
    quick = "--quick" in sys.argv
    reference = staircase(0.021, 0.024, 0.003) if quick else staircase()
    model = load_model(ROOT / "firmware" / "models" / "paper-100um.json")
    runs: dict[str, ControlRun] = {}
    for name, make in (
        ("simulated", lambda: on_simulated(model, reference)),
        ("firmware", lambda: on_emulated(model, reference, closed_by_board=False)),
        ("on board", lambda: on_emulated(model, reference, closed_by_board=True)),
    ):
        began_s = time.perf_counter()
        runs[name] = make()
        print(
            f"{name}: {len(runs[name])} samples, {runs[name].metadata['ended']}, {time.perf_counter() - began_s:.0f} s"
        )
    print(f"\nMAE in % of the target (Eq. 7)\n{'target %':>9} {'':7}" + "".join(f"{name:>11}" for name in runs))
    errors = np.array([[determined(step.mae_pct, "a step") for step in run.metrics.steps] for run in runs.values()])
    for step, row in zip(runs["simulated"].metrics.steps, errors.T, strict=True):
        print(f"{100 * step.target:>9.2f} {step.direction:7}" + "".join(f"{value:>11.3f}" for value in row))
    print(f"{'mean':>17}" + "".join(f"{value:>11.3f}" for value in errors.mean(axis=1)))
    apart = np.abs(errors[1:] - errors[0]).max(axis=1)
    print(f"largest difference from simulated: firmware {apart[0]:.3f} %, on board {apart[1]:.3f} % (bar {BAR_PCT} %)")
    missed = not (apart <= BAR_PCT).all()
    print("the bar is missed" if missed else "the bar holds")
    return int(missed)


if __name__ == "__main__":
    sys.exit(main())
