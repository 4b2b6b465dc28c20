"""The verbs of the command line, one module each.

A verb reads files, calls one stage, and writes what it returns. `verbs` has their list, `flags` makes
flags of the stages' options, and `stage_io` has what all share: files, progress, warnings, errors. What
several verbs ask for stands in `mesh_flags`, `microstructure` and `run_deck`.
"""
