"""Errors that a user can remedy. Each kind has the exit status that all tools of VDBLIC share."""

import importlib

PACKAGES = {
    "vtkmodules": "python3-vtk9",
    "netCDF4": "python3-netcdf4",
    "pyopenvdb": "python3-openvdb",
    "numpy": "python3-numpy",
}


class UserError(Exception):
    """An error whose message names the file, the value and the remedy."""

    status = 5


class ParameterError(UserError):
    status = 2


class InputError(UserError):
    status = 3


class OutputError(UserError):
    status = 4


def needed(module):
    """Import a module that not every user needs. Raises ParameterError with the package that holds it."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        package = PACKAGES[module.partition(".")[0]]
        raise ParameterError(
            f"the Python module {module} cannot be imported ({error}); Debian's package {package} has "
            "it, for /usr/bin/python3"
        ) from None
