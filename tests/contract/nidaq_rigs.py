"""The NI-DAQ rigs of the contract suite: NI's unmodified client, over gRPC, to our server with the simulated wire.

The server runs in this process, the guardian that owns the output in one of its own. Time passes by reading.
"""

from __future__ import annotations

import weakref
from collections.abc import Callable

from emulation.daq_bench import card_of
from emulation.daq_server import DaqServer

from musclewire.rigs.configuration import rig_configuration
from musclewire.rigs.nidaq.configuration import NiDaqConfiguration
from musclewire.rigs.nidaq.guardian import GuardianOrders
from musclewire.rigs.nidaq.output import GuardedOutput
from musclewire.rigs.nidaq.rig import NiDaqRig

__all__ = ["NIDAQ_COLD_OHM", "NIDAQ_RIGS", "RigAtSeam", "at_seam", "wiring_of"]


class RigAtSeam(NiDaqRig):
    """A rig that brings its server along."""

    def __init__(self, configuration: NiDaqConfiguration, server: DaqServer) -> None:
        self.server = server
        super().__init__(configuration.model_copy(update={"grpc": server.address}))
        # A test that does not close its rig: output first, because switching off needs the server.
        weakref.finalize(self, closed, self._output, server)

    def _orders(self) -> GuardianOrders:
        orders = super()._orders()
        if self.server.card.paced:
            return orders
        # Where time passes by reading, the guardian's seconds are those of a busy test machine and not of the wire.
        return orders._replace(sense_after_s=5.0, trip_after_s=10.0)

    def _switch_off(self) -> None:
        super()._switch_off()
        self.server.close()


def closed(output: GuardedOutput, server: DaqServer) -> None:
    output.close()
    server.close()


def wiring_of(name: str) -> NiDaqConfiguration:
    configuration = rig_configuration(name)[0]
    assert isinstance(configuration, NiDaqConfiguration)
    return configuration


def at_seam(name: str, *, paced: bool = False, **changed: object) -> RigAtSeam:
    """Return a rig by name with some keys changed, its server in this process."""
    wiring = NiDaqConfiguration.model_validate({**wiring_of(name).model_dump(), **changed})
    server = DaqServer(card_of(wiring, paced=paced))
    try:
        return RigAtSeam(wiring, server)
    except BaseException:
        server.close()
        raise


NIDAQ_RIGS: dict[str, Callable[[], RigAtSeam]] = {
    "nidaq, PCI-6229": lambda: at_seam("ni-pci-6229"),
    "nidaq, USB-6001": lambda: at_seam("ni-usb-6001"),
}
# Resistance between the terminals of the paper's wire, as on the simulated rig.
NIDAQ_COLD_OHM = dict.fromkeys(NIDAQ_RIGS, (12.0, 20.0))
