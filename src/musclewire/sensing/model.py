"""The self-sensing model as users hold it: a fitted curve that can be saved, shown and read again."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from musclewire.sensing import model_view
from musclewire.sensing.fit_report import FittedCurve

if TYPE_CHECKING:
    from os import PathLike

    from matplotlib.axes import Axes

__all__ = ["SensingModel", "load_model"]


@dataclass(frozen=True, repr=False)
class SensingModel(FittedCurve):
    """Strain (or displacement, force) from resistance, the report of its fit, and how both are kept and shown.

    The numbers an estimator runs by are those of :class:`~musclewire.sensing.curve.ResistanceCurve`, what the fit says
    of them those of :class:`~musclewire.sensing.fit_report.FittedCurve`; ``model_file`` and ``model_view`` write and
    draw them and know nothing of this class, which only makes them methods.
    """

    def save(self, path: str | PathLike[str]) -> None:
        """Write the model as JSON, whole or not at all.

        Parameters
        ----------
        path
            File to write; one that exists is replaced.

        Raises
        ------
        CallerError
            If the file cannot be written there.
        """
        # Only files need pydantic, which takes longer to import than all the rest.
        from musclewire.sensing.model_file import save_model

        save_model(self, path)

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw strain against resistance: samples if they were kept, both branches, their mean.

        Parameters
        ----------
        axes
            Where to draw; new axes without.

        Returns
        -------
        The axes.
        """
        return model_view.plot_model(self, axes)

    def report(self) -> dict[str, Any]:
        """Return the numbers of ``musclewire fit --json``; percentages are of strain, or of the largest quantity."""
        return model_view.report(self)

    def summary(self) -> str:
        """Return what the model is and how well it holds, in a few lines of text."""
        return model_view.summary(self)

    def __repr__(self) -> str:
        """Return quantity, order, resistances and gap in one line."""
        return (
            f"SensingModel({self.quantity}, order {self.order}, {self.resistance_min_ohm:.4f} to "
            f"{self.resistance_max_ohm:.4f} ohm, gap {100 * self.hysteresis_gap:.3f} %)"
        )

    def _repr_html_(self) -> str:
        """Return a table for notebooks."""
        return model_view.html(self)


def load_model(path: str | PathLike[str]) -> SensingModel:
    """Read a model file written by ``SensingModel.save``.

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    The model.

    Raises
    ------
    CallerError
        In one line, if the file is missing, damaged, inconsistent or no model file.
    """
    from musclewire.sensing.model_file import read_fields

    return SensingModel(**read_fields(path))
