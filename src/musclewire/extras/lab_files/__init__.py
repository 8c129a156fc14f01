"""Tables in files of laboratory programs: LabVIEW, MATLAB, Excel, and HDF5 and Parquet that others wrote."""
