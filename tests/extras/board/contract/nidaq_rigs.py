"""The NI-DAQ rigs of the contract suite: NI's unmodified client, over gRPC, to our server with the simulated wire.

The server runs in this process, the guardian that owns the output in one of its own. Time passes by reading.
"""

from __future__ import annotations

import weakref
from collections.abc import Callable

from emulation.daq_bench import card_of
from emulation.daq_server import DaqServer
from tests.contract.rig_subject import PAPERS_WIRE_OHM, RigSubject, without_a_test

from musclewire.extras.board import NiDaqConfiguration
from musclewire.extras.board._nidaq.device import NiDaqDevice, SilenceTimes
from musclewire.extras.board._nidaq.output import GuardedOutput
from musclewire.rigs import Answer, DeviceFacts, GuardedRig, Metadata, rig_configuration
from musclewire.signals import Command

__all__ = ["COLD_K", "NIDAQ_RIGS", "SUBJECTS", "DeviceAtSeam", "at_seam", "wiring_of"]

# The wire of a server that has just been started [K].
COLD_K = 295.15


class DeviceAtSeam:
    """A device that brings its server along; everything else is that of the card."""

    def __init__(self, configuration: NiDaqConfiguration, server: DaqServer) -> None:
        self.server = server
        # If time passes by reading, the guardian's seconds are those of a busy test machine and not of the wire.
        silence = None if server.card.paced else SilenceTimes(5.0, 10.0)
        self.at_card = NiDaqDevice(configuration.model_copy(update={"grpc": server.address}), silence)
        # A test that does not close its rig: output first, because switching off needs the server.
        weakref.finalize(self, closed, self.at_card._output, server)

    @property
    def facts(self) -> DeviceFacts:
        return self.at_card.facts

    @property
    def drive_voltage_v(self) -> float:
        return self.at_card.drive_voltage_v

    def metadata(self) -> Metadata:
        return self.at_card.metadata()

    def exchange(self, command: Command) -> Answer:
        return self.at_card.exchange(command)

    def sense(self) -> bool:
        return self.at_card.sense()

    def off(self) -> bool:
        confirmed = self.at_card.off()
        self.server.close()
        return confirmed


def closed(output: GuardedOutput, server: DaqServer) -> None:
    output.close()
    server.close()


def wiring_of(name: str) -> NiDaqConfiguration:
    configuration = rig_configuration(name)[0]
    assert isinstance(configuration, NiDaqConfiguration)
    return configuration


def at_seam(name: str, *, paced: bool = False, **changed: object) -> GuardedRig:
    """Return a rig by name with some keys changed, its server in this process."""
    wiring = NiDaqConfiguration.model_validate({**wiring_of(name).model_dump(), "lockstep": not paced, **changed})
    server = DaqServer(card_of(wiring, paced=paced))
    try:
        return GuardedRig(DeviceAtSeam(wiring, server), wire_temperature_k=COLD_K)
    except BaseException:
        server.close()
        raise


NIDAQ_RIGS: dict[str, Callable[[], GuardedRig]] = {
    "nidaq, PCI-6229": lambda: at_seam("ni-pci-6229"),
    "nidaq, USB-6001": lambda: at_seam("ni-usb-6001"),
}
SUBJECTS = tuple(
    RigSubject(name, without_a_test(make), PAPERS_WIRE_OHM, emulated=True, in_full="PCI" in name, by_the_clock=False)
    for name, make in NIDAQ_RIGS.items()
)
