"""The one family of errors that craftmesh raises on purpose."""


class CraftmeshError(Exception):
    """An input or a state that craftmesh refuses, said in one line that names what to do.

    The message names the key, file or grain, the value found, what is expected and what to do.
    The command line prints it as it is and exits with status 1.
    """
