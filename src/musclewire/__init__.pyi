"""The names that are promised to users: of the core with their types, and what parts outside it add."""

import typing

from .arrays import FloatArray as FloatArray
from .controllers import CONTROLLERS as CONTROLLERS
from .controllers import ControllerSetup as ControllerSetup
from .controllers import DriveLimits as DriveLimits
from .controllers import FuzzyPidSettings as FuzzyPidSettings
from .controllers import PidSettings as PidSettings
from .controllers import SteeredReference as SteeredReference
from .controllers import infer_ratios as infer_ratios
from .controllers import load_gains as load_gains
from .controllers import load_rule_base as load_rule_base
from .controllers import rule_base_names as rule_base_names
from .controllers import sampled_reference as sampled_reference
from .controllers import staircase as staircase
from .errors import CallerError as CallerError
from .errors import MusclewireError as MusclewireError
from .errors import NumericsError as NumericsError
from .errors import RecordingError as RecordingError
from .errors import RigError as RigError
from .experiment import characterize as characterize
from .experiment import control as control
from .experiment import control_compiled as control_compiled
from .experiment import control_many as control_many
from .experiment import home as home
from .experiment import pretension_sweep as pretension_sweep
from .experiment import speed_limits as speed_limits
from .experiment import train as train
from .experiment import zero_tendon as zero_tendon
from .files import ImportMapping as ImportMapping
from .files import SourceColumn as SourceColumn
from .files import SourceTable as SourceTable
from .files import TableInMemory as TableInMemory
from .files import read_recording as read_recording
from .files import save_mapping as save_mapping
from .identify import estimate as estimate
from .identify import fit as fit
from .identify import import_recording as import_recording
from .identify import loop_gaps as loop_gaps
from .identify import simulated_isobar as simulated_isobar
from .identify import tune as tune
from .manifest import Command as Command
from .manifest import CommandGroup as CommandGroup
from .manifest import Manifest as Manifest
from .parameters import folder_of_materials as folder_of_materials
from .parameters import load_alloy as load_alloy
from .parameters import load_bench as load_bench
from .parameters import load_material as load_material
from .parameters import load_wire as load_wire
from .parameters import published_ranges as published_ranges
from .physics import air_thermal_conductivity_w_per_m_k as air_thermal_conductivity_w_per_m_k
from .physics import nusselt_morgan as nusselt_morgan
from .physics import rayleigh_of_wire as rayleigh_of_wire
from .rigs import DEVICES as DEVICES
from .rigs import LOAD_PARTS as LOAD_PARTS
from .rigs import SWITCHED_OFF as SWITCHED_OFF
from .rigs import Device as Device
from .rigs import DeviceConfiguration as DeviceConfiguration
from .rigs import DeviceFacts as DeviceFacts
from .rigs import DeviceFault as DeviceFault
from .rigs import DeviceKind as DeviceKind
from .rigs import GuardedRig as GuardedRig
from .rigs import Length as Length
from .rigs import LoadPart as LoadPart
from .rigs import MountedWire as MountedWire
from .rigs import RigConfiguration as RigConfiguration
from .rigs import Stiffness as Stiffness
from .rigs import adjustable_clock_of as adjustable_clock_of
from .rigs import open_rig as open_rig
from .rigs import required_true_state as required_true_state
from .sensing import ESTIMATORS as ESTIMATORS
from .sensing import EstimatorSetup as EstimatorSetup
from .sensing import PolynomialEstimator as PolynomialEstimator
from .sensing import SensingModel as SensingModel
from .sensing import load_model as load_model
from .signals import PLOTS as PLOTS
from .signals import CompiledTick as CompiledTick
from .signals import ControlStep as ControlStep
from .signals import Drive as Drive
from .signals import EstimatorStep as EstimatorStep
from .signals import FileWriter as FileWriter
from .signals import QuantityEstimate as QuantityEstimate
from .signals import RawSample as RawSample
from .signals import Reason as Reason
from .signals import Recording as Recording
from .signals import RecordingWriter as RecordingWriter
from .signals import WireSample as WireSample
from .signals import drive_voltage_of as drive_voltage_of
from .signals import measured_in as measured_in
from .signals import recover_recording as recover_recording
from .wire import ElasticObject as ElasticObject
from .wire import WireBatch as WireBatch
from .wire import constants_of as constants_of
from .wire import drive_many as drive_many
from .wire import fixed_steps as fixed_steps

# Of parts outside the core, by their manifests; with their types from the part itself, as musclewire.extras.studies.
Marks: typing.Any
calibrate: typing.Any
channel_axes: typing.Any
fit_resistance: typing.Any
next_experiments: typing.Any
save_wire: typing.Any
settings_of_effort: typing.Any
write_report: typing.Any
GripperKnowledge: typing.Any
KnownGrip: typing.Any
close_fingers: typing.Any
fit_free_closing: typing.Any
fit_grip_curve: typing.Any
grip: typing.Any
gripper_of: typing.Any
with_object: typing.Any
WireVectorEnv: typing.Any
branch_system: typing.Any
export_fmu: typing.Any
linear_system: typing.Any
linearise: typing.Any
loop_margins: typing.Any
operating_point: typing.Any
wire_system: typing.Any
LiveClient: typing.Any
reproduce: typing.Any
Conditions: typing.Any
InstrumentSettings: typing.Any
KindOptions: typing.Any
Quantity: typing.Any
RUN_KINDS: typing.Any
RunKind: typing.Any
RunningInstruments: typing.Any
SegmentedDevice: typing.Any
SegmentedSpool: typing.Any
Selection: typing.Any
WireStructure: typing.Any
each: typing.Any
on_grid: typing.Any
read_study: typing.Any
read_study_data: typing.Any
robustness: typing.Any
runs_of: typing.Any
steady: typing.Any
sweep: typing.Any
task_table: typing.Any
tuning_seeds: typing.Any
write_study: typing.Any

__version__: str
