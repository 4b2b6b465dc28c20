"""Programs and tasks that may crash or hang, each in a process with limits.

`job` runs a program under limits of time and memory, and defines the jobs of workers; a failure comes back
as text. `worker` runs tasks on worker processes and replaces a worker that ends. `guard` ends a program
and its children when the owner ends. `warm` runs subcommands in children of a process that has all modules
loaded, and `costs` writes their time and memory. `abaqus_displacements` runs in Abaqus' own Python, so it
imports nothing of craftmesh.
"""
