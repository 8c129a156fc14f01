"""The list of names that other rooms may use."""

from ._data_set import read_study_data as read_study_data
from ._robustness.plant import open_plant as open_plant
from ._robustness.population import drawn_wire as drawn_wire
from ._robustness.population import tuning_seeds as tuning_seeds
from ._run_kind import RUN_KINDS as RUN_KINDS
from ._segmented.conditions import Conditions as Conditions
from ._segmented.configuration import AgeingTable as AgeingTable
from ._segmented.configuration import BarrierTable as BarrierTable
from ._segmented.configuration import ConditionsTable as ConditionsTable
from ._segmented.configuration import GrainsTable as GrainsTable
from ._segmented.configuration import InstrumentsTable as InstrumentsTable
from ._segmented.configuration import SegmentedConfiguration as SegmentedConfiguration
from ._segmented.structure import NormalMixture as NormalMixture
from ._segmented.structure import WireStructure as WireStructure
from ._segmented.structure import fin_length_m as fin_length_m
from ._segmented.structure import mixture_distribution as mixture_distribution
from ._segmented.wire import SegmentedWire as SegmentedWire
from ._study import StudyResult as StudyResult
from ._study import Workers as Workers
from ._study import read_study as read_study
from ._study import sweep as sweep
from ._study_file import Sampling as Sampling
from ._study_file import StudyFile as StudyFile
from ._study_file import read_study_file as read_study_file
from ._study_page import write_study as write_study
from ._varied_parameters import ParameterTable as ParameterTable
