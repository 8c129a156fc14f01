"""Opening of a session's rig."""

from __future__ import annotations

from musclewire.controllers import CONTROLLERS, FuzzyPidSettings
from musclewire.errors import MusclewireError
from musclewire.extras.live.bench.descriptions import described_protection, described_rig, wiring
from musclewire.extras.live.bench.session import Session, Stopped
from musclewire.rigs.configuration import open_rig, rig_configuration
from musclewire.rigs.pacing import Pacer
from musclewire.rigs.simulated_configuration import RigConfiguration
from musclewire.sensing.estimator import ESTIMATORS

__all__ = ["show_wiring", "switch_on"]


def show_wiring(session: Session) -> None:
    """Show what to wire before anything is switched on; a rig file that cannot be read is an error only then."""
    try:
        configuration, _where = rig_configuration(session.name, may_import=True)
    except MusclewireError as problem:
        session.shown.say("error", str(problem))
    else:
        session.simulated = isinstance(configuration, RigConfiguration)
        session.shown.change(wiring=wiring(simulated=session.simulated))


def switch_on(session: Session) -> None:
    """Open the session's rig and sense. Raises MusclewireError as ``open_rig`` does; the rig stays off then."""
    if session.rig is not None:
        session.rig.close()
    session.rig, session.stopped = None, Stopped()
    session.shown.change(phase="starting", why="", clock_speed=1.0)
    try:
        configuration, _where = rig_configuration(session.name, may_import=True)
        session.simulated = isinstance(configuration, RigConfiguration)
        rig = open_rig(session.name, seed=session.seed, real_time=session.simulated)
    except MusclewireError as problem:
        session.shown.change(phase="failed", why=str(problem))
        raise
    # A rig without a clock is paced here; hardware and the simulated rig pace themselves.
    session.pacer = None if rig.paced else Pacer(rig.sample_period_s)
    session.rig, session.protection_seen = rig, (-1, -1)  # another rig: what its protection does is shown again
    if session.stopped.by:  # meanwhile, by another thread that found no rig to switch off
        rig.close()
        return
    session.shown.done(
        "switched_on",
        phase="ready",
        rig=described_rig(rig, session.name, simulated=session.simulated),
        protection=described_protection(rig),
        gains=FuzzyPidSettings().model_dump(mode="json"),
        controllers=list(CONTROLLERS.names()),
        estimators=list(ESTIMATORS.names()),
    )
