"""The options of a fit from resistance alone: what ``musclewire fit`` takes of this part."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from musclewire.app import SEED, SET, WIRE, in_si, mapping, option, quantity
from musclewire.errors import CallerError, nearest_hint

if TYPE_CHECKING:
    from musclewire.extras.calibration._resistance_alone.fitting import ResistanceFit
    from musclewire.extras.calibration._resistance_alone.observation import Marks
    from musclewire.signals import Recording

MARK = option(
    "--mark",
    help="A position read off a ruler: cold, hot (both), or stop, an end stop counted from cold. Repeatable.",
    metavar="NAME=POSITION",
)
MARK_ERROR = quantity("--mark-error", "m", "Standard deviation of one mark, as '0.5 mm'.", 1e-9, 1.0)
LENGTH_ERROR = quantity("--length-error", "m", "Standard deviation of the leg's stated length, as '0.5 mm'.", 1e-9, 1.0)

MARKS = {"cold": "cold_m", "hot": "hot_m", "stop": "end_stop_m"}


@dataclass(frozen=True)
class ResistanceOptions:
    """What a fit rests on if only the resistance was measured; without a wire's name there is no such fit."""

    wire: Annotated[str | None, WIRE] = None
    set: Annotated[list[str] | None, SET] = None
    mark: Annotated[list[str] | None, MARK] = None
    mark_error: Annotated[str, MARK_ERROR] = "0.5 mm"
    length_error: Annotated[str, LENGTH_ERROR] = "0.5 mm"
    seed: Annotated[int, SEED] = 1

    def marks(self) -> Marks:
        """Return the marks. Raises CallerError for an unknown mark, or one that is no length."""
        from musclewire.extras.calibration._resistance_alone.observation import Marks
        from musclewire.signals import parse_quantity

        positions = {}
        for name, text in mapping(self.mark, "--mark").items():
            if name not in MARKS:
                raise CallerError(f"--mark {name}: there is no such mark{nearest_hint(name, MARKS)}")
            try:
                positions[MARKS[name]] = parse_quantity(text, "m")
            except CallerError as error:
                raise CallerError(f"--mark {name}: {error}") from None
        return Marks(
            **positions,
            reading_std_m=in_si("--mark-error", self.mark_error),
            leg_length_std_m=in_si("--length-error", self.length_error),
        )

    def asked_for(self, *, relative_resistance: bool) -> bool:
        """Return whether a wire is named. Raises CallerError for options that need a name, or allow none."""
        if self.wire is None and (self.mark or self.set):
            raise CallerError("--mark and --set belong to a fit from resistance alone: name the wire with --wire")
        if self.wire is not None and relative_resistance:
            raise CallerError("--relative-resistance belongs to a fit with an instrument: a wire's name has its ohms")
        return self.wire is not None

    def fit(self, recording: Recording, order: int | str, quantity: str) -> ResistanceFit:
        """Return the fit to the resistance of a recording."""
        from musclewire.extras.calibration._resistance_alone.fitting import fit_resistance

        return fit_resistance(
            recording,
            self.wire or "",
            bench=mapping(self.set, "--set"),
            marks=self.marks(),
            order=order,
            quantity=quantity,
            seed=self.seed,
        )
