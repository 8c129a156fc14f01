"""The list of names that other rooms may use."""

from ._hdf5_trial import check_by_trial as check_by_trial
