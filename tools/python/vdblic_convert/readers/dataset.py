"""Gridded files of every form as xarray's variables, and which convention a file follows."""

import argparse
import logging
import re

from vdblic._core import Parsing

from ..errors import InputError, needed
from .gridded import Data
from .whole_files import check_whole


IRREGULAR = {  # GRIB's grids without rows and columns, and the commands that regrid them
    "reduced_gg": ("a reduced Gaussian grid, whose rows differ in length", "setgridtype,regular"),
    "reduced_ll": ("a reduced grid, whose rows differ in length", "setgridtype,regular"),
    "sh": ("spherical harmonics", "sp2gp IN OUT, of vorticity and divergence cdo dv2uv"),
    "healpix": ("a HEALPix grid", "remapbil,r360x180"),
    "unstructured_grid": ("an unstructured grid", "remapbil,r360x180"),
}


def open_source(path, options, grids=()):
    variables, attributes = _variables(path)
    for grid in grids:
        variables = _variables(grid)[0] | variables
    return _source(Data(path, variables, attributes, options.attribute), options)


def grids_of(data):
    """The velocity of a Dataset of xarray of one moment, in a list of keyword arguments of vdblic.Grid."""
    from ..resample import flow_at
    from ..velocity import chosen

    encode = needed("xarray").conventions.encode_cf_variable
    variables = {str(name): encode(data[name].variable, name=name) for name in data.variables}
    source = _source(Data("the Dataset", variables, data.attrs, {}), argparse.Namespace(dt=1.0, globe=None))
    names, _ = chosen(source.arrays(0), (), source.velocity(0), source.path)

    def usual(flow):
        target = flow.usual_target()
        target.check()
        return target

    velocity, _, active, _, target = flow_at(source, 0, names, (), usual, source.path)
    place = {"transform": target.matrix, "origin": target.first}
    return [{"values": velocity, "active": active, "name": "velocity"} | place]


def _source(data, options):
    from . import cf, mesh, ocean, wrf

    if {"PH", "PHB"} <= set(data.variables):
        return wrf.WrfFile(data, options)
    if mesh.is_mesh(data):
        return mesh.MeshFile(data, options)
    if ocean.is_ocean(data):
        return ocean.OceanFile(data, options)
    return cf.CfFile(data, options)


def is_grid(path):
    """Whether a file holds a grid, as of meshes and ROMS, and no flow."""
    from . import cf, mesh, ocean
    from .gridded import COMPONENTS

    data = Data(path, *_variables(path), {})
    flows = [names for usual in (cf.USUAL, mesh.USUAL) for names in usual[:2]]
    has_flow = any(
        any(name in names for names in flows)
        or any(re.fullmatch(c, data.text(name, "standard_name")) for c in COMPONENTS)
        for name in data.variables
    )
    return not has_flow and (mesh.has_topology(data) or ocean.is_ocean(data))


def _variables(path):
    """The variables of a file by name, decoded except for times, and its attributes."""
    xarray, kind = needed("xarray"), path.suffix.lower()
    read = _zarr if path.is_dir() or kind == ".zarr" else _grib if kind.startswith(".gr") else _netcdf
    form = {_zarr: "Zarr", _grib: "GRIB", _netcdf: "NetCDF"}[read]
    if read == _netcdf:
        check_whole(path)
        needed("netCDF4")
    else:
        needed("zarr" if read == _zarr else "cfgrib")
    with Parsing(path, f"{form}'s library", read == _netcdf):
        try:
            return read(xarray, path)
        except InputError:
            raise
        except Exception as error:  # pylint: disable=broad-except  # the libraries raise any kind
            reason = str(getattr(error, "strerror", None) or error) or type(error).__name__
        # Here the error is gone, and with it the open file, which a library closes, and so parses once more.
    raise InputError(f"{path}: cannot be read as {form}: {reason}")


def _netcdf(xarray, path):
    """The variables of all groups; a name that several groups have gets the group's name before it."""
    found, attributes, groups = {}, {}, [""]
    with needed("netCDF4").Dataset(path) as data:
        stack = list(data.groups.values())
        while stack:
            group = stack.pop(0)
            groups.append(group.path.strip("/"))
            stack += group.groups.values()
    for group in groups:
        store = xarray.backends.NetCDF4DataStore.open(path, group=group or None)
        variables, own, _ = xarray.conventions.decode_cf_variables(
            *store.load(), decode_times=False, decode_coords=False
        )
        attributes = dict(own) | attributes
        for name, variable in variables.items():
            found[f"{group}/{name}" if name in found else name] = variable
    return found, attributes


def _zarr(xarray, path):
    data = xarray.open_dataset(
        path, engine="zarr", chunks=None, decode_times=False, decode_coords=False, consolidated=None, cache=False
    )
    return dict(data.variables), data.attrs


def _grib(xarray, path):  # pylint: disable=unused-argument
    """The messages of all levels and times; fields on other axes have their own."""
    logging.disable()  # cfgrib's, of messages that are left out
    keys = {"indexpath": "", "read_keys": ["uvRelativeToGrid"]}
    options = {"backend_kwargs": keys, "decode_times": False, "cache": False}
    found = {}
    for data in needed("cfgrib").open_datasets(str(path), **options):
        clash = any(n in found and not found[n].equals(v) for n, v in data.variables.items() if n in data.dims)
        if clash and set("uv") & set(data.variables):
            if set("uv") & set(found):
                raise InputError(
                    f"{path}: it holds winds on several sets of levels or times; keep one: grib_copy -w typeOfLevel=..."
                )
            found = {}
        elif clash:
            continue
        found.update(data.variables)
    grids = {name: variable.attrs.get("GRIB_gridType") for name, variable in found.items()}
    wanted = {"u", "v", "u10", "v10"} & grids.keys() or {name for name, grid in grids.items() if grid}
    if wanted and all(grids[name] in IRREGULAR for name in wanted):
        name = min(wanted)
        kind, mend = IRREGULAR[grids[name]]
        raise InputError(f"{path}: '{name}' is on {kind}; make a regular one of it: cdo {mend}")
    return found, {}
