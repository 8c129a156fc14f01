"""The limits of an exported controller, from the rig that it is to run on."""

from __future__ import annotations

from pathlib import Path

from musclewire.controllers import ProtectionLimits
from musclewire.errors import CallerError
from musclewire.extras.board._serial.configuration import SerialConfiguration
from musclewire.rigs import Metadata, RigConfiguration, open_rig, rig_configuration


def limits_of_rig(rig: str | Path) -> tuple[ProtectionLimits, Metadata]:
    """Return limits and facts of a rig without driving anything: a simulated one, or a board's rig file.

    Raises CallerError for a rig of another kind.
    """
    configuration, where = rig_configuration(rig)
    if isinstance(configuration, RigConfiguration):
        with open_rig(configuration) as opened:
            return opened.protection_limits, opened.metadata()
    if isinstance(configuration, SerialConfiguration):
        limits = configuration.protection_limits(
            wire_range_v=configuration.wire_range,
            shunt_range_v=configuration.shunt_range,
            readings_noisy=configuration.readings_noisy,
        )
        return limits, configuration.facts()
    raise CallerError(
        f"{where} is no board: an exported controller's limits come from the channels of the board it runs on; write "
        'a rig file with kind = "serial" for it'
    )
