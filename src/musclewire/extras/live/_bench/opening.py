"""Opening of a session's rig."""

from __future__ import annotations

from musclewire.controllers import CONTROLLERS, DriveLimits, FuzzyPidController, FuzzyPidSettings
from musclewire.errors import CallerError, MusclewireError
from musclewire.extras.live._bench.descriptions import described_protection, described_rig, wiring
from musclewire.extras.live._bench.session import BenchSession, BenchStop
from musclewire.rigs import RigConfiguration, SamplePacer, open_rig, rig_configuration
from musclewire.sensing import ESTIMATORS, compile_estimators


def show_wiring(session: BenchSession) -> None:
    """Show what to wire before anything is switched on; a rig file that cannot be read is an error only then."""
    try:
        configuration, _where = rig_configuration(session.name, may_import=True)
    except MusclewireError as problem:
        session.shown.say("error", str(problem))
    else:
        session.simulated = isinstance(configuration, RigConfiguration)
        session.shown.change(wiring=wiring(simulated=session.simulated), simulated=session.simulated)


def show_off(session: BenchSession) -> None:
    """Show that the bench waits for an order to switch on; a stop that was read before stays what it is."""
    with session.deciding:
        if not session.stopped.by:
            session.shown.change(phase="off")


def switch_on(session: BenchSession, stops_before: int) -> None:
    """Open the session's rig and sense, unless there was a stop after the order was read; the rig stays off then.

    Raises MusclewireError as ``open_rig`` does, and CallerError after a stop.
    """
    if session.rig is not None:
        session.rig.close()
    with session.deciding:
        refuse_after_stop(session, stops_before)
        session.rig, session.stopped = None, BenchStop()
        session.shown.change(phase="starting", why="", clock_speed=1.0)
    try:
        configuration, _where = rig_configuration(session.name, may_import=True)
        session.simulated = isinstance(configuration, RigConfiguration)
        # What a closed loop will call compiles here, with 0 V out: to be made is enough, by whatever limits.
        compile_estimators()
        FuzzyPidController(FuzzyPidSettings(), DriveLimits(0.1, 1.0))
        rig = open_rig(session.name, seed=session.seed, real_time=session.simulated)
    except MusclewireError as problem:
        with session.deciding:
            if session.stops == stops_before:  # otherwise the stop stays the reason
                session.shown.change(phase="failed", why=str(problem))
        raise
    # A rig without a clock is paced here; hardware and the simulated rig pace themselves.
    session.pacer = None if rig.paced else SamplePacer(rig.sample_period_s)
    # Before the last look at the stops: one that comes after it finds this rig and switches it off. What another rig's
    # protection does is shown again.
    session.rig, session.protection_seen = rig, (-1, -1)
    described = {"rig": described_rig(rig, session.name, simulated=session.simulated)}
    with session.deciding:
        if session.stops != stops_before:
            rig.close()  # that stop may have found no rig to switch off
        refuse_after_stop(session, stops_before)
        session.shown.done(
            "switched_on",
            phase="ready",
            protection=described_protection(rig),
            gains=FuzzyPidSettings().model_dump(mode="json"),
            controllers=list(CONTROLLERS.names()),
            estimators=list(ESTIMATORS.names()),
            **described,
        )


def refuse_after_stop(session: BenchSession, stops_before: int) -> None:
    """Raise CallerError if there was a stop since there had been so many."""
    if session.stops != stops_before:
        raise CallerError(
            f"rig '{session.name}' stays off: a stop came after this order to switch on; order it again when it is safe"
        )
