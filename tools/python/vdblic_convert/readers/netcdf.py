"""NetCDF files: which convention a file follows."""

from ..errors import InputError
from .cf import CfFile
from .netcdf_file import netCDF4, text
from .ocean import OceanFile
from .wrf import WrfFile


def open_source(path):
    try:
        data = netCDF4.Dataset(path)
    except (OSError, RuntimeError) as error:
        raise InputError(f"{path}: cannot be read as NetCDF: {getattr(error, 'strerror', None) or error}") from None
    if {"PH", "PHB"} <= set(data.variables):
        return WrfFile(path, data)
    if any(text(v, "standard_name").startswith("ocean_s") and text(v, "formula_terms") for v in data.variables.values()):
        return OceanFile(path, data)
    return CfFile(path, data)
