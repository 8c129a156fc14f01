"""What a study's page calls quantities and parameters, and the units that it shows them in."""

from __future__ import annotations

import numpy as np
import pytest

from musclewire.extras.studies._study_page import shown_column


@pytest.mark.parametrize(
    ("name", "unit", "label", "si", "shown"),
    [
        ("strain_gap", "1", "strain gap [%]", 0.0125, 1.25),
        ("resistance_min_ohm", "ohm", "least resistance [ohm]", 15.0, 15.0),
        ("temperature_max_k", "K", "largest temperature [°C]", 373.15, 100.0),
        ("ambient_temperature", "K", "ambient temperature [°C]", 295.15, 22.0),
        ("diameter_m", "m", "diameter [mm]", 1e-4, 0.1),
        ("mae_mean_pct", "1", "mean error [%]", 2.5, 2.5),
        ("spring_stiffness_n_per_m", "N/m", "spring stiffness [N/m]", 588.6, 588.6),
        ("fit_order", "1", "fit order", 6.0, 6.0),
    ],
)
def test_a_column_is_shown_in_words_and_in_a_common_unit(
    name: str, unit: str, label: str, si: float, shown: float
) -> None:
    column = shown_column(name, unit)
    assert column.label == label
    assert column.from_si(np.array([si])) == pytest.approx(shown)


def test_a_parameter_that_is_a_text_stays_a_text() -> None:
    assert shown_column("wire", "1").from_si(np.array(["flexinol-0.10-lt"])).tolist() == ["flexinol-0.10-lt"]
