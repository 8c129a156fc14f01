"""Tables in files of laboratory programs: LabVIEW, MATLAB, Excel, and HDF5 and Parquet that others wrote."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
