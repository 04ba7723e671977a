"""The conversions of VDBLIC: flows of other programs into velocity volumes, and volumes into files for VTK and NumPy.

`import_tool` and `export_tool` are the tools `vdblic_import` and `vdblic_export`. They keep the rules of VDBLIC's other
tools: the same options, messages and exit statuses, outputs that appear complete or not at all.
"""

import os

os.environ["OPENVDB_DISABLE_DELAYED_LOAD"] = "1"  # OpenVDB would copy files, and tell of it on standard output
