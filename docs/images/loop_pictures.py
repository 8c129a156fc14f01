"""The picture of the closed loop on the pages on estimators and control: play, turn, crossing of B, draughts.

The simulated rig in its default loop. The displacement sensor, drawn with the estimate, is not seen by the loop.
"""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from musclewire.arrays import FloatArray
from musclewire.controllers import sampled_reference
from musclewire.experiment import characterize, control
from musclewire.identify import fit
from musclewire.pages import AVERAGE, COOLING, HEATING, TARGET
from musclewire.rigs import RigConfiguration, open_rig
from musclewire.sensing import SensingModel
from musclewire.signals import Recording, reference_quantity

SEED, DEVIATIONS = 11, 2.0
# Strain targets [%], and for how long each is held [s].
TARGETS, HOLD_S = (1.6, 2.4, 1.9, 2.2), 12.0
TURN_S, CROSSING_S = (34.0, 40.0), (0.0, 4.0)
DRAUGHT, DRAUGHT_S = 0.25, (20.0, 48.0)
TRUTH_GREY = "0.6"


def loop_figure() -> Figure:
    """Draw the four pictures."""
    with open_rig("simulated", seed=SEED) as rig:
        model = fit(characterize(rig))
    still, draughty = run_in(model, 0.0), run_in(model, DRAUGHT)
    figure = Figure(figsize=(9.6, 7.2), layout="constrained")
    axes = figure.subplots(2, 2)
    draw_play(axes[0, 0], model, still)
    draw_strain(axes[0, 1], still, CROSSING_S, "one crossing of B, from cold")
    draw_strain(axes[1, 0], still, TURN_S, "one turn: through the play to the heating branch")
    draw_strain(axes[1, 1], draughty, DRAUGHT_S, "draughts by a quarter: the heat loss is followed")
    for place in ((0, 1), (1, 0), (1, 1)):
        axes[place].set_xlabel("time [s]")
    draw_below(axes[0, 1].twinx(), still, CROSSING_S, "wire_resistance_ohm", "resistance [ohm]")
    draw_below(axes[1, 0].twinx(), still, TURN_S, "heating_part", "part between the branches")
    draw_below(axes[1, 1].twinx(), draughty, DRAUGHT_S, "convection_ratio", "heat loss, over that of still air")
    return figure


def run_in(model: SensingModel, draught: float) -> Recording:
    """Return a run of the default loop through all targets, in draughts of a relative deviation."""
    surroundings = {"draught": draught} if draught else {}
    rig_file = RigConfiguration.model_validate({"surroundings": surroundings})
    time_s = np.arange(0.0, HOLD_S * len(TARGETS), 0.05)
    targets = 0.01 * np.array(TARGETS)[np.minimum(time_s // HOLD_S, len(TARGETS) - 1).astype(int)]
    with open_rig(rig_file, seed=SEED) as rig:
        loop = {"estimator": "filter", "controller": "inverse-model"}
        return control(rig, model, sampled_reference(time_s, targets), **loop)


def draw_play(axes: Axes, model: SensingModel, run: Recording) -> None:
    """Draw strain over steady power: both branches of the slow loop, and the way of the run between them."""
    wire = model.wire_model
    assert wire is not None
    strain = 100.0 * model.quantity_max * wire.places
    sensed = wire.places > wire.sensed_from.value
    axes.plot(1e3 * np.array(wire.heating_power_w)[sensed], strain[sensed], color=HEATING, label="heating branch")
    axes.plot(1e3 * np.array(wire.cooling_power_w)[sensed], strain[sensed], color=COOLING, label="cooling branch")
    valid = run["valid"] > 0.0
    axes.plot(1e3 * run["balance_power_w"][valid], 100.0 * run["estimated_strain"][valid], color=AVERAGE,
        linewidth=1.0, label="the run")  # fmt: skip
    axes.set(xlabel="steady power [mW]", ylabel="strain [%]", title="the loop with the play in it")
    axes.legend(loc="upper left")


def draw_strain(axes: Axes, run: Recording, between_s: tuple[float, float], title: str) -> None:
    """Draw target, estimate with its 95 % interval, and the rig's own sensor over a part of a run."""
    rows = (run["time_s"] >= between_s[0]) & (run["time_s"] <= between_s[1])
    time_s, valid = run["time_s"][rows], run["valid"][rows] > 0.0
    said, half = (100.0 * run[one][rows] for one in ("estimated_strain", "estimate_std"))
    half = DEVIATIONS * half
    axes.plot(time_s, 100.0 * run["target_strain"][rows], color=TARGET, linewidth=1.0, label="target")
    axes.plot(time_s, 100.0 * measured_strain(run)[rows], color=TRUTH_GREY, linewidth=3.0, label="sensor")
    axes.plot(time_s[valid], said[valid], color=AVERAGE, linewidth=1.0, label="estimate, 95 %")
    axes.fill_between(time_s, said - half, said + half, where=valid, color=AVERAGE, alpha=0.2, linewidth=0.0)
    axes.set(ylabel="strain [%]", title=title)
    axes.legend(loc="lower right")


def draw_below(axes: Axes, run: Recording, between_s: tuple[float, float], column: str, name: str) -> None:
    """Draw a column of the recording on a scale of its own."""
    rows = (run["time_s"] >= between_s[0]) & (run["time_s"] <= between_s[1])
    axes.plot(run["time_s"][rows], run[column][rows], color=HEATING, linewidth=0.8, linestyle=":")
    axes.set_ylabel(name + " (dotted)")
    axes.grid(visible=False)


def measured_strain(run: Recording) -> FloatArray:
    """Return what the rig's displacement sensor says, as strain."""
    measured = reference_quantity(run, "strain")
    assert measured is not None
    return measured
