"""The list of names that other rooms may use."""

from ._defects import coarse_readings as coarse_readings
from ._defects import measured_rows as measured_rows
from ._defects import recording_defects as recording_defects
from ._error_causes import ErrorGroup as ErrorGroup
from ._error_causes import JudgedEstimate as JudgedEstimate
from ._findings import GRAVE as GRAVE
from ._findings import judgement_of as judgement_of
from ._findings import remedies as remedies
from ._first_heating import KnownB as KnownB
from ._first_heating import height_of_b as height_of_b
from ._known_strain import known_strain_in as known_strain_in
from ._loop import SETTLE_S as SETTLE_S
from ._loop import Cause as Cause
from ._loop import JudgedLoop as JudgedLoop
from ._missed_target import MissWatch as MissWatch
from ._odd_resistance import odd_resistance as odd_resistance
from ._readings import JudgedRecording as JudgedRecording
from ._readings import resistance_reading as resistance_reading
from ._run_correction import KEPT as KEPT
from ._run_correction import TODAY as TODAY
from ._run_correction import ZEROS as ZEROS
from ._run_correction import RunCorrection as RunCorrection
from ._unusable_readings import JudgedReadings as JudgedReadings
from ._unusable_readings import ReadingsOfBlocks as ReadingsOfBlocks
from ._unusable_readings import judge_readings as judge_readings
