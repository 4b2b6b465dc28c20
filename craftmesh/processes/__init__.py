"""Programs that may crash or hang, each in a process with limits."""
