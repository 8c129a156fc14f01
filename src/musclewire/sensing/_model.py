"""The self-sensing model of the user interface: a fitted curve with its methods to save, show and read it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from musclewire.sensing import _model_view as model_view
from musclewire.sensing._fit_report import FittedCurve

if TYPE_CHECKING:
    from os import PathLike

    from matplotlib.axes import Axes


@dataclass(frozen=True, repr=False)
class SensingModel(FittedCurve):
    """The model of one wire: strain (or displacement, force) from its resistance, and the report of its fit.

    Get one from ``fit`` or ``load_model``. ``estimate(resistance_ohm)`` returns value, standard deviation and validity,
    ``strain(resistance_ohm)`` the strain alone, ``resistance_ohm(strain)`` the resistance that a strain requires
    (Eqs. 3 to 5); ``valid_resistance_ohm`` is the range in which they hold. A model never changes.

    The parameters are those of :class:`~musclewire.sensing._curve.ResistanceCurve`, the numbers that an estimator
    uses, and of :class:`~musclewire.sensing._fit_report.FittedCurve`, the report of the fit.

    Examples
    --------
    >>> import musclewire as mw
    >>> with mw.open_rig("simulated") as rig:
    ...     model = mw.fit(mw.characterize(rig))
    >>> model.quantity, model.order
    ('strain', 6)
    >>> round(model.resistance_ohm(0.02), 1)  # at 2 % strain
    16.4
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
        from musclewire.sensing._model_file import save_model

        save_model(self, path)

    def plot(self, axes: Axes | None = None, *, style: str = "screen") -> Axes:
        """Draw strain against resistance: the samples, if the model has them, both branches and their mean.

        Parameters
        ----------
        axes
            Axes to draw on; those of a new figure by default.
        style
            Size and fonts of the new figure, as in ``Recording.plot``; axes that are given keep their own.

        Returns
        -------
        The axes; ``model.plot().figure.savefig("model.pdf")`` writes their figure.

        Raises
        ------
        CallerError
            For an unknown style; the message suggests the nearest.
        """
        return model_view.plot_model(self, axes, style)

    def report(self) -> dict[str, Any]:
        """Return the numbers of ``musclewire fit --json``; percentages are of strain, or of the largest quantity."""
        return model_view.report(self)

    def summary(self) -> str:
        """Return the model and its errors in a few lines of text."""
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
        If the file is missing, damaged, inconsistent or no model file; the message is one line.
    """
    from musclewire.sensing._model_file import read_fields

    return SensingModel(**read_fields(path))
