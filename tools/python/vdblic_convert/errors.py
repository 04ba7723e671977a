"""Errors that a user can remedy, from VDBLIC's library, with the exit status that all tools share."""

import importlib

from vdblic._core import InputError, OutputError, ParameterError

STATUS = {ParameterError: 2, InputError: 3, OutputError: 4}
PACKAGES = {"vtkmodules": ("python3-vtk9", "vtk"), "netCDF4": ("python3-netcdf4", "netCDF4")}  # Debian's and pip's


def needed(module):
    """Import a module that not every user needs. Raises ParameterError with the package that holds it."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        name = module.partition(".")[0]
        debian, pip = PACKAGES.get(name, (f"python3-{name}", name))
        raise ParameterError(
            f"the Python module {module} cannot be imported ({error}); Debian's package {debian} has "
            f"it, for /usr/bin/python3, pip's package {pip} for others"
        ) from None
