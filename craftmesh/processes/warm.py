"""A server process that has modules and kernels loaded, and runs each subcommand in a forked child.

The start of a subcommand (Python, libraries, machine code of kernels) takes longer than the work on a small
increment. Snakemake's process starts the server. A subcommand that Snakemake starts then is a client: it
sends its words, folder, environment and open files to the server, and waits. The server forks a child that
runs the subcommand. The child inherits nothing from other subcommands. If the child had to load modules or
kernels, the server loads them before it forks the next child for the same subcommand.

If a client ends, its child is killed. The server ends with its owner; running children continue.
"""

import gc
import json
import os
import pickle
import signal
import socket
import struct
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from importlib import import_module
from typing import Any

from craftmesh.errors import CraftmeshError

# Environment variable: sys.prefix of the server's Python, and the name of its socket.
VARIABLE = "CRAFTMESH_WARM"
_SERVE = "import sys; from craftmesh.cli import serve_verbs; serve_verbs(int(sys.argv[1]))"
PROCESS_USER_GROUP = "3i"  # struct format of the ids that SO_PEERCRED returns


def start() -> None:
    """Start a server that ends with this process; subcommands find it by an environment variable."""
    import atexit
    import subprocess
    from uuid import uuid4

    name = f"craftmesh-{uuid4().hex}"
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(f"\0{name}")  # an abstract name; a file would remain after a kill
        listener.listen()
        number = listener.fileno()
        command = [sys.executable, "-P", "-c", _SERVE, str(number)]
        server = subprocess.Popen(
            command, pass_fds=[number], stdin=subprocess.PIPE, stdout=subprocess.DEVNULL
        )
    os.environ[VARIABLE] = f"{sys.prefix}:{name}"
    atexit.register(server.communicate)


def status_of(words: Sequence[str]) -> int | None:
    """Let the server run a subcommand, and return its exit status; None without a server of this Python.

    words: the command line. The status is 128 + n if signal n ended the subcommand. Raises CraftmeshError
    if the server ends before the subcommand.
    """
    prefix, _, name = os.environ.get(VARIABLE, "").rpartition(":")
    if prefix != sys.prefix:
        return None
    request = os.memfd_create("request")
    with socket.socket(socket.AF_UNIX) as connection:
        try:
            connection.connect(f"\0{name}")
        except OSError:
            return None
        if not _is_ours(connection):
            return None
        os.write(request, json.dumps([list(words), os.getcwd(), dict(os.environ)]).encode())
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # the child handles it and prints a message
        socket.send_fds(connection, [b" "], [0, 1, 2, request])
        answer = connection.recv(8)
    if not answer:
        raise CraftmeshError("the server that runs subcommands has ended; give the same command again")
    status = int(answer)
    return status if status >= 0 else 128 - status


def _is_ours(connection: socket.socket) -> bool:
    """Return True if the process at the other end of a connection belongs to the same user."""
    found = connection.getsockopt(
        socket.SOL_SOCKET, socket.SO_PEERCRED, struct.calcsize(PROCESS_USER_GROUP)
    )
    return struct.unpack(PROCESS_USER_GROUP, found)[1] == os.getuid()


class Loader:
    """Loads in the server the modules and kernels that its children had to load.

    load: function that loads a subcommand's module; missing: modules and kernels that children of a
    subcommand had to load and the server has not yet loaded, by subcommand.
    """

    def __init__(self, load: Callable[[str], Any]):
        self.load = load
        self.missing: dict[str, tuple[list[str], list]] = {}

    def prepare(self, verb: str) -> None:
        """Load a subcommand's module, and the modules and kernels that its last child had to load.

        Errors are ignored here; the child reports them.
        """
        modules, kernels = self.missing.pop(verb, ([], []))
        with suppress(Exception):
            self.load(verb)
            for name in modules:
                with suppress(ImportError):
                    import_module(name)
            for module, name, kind in kernels:
                getattr(sys.modules[module], name).compile(kind)  # from the cache
        gc.freeze()  # else each child's garbage collection would copy this memory

    def run(self, run: Callable[[list[str]], int], words: list[str], missing: int) -> int:
        """Run a subcommand, in the child, and return its exit status.

        The names of modules and kernels that it had to load are written to the open file with the
        descriptor `missing`, for `learn`. run: function that runs a command line; words: the command line.
        """
        modules, kernels = set(sys.modules), _loaded_kernels()
        status = run(words)
        found = [name for name in sys.modules if name not in modules], _loaded_kernels() - kernels
        with suppress(Exception), os.fdopen(missing, "wb") as stream:
            pickle.dump(found, stream)
        return status

    def learn(self, verb: str, missing: int) -> None:
        """Read which modules and kernels a subcommand's ended child had to load; a killed child wrote none.

        missing: descriptor of the open file that `run` wrote; it is closed here.
        """
        with suppress(EOFError, pickle.UnpicklingError), os.fdopen(missing, "rb") as stream:
            stream.seek(0)
            self.missing[verb] = pickle.load(stream)


def _loaded_kernels() -> set[tuple[str, str, tuple]]:
    """Return (module, name, argument types) of each kernel that is compiled in this process."""
    return {
        (module, name, kind)
        for module in list(sys.modules)
        if ".kernels." in module
        for name, value in vars(sys.modules[module]).items()
        for kind in getattr(value, "overloads", ())
    }


def _exit(status: int) -> None:
    """Run exit functions, flush the output, and end this child without the parent's clean-up."""
    import atexit

    with suppress(BaseException):
        atexit._run_exitfuncs()
        sys.stdout.flush()
        sys.stderr.flush()
    os._exit(status & 0xFF)


class _Child:
    """A running subcommand.

    `verb`: its name; connection: to its client; missing: number of the file for what it loads; pid: its
    process.
    """

    def __init__(self, verb: str, connection: socket.socket, missing: int, pid: int):
        self.verb, self.connection, self.missing, self.pid = verb, connection, missing, pid
        self.end = os.pidfd_open(pid)  # can be read when the child has ended

    def answer(self) -> None:
        """Send the ended child's status, negative for a signal, to the client if it still waits."""
        _, status = os.waitpid(self.pid, 0)
        with suppress(OSError):
            self.connection.send(str(os.waitstatus_to_exitcode(status)).encode())
        self.connection.close()
        os.close(self.end)


def serve(number: int, run: Callable[[list[str]], int], load: Callable[[str], Any]) -> None:
    """Serve clients at the socket with the file number `number` until the standard input is closed.

    run: runs a command line and returns its exit status. load: loads a subcommand's module.
    """
    import select

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the children handle it
    listener, loader = socket.socket(fileno=number), Loader(load)
    children: list[_Child] = []
    while True:
        ends, clients = {one.end: one for one in children}, {one.connection: one for one in children}
        ready = select.select([sys.stdin, listener, *ends, *clients], [], [])[0]
        if sys.stdin in ready:
            return
        for one in [ends[end] for end in ends if end in ready]:
            children.remove(one)
            one.answer()
            loader.learn(one.verb, one.missing)
        for one in children:
            if one.connection in ready:  # a client sends nothing more, so it has ended
                signal.pidfd_send_signal(one.end, signal.SIGKILL)
        if listener in ready:
            connection, _ = listener.accept()
            if _is_ours(connection):
                children.append(_child_for(connection, loader, run))


def _child_for(connection: socket.socket, loader: Loader, run: Callable[[list[str]], int]) -> _Child:
    """Read a client's request, fork a child that runs its subcommand, and return the child."""
    *files, request = socket.recv_fds(connection, 1, 4)[1]
    with os.fdopen(request, "rb") as stream:
        stream.seek(0)
        words, folder, environment = json.load(stream)
    verb = words[0] if words else ""
    loader.prepare(verb)
    missing = os.memfd_create("missing")
    pid = os.fork()
    if not pid:
        status = 1
        try:
            for place, file in enumerate(files):
                os.dup2(file, place)
            os.chdir(folder)
            os.environ.clear()
            os.environ.update(environment)
            signal.signal(signal.SIGINT, signal.default_int_handler)
            status = loader.run(run, words, missing)
        except SystemExit as end:
            status = end.code if isinstance(end.code, int) else int(end.code is not None)
        except BaseException:
            sys.excepthook(*sys.exc_info())
        finally:
            _exit(status)
    for file in files:
        os.close(file)
    return _Child(verb, connection, missing, pid)
