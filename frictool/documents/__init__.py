"""The YAML documents that pass between commands: frozen types, strict reading and writing.

`bench` -> `model` -> (with `spec` and `design`) `controller` -> (with `scenario`) logs and the verdict.
"""
