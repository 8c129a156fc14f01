"""Views of a sensing model: text, table, figure and the numbers of ``musclewire fit``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from musclewire.pages import notebook_table
from musclewire.registry import REPLACED
from musclewire.sensing._branch_equations import evaluate
from musclewire.sensing._curve import SHOWN_AS
from musclewire.sensing._fit_report import FittedCurve
from musclewire.sensing._wire_model import default_estimator
from musclewire.signals import fact_in_words

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def report(model: FittedCurve) -> dict[str, Any]:
    """Return the numbers of ``musclewire fit --json``: gap in percent of the maximum, errors in percent strain.

    For displacement and force the errors are in percent of the largest quantity.
    """
    full = 1.0 if model.quantity == "strain" else model.quantity_max
    return {
        "quantity": model.quantity,
        "strain_gap_pct": 100.0 * model.hysteresis_gap,
        "resistance_min_ohm": model.resistance_min_ohm,
        "resistance_max_ohm": model.resistance_max_ohm,
        "order": model.order,
        "rmse_heating_pct": 100.0 * model.rmse_heating / full,
        "rmse_cooling_pct": 100.0 * model.rmse_cooling / full,
        "rmse_average_pct": 100.0 * model.rmse_average / full,
        "samples": model.samples,
        "controller": gains_controller(model),
        "no_gains": model.no_gains or None,
        "holds": model.holds,
        "does_not_hold": model.does_not_hold or None,
        "warnings": list(model.warnings),
        "wire_model": wire_numbers(model),
    }


def wire_numbers(model: FittedCurve) -> dict[str, dict[str, float | str]] | None:
    """Return value, standard deviation and origin of each number of a model's wire; None if it has none."""
    if model.wire_model is None:
        return None
    return {name: vars(number) for name, number in model.wire_model.numbers.items()}


def gains_controller(model: FittedCurve) -> str | None:
    """Return the name of the controller whose gains a model keeps, None if it keeps none."""
    name = str(model.gains.get("controller", ""))
    return REPLACED.get(name, name) or None


def rows(model: FittedCurve) -> list[tuple[str, str]]:
    """Return the main figures of a model, as pairs of name and text."""
    factor, unit = SHOWN_AS[model.quantity]
    low, high = model.valid_resistance_ohm
    estimator, without_filter = default_estimator(model)
    errors = {"heating": model.rmse_heating, "cooling": model.rmse_cooling, "average": model.rmse_average}
    return [
        ("quantity", f"{model.quantity} in {unit}"),
        ("resistance at C and B", f"{model.resistance_min_ohm:.4f} and {model.resistance_max_ohm:.4f} ohm"),
        ("valid resistance", f"{low:.4f} to {high:.4f} ohm"),
        (
            f"valid {model.quantity}",
            f"{factor * model.quantity_min:.3f} to {factor * model.quantity_max:.3f} {unit}",
        ),
        ("gap of the branches", f"{100 * model.hysteresis_gap:.3f} %"),
        ("polynomial order", str(model.order)),
        (
            "curve's misfit, rms",
            ", ".join(f"{name} {factor * error:.4f}" for name, error in errors.items()) + f" {unit}",
        ),
        ("samples", str(model.samples)),
        ("estimator", without_filter or estimator),
        ("gains", gains_controller(model) or f"none: {model.no_gains or 'not looked for'}"),
        *[fact_in_words(name, value) for name, value in model.wire.items()],
        ("created by", model.created_by),
        *[("source", model.source)][: bool(model.source)],
        *[("does not hold", model.does_not_hold)][: not model.holds],
        *[("warning", warning) for warning in model.warnings],
    ]


def summary(model: FittedCurve) -> str:
    """Return the rows as aligned text."""
    pairs = rows(model)
    width = max(len(name) for name, _ in pairs)
    return "\n".join(f"{name:<{width}}  {text}" for name, text in pairs)


def html(model: FittedCurve) -> str:
    """Return the rows as a table for a notebook."""
    return notebook_table("Sensing model", (), rows(model))


def plot_samples(model: FittedCurve, axes: Axes, factor: float) -> None:
    """Draw the kept samples of both branches, the quantity times ``factor``."""
    from musclewire.pages import COOLING, HEATING

    for pairs, name, colour in (
        (model.heating_samples, "heating", HEATING),
        (model.cooling_samples, "cooling", COOLING),
    ):
        if pairs:
            resistance, quantity = np.array(pairs).T
            axes.plot(resistance, factor * quantity, ".", color=colour, alpha=0.4, label=f"{name}, measured")


def plot_model(model: FittedCurve, axes: Axes | None = None, style: str = "screen") -> Axes:
    """Draw the quantity against resistance as in Lan and Fan 2010, Fig. 9, and return the axes."""
    from musclewire.figures import axes_to_draw_on  # only drawing needs matplotlib
    from musclewire.pages import AVERAGE, COOLING, HEATING

    factor, unit = SHOWN_AS[model.quantity]
    fraction = np.linspace(model.normalised_min, model.normalised_max, 300)
    resistance = model.resistance_min_ohm + fraction * (model.resistance_max_ohm - model.resistance_min_ohm)
    with axes_to_draw_on(axes, style) as here:
        plot_samples(model, here, factor)
        for coefficients, name, colour, line in (
            (model.heating_coefficients, "heating polynomial", HEATING, "-"),
            (model.cooling_coefficients, "cooling polynomial", COOLING, "-"),
            (model.average_coefficients, "average", AVERAGE, "--"),
        ):
            here.plot(resistance, factor * evaluate(coefficients, fraction), line, color=colour, label=name)
        here.set(xlabel="wire resistance [ohm]", ylabel=f"{model.quantity} [{unit}]")
        here.set_title(f"Self-sensing model, gap {100 * model.hysteresis_gap:.2f} %")
        here.legend()
        return here
