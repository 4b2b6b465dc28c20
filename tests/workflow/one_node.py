"""A real Slurm of one node, this machine, that listens on the loopback address alone."""

import os
import secrets
import shutil
import socket
import subprocess
import time
from contextlib import contextmanager
from pathlib import Path

PACKAGES = ("slurm-wlm", "slurm-client", "munge")
PROGRAMS = ("slurmctld", "slurmd", "munged", "sbatch")
# the step daemon forgets every variable SLURM_*, so no other place will do
CONFIGURATION = Path("/etc/slurm/slurm.conf")
MEMORY_MB = 6000
CPUS = 2
STARTS_WITHIN = 60  # seconds


def reason_to_skip() -> str:
    """Return why no Slurm can be set up here, or an empty text."""
    if os.geteuid() != 0:
        return "a Slurm of one node needs root"
    missing = [name for name in PROGRAMS if shutil.which(name) is None]
    if missing and shutil.which("apt-get") is None:
        return f"{', '.join(missing)} not installed, and there is no apt-get"
    if CONFIGURATION.exists():
        return f"this machine has a Slurm of its own: {CONFIGURATION}"
    return ""


def install() -> str:
    """Install Debian's Slurm where it is missing; return what went wrong, or an empty text."""
    if all(shutil.which(name) for name in PROGRAMS):
        return ""
    command = ["apt-get", "install", "-y", "--no-install-recommends", *PACKAGES]
    env = os.environ | {"DEBIAN_FRONTEND": "noninteractive"}
    done = subprocess.run(command, env=env, capture_output=True, text=True)
    return "" if done.returncode == 0 else f"apt-get install failed: {done.stderr[-300:]}"


@contextmanager
def one_node_slurm(folder: Path):
    """Run munged, slurmctld and slurmd with their files in `folder`, and end them after use."""
    for name in ("state", "spool"):
        (folder / name).mkdir(parents=True)
    key = folder / "munge.key"
    key.write_bytes(secrets.token_bytes(128))
    key.chmod(0o400)
    CONFIGURATION.write_text(configuration(folder))
    commands = [
        ["munged", "--foreground", "--force", f"--key-file={key}", f"--socket={folder}/munge.socket"]
        + [f"--{what}-file={folder}/munge.{what}" for what in ("pid", "log", "seed")],
        ["slurmctld", "-D"],
        ["slurmd", "-D", "-N", name_of_host()],
    ]
    daemons = []
    try:
        with open(folder / "daemons.txt", "w") as log:
            for command in commands:
                daemons.append(subprocess.Popen(command, stdout=log, stderr=log))
                time.sleep(1)
            wait_until_idle(folder)
            yield
    finally:
        for daemon in reversed(daemons):
            daemon.terminate()
            daemon.wait(30)
        CONFIGURATION.unlink()


def name_of_host() -> str:
    return socket.gethostname().partition(".")[0]


def wait_until_idle(folder: Path):
    """Return as soon as the node takes jobs."""
    said = ""
    for _ in range(STARTS_WITHIN):
        done = subprocess.run(["sinfo", "-h", "-o", "%T"], capture_output=True, text=True)
        said = done.stdout + done.stderr
        if done.stdout.strip() == "idle":
            return
        time.sleep(1)
    raise RuntimeError(f"Slurm did not start: {said} {(folder / 'daemons.txt').read_text()[-2000:]}")


def configuration(folder: Path) -> str:
    """Return slurm.conf: memory is held, nothing is accounted, and processes are known by their parents."""
    host = name_of_host()
    return f"""
ClusterName=onenode
SlurmctldHost={host}(127.0.0.1)
AuthInfo=socket={folder}/munge.socket
SlurmUser=root
SlurmdUser=root
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
CommunicationParameters=NoInAddrAny,NoCtldInAddrAny
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/linux
JobAcctGatherFrequency=task=1
JobAcctGatherParams=OverMemoryKill
ReturnToService=2
MinJobAge=3600
SchedulerParameters=sched_interval=2
NodeName={host} NodeAddr=127.0.0.1 CPUs={CPUS} RealMemory={MEMORY_MB} State=UNKNOWN
PartitionName=work Nodes={host} Default=YES MaxTime=INFINITE State=UP
"""
