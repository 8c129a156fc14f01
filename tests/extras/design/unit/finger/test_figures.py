"""What a picture of a finger says, read from the figure's own objects."""

from __future__ import annotations

import re

from fingers import CURVED
from matplotlib.figure import Figure

from musclewire.extras.design._finger.figures import plot_finger
from musclewire.extras.design._finger.finger_study import FingerStudy, FingerStudyResult, study_finger
from musclewire.parameters import load_material
from musclewire.wire import ElasticObject


def answered(obstacle: ElasticObject | None) -> FingerStudyResult:
    return study_finger(
        FingerStudy(load_material("pom"), 5e-3, 1.0e-3, geometry=CURVED, obstacle=obstacle, finite_elements=False)
    )


def labels(figure: Figure) -> list[str]:
    return [text for axes in figure.axes for text in (axes.get_xlabel(), axes.get_ylabel()) if text]


def test_every_axis_names_quantity_and_unit_in_brackets() -> None:
    for label in labels(plot_finger(answered(None))):
        assert re.search(r"\w+.* \[(mm|N|MPa)\]", label), label


def test_with_an_object_both_the_free_and_the_touching_finger_are_marked_and_named() -> None:
    answer = answered(ElasticObject(100.0, 3e-3))
    figure = plot_finger(answer)
    force = next(axes for axes in figure.axes if "force" in axes.get_ylabel())
    named = {line.get_label(): line.get_ydata()[0] for line in force.get_lines()}
    assert answer.contact is not None
    assert named["free, requested endpoint"] == answer.at.tendon_force_n
    assert named["on the object"] == answer.contact.tendon_force_n
    legend = force.get_legend()
    assert legend is not None
    assert "on the object" in [text.get_text() for text in legend.get_texts()]
    assert figure.axes[0].get_title().endswith("on the object")


def test_without_an_object_there_is_one_mark_and_no_legend() -> None:
    force = next(axes for axes in plot_finger(answered(None)).axes if "force" in axes.get_ylabel())
    assert force.get_legend() is None
