"""Which estimators and controllers have a form in C, and what a controller there knows of a model's wire."""

from __future__ import annotations

from pathlib import Path

from musclewire.controllers import FeedforwardSettings, FuzzyPidSettings, load_rule_base
from musclewire.errors import CallerError, argument, nearest_hint
from musclewire.sensing import PAPER_ESTIMATOR, SensingModel

FILTER = "filter"
FUZZY_PID, INVERSE_MODEL = "fuzzy-pid", "inverse-model"
# The first of each is the default.
ESTIMATORS_IN_C, CONTROLLERS_IN_C = (FILTER, PAPER_ESTIMATOR), (INVERSE_MODEL, FUZZY_PID)
# The settings of a controller say which of both it is: feedforward's are those of the inverse of the wire's model.
ControllerSettings = FuzzyPidSettings | FeedforwardSettings


def settings_in_c(
    model: SensingModel,
    controller: str = INVERSE_MODEL,
    fuzzy: FuzzyPidSettings | None = None,
    *,
    sample_period_s: float = 0.0,
    file: Path | None = None,
) -> ControllerSettings:
    """Return the settings of a controller in C: the gains that a model keeps, or those of the paper's fuzzy PID.

    ``fuzzy`` changes the latter; ``file`` is the model's, for messages. Raises CallerError for a controller without a
    form in C, for settings of the other one, and for a model without the gains that are needed.
    """
    from musclewire.identify import gains_of, settings_for

    if controller not in CONTROLLERS_IN_C:
        raise CallerError(f"controller '{controller}' has no form in C{nearest_hint(controller, CONTROLLERS_IN_C)}")
    if controller == FUZZY_PID:
        return settings_for(model, fuzzy)
    if fuzzy is not None:
        raise CallerError(
            f"{INVERSE_MODEL} takes the model's gains: leave out settings and rules of the fuzzy PID, or name it by "
            + argument("controller", "fuzzy-pid")
        )
    gains = gains_of(model, sample_period_s)
    if gains is None or not isinstance(gains.settings, FeedforwardSettings):
        why = f" ({model.no_gains})" if model.no_gains else ""
        place = "MODEL" if file is None else str(file)
        raise CallerError(
            f"{INVERSE_MODEL} needs the gains of its wire, and {'this model' if file is None else file} has none{why}: "
            f"find them in the wire's slow loop by 'musclewire tune {place} LOOP -o {place}', or take the paper's "
            + argument("estimator", "polynomial")
            + " with "
            + argument("controller", "fuzzy-pid")
        )
    return gains.settings


def rules_text(settings: ControllerSettings) -> str:
    """Return the rule base of a controller as the header names it."""
    if isinstance(settings, FuzzyPidSettings):
        return str(load_rule_base(settings.rule_base))
    return "none, the controller is the inverse of the wire's model"
