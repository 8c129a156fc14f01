"""The wire of a candidate: a vector that a search tries may describe no wire, which is not the caller's fault."""

from __future__ import annotations

from collections.abc import Mapping

from musclewire.errors import CallerError, NumericsError
from musclewire.identify._physical.candidates import WireValues
from musclewire.wire import ConnectorLoad, WireConstants, constants_of


def candidate_constants(
    values: WireValues, spool: Mapping[str, float], bench: Mapping[str, float], load: ConnectorLoad | None = None
) -> WireConstants:
    """Return the constants of a candidate's alloy on a spool and a bench, which an observation may know better.

    A load replaces the bench's spring.

    Raises NumericsError if its numbers cannot be a wire's, with the reason: spreads with which the phases have no
    order, for instance, which a prior's limits may allow for each number alone. A search passes such candidates over.
    """
    try:
        return constants_of(values.alloy, spool, bench, load=load, distribution=values.grains)
    except CallerError as error:
        raise NumericsError(f"a candidate cannot be a wire: {error}") from error
