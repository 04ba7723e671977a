"""NetCDF files: which convention a file follows."""

from ..errors import InputError
from .cf import CfFile
from .netcdf_file import netCDF4
from .ocean import OceanFile, is_level
from .whole_files import check_whole
from .wrf import WrfFile


def open_source(path):
    check_whole(path)
    try:
        data = netCDF4.Dataset(path)
    except (OSError, RuntimeError) as error:
        raise InputError(f"{path}: cannot be read as NetCDF: {getattr(error, 'strerror', None) or error}") from None
    if {"PH", "PHB"} <= set(data.variables):
        return WrfFile(path, data)
    if any(is_level(variable) for variable in data.variables.values()):
        return OceanFile(path, data)
    return CfFile(path, data)
