"""The conversions of VDBLIC: flows of other programs into velocity volumes, and volumes into files for VTK and NumPy.

`import_tool` and `export_tool` are the tools `vdblic_import` and `vdblic_export`. They keep the rules of VDBLIC's other
tools: the same options, messages and exit statuses. Sequences, volumes and outputs are those of VDBLIC's library,
through the module `vdblic`.
"""
