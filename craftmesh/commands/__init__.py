"""The subcommands of the command line, one module each.

A subcommand reads files, calls one stage, and writes the stage's results. `verbs` lists the subcommands,
`flags` makes flags from the stages' option classes, and `stage_io` has file flags, reports and warnings.
`mesh_flags`, `mesh_output`, `microstructure` and `run_deck` have code that several subcommands share.
"""
