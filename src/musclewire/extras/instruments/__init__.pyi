"""The list of names that other rooms may use."""

from ._faults import SimulatedFault as SimulatedFault
from ._faults import SimulatedFaults as SimulatedFaults
from ._pulse_width import PulseWidth as PulseWidth
from ._pulse_width import unsettled_error as unsettled_error
from ._pulsed_device import PulsedDevice as PulsedDevice
