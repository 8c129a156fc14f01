"""Recordings in the files of LabVIEW, MATLAB and Excel, and in HDF5 and Parquet of others."""
