"""The simulated wire on the terminals of the emulated card, wired as a nidaq rig file says."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from emulation.daq_card import Card, Model
from musclewire.errors import CallerError
from musclewire.extras.board import COLUMNS, NiDaqConfiguration
from musclewire.rigs import RigConfiguration, SimulatedDevice, open_rig, rig_configuration
from musclewire.signals import Drive, RawSample

__all__ = ["PCI_6229", "USB_6001", "WiredRig", "card_of"]

# From NI's manuals: terminals, configurations, bits, and that USB devices have no hardware-timed single point. Noise
# of one reading is assumed: that of the simulated bench for the first, half a step for the second.
PCI_6229 = Model(
    "PCI-6229",
    tuple(f"ai{number}" for number in range(32)),
    tuple(f"ao{number}" for number in range(4)),
    ("differential", "RSE", "NRSE"),
    single_point=True,
    bits=16,
    noise_v=0.244e-3,
)
USB_6001 = Model(
    "USB-6001",
    tuple(f"ai{number}" for number in range(8)),
    ("ao0", "ao1"),
    ("differential", "RSE"),
    single_point=False,
    bits=14,
    noise_v=0.7e-3,
)


class WiredRig:
    """A simulated rig whose voltages are at the terminals that a nidaq rig file names.

    ``errors`` are gain and offset [V] of a terminal in addition to those of the file, by terminal: the errors that
    ``doctor`` is to find.
    """

    def __init__(
        self, device: SimulatedDevice, wiring: NiDaqConfiguration, errors: dict[str, tuple[float, float]] | None = None
    ) -> None:
        """Wire a device; it is driven without a protection of its own, as the circuit on a bench is."""
        self.device = device
        self.largest_drive_v = 0.0
        self._wiring = wiring
        self._inputs = {COLUMNS[name]: item for name, item in wiring.inputs.wired().items()}
        self._errors = errors or {}

    def advance(self, outputs_v: dict[str, float]) -> dict[str, float]:
        """Return the voltages at the input terminals after a tick with these at the outputs."""
        drive_v = self._wiring.output.rule.quantity(outputs_v[self._wiring.output.channel])
        self.largest_drive_v = max(self.largest_drive_v, drive_v)
        # A rig's exchange would protect the wire; on a card only the program that drives the card does.
        sample = self.device.exchange(Drive(max(drive_v, 0.0)))
        assert isinstance(sample, RawSample)  # nothing paces it, and the wire on a card has no faults of its own
        read_v = {}
        for column, item in self._inputs.items():
            value = getattr(sample, column)
            gain, offset_v = self._errors.get(item.channel, (1.0, 0.0))
            read_v[item.channel] = gain * item.rule.voltage_v(value if value is not None else 0.0) + offset_v
        return read_v


def card_of(
    wiring: str | Path | NiDaqConfiguration,
    wire: str | Path | RigConfiguration = "simulated",
    *,
    paced: bool,
    errors: dict[str, tuple[float, float]] | None = None,
) -> Card:
    """Return the emulated card of a nidaq rig, with a simulated rig on its terminals.

    Raises CallerError for a wiring that is no nidaq rig, and a wire that is not simulated.
    """
    found = wiring if isinstance(wiring, NiDaqConfiguration) else rig_configuration(wiring)[0]
    if not isinstance(found, NiDaqConfiguration):
        raise CallerError(f"{wiring} is no rig of kind nidaq: give the one that describes the wiring of the card")
    model = PCI_6229 if found.output_timing == "hardware" else USB_6001
    tick_s = 1.0 / found.reading_rate
    # Each reading of the card is one of the converter: the rig averages what it reads.
    rig = open_rig(
        wire,
        sample_period_s=tick_s,
        acquisition_readings=1,
        acquisition_bits=model.bits,
        acquisition_noise_v=model.noise_v,
        amplifier_resolution_v=2.0 * model.range_v / 2**model.bits,
        shunt_resistance_ohm=found.shunt,
    )
    device = rig.device
    if not isinstance(device, SimulatedDevice):
        rig.close()
        raise CallerError(f"{wire} is not simulated: it cannot be connected to an emulated card")
    if paced:
        ready_to_run_by_the_clock()
    return Card(found.device, model, WiredRig(device, found, errors), tick_s, paced=paced)


@cache
def ready_to_run_by_the_clock() -> None:
    """Load the simulated wire's kernels: loading takes longer than a host may be silent, and holds up every thread."""
    with open_rig("simulated") as rig:
        rig.exchange(rig.sense_voltage_v)
