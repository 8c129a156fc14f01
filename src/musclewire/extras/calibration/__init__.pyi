"""The list of names that other rooms may use."""

from ._calibrate_command import read_one as read_one
from ._physical.calibrate import calibrate as calibrate
from ._physical.calibration import Calibration as Calibration
from ._physical.candidates import CandidateParameters as CandidateParameters
from ._physical.candidates import WireValues as WireValues
from ._physical.search import SearchSettings as SearchSettings
from ._resistance_alone.spreads import priors_around as priors_around
