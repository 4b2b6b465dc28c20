"""Programs that may crash or hang, each in a process with limits.

`job` runs a program or names a function with its limits of time and memory; a failure comes back as
words. `worker` keeps processes that take one task after another and outlives those that end.
`warm` runs verbs in children of a process that has all loaded, and `costs` writes what they took.
`abaqus_displacements` is run by Abaqus' own Python and imports nothing.
"""
